"""Motors that turn with several joints: the model says how, recordings hold either side."""

import numpy as np
import pytest

from exoid.ground.errors import ModelFileError
from exoid.measurement.reading.conventions import read_as
from exoid.measurement.recording import Recording
from exoid.symbolic import read_model, write_model

TEXT = """
name = "wrist"
[[joints]]
name = "bend"
axis = [0, 1, 0]
[[joints]]
name = "roll"
axis = [0, 0, 1]
origin = {{ xyz = [0.1, 0, 0.2] }}
[[couplings]]
motor = "roll"
turns = {turns}
[[couplings]]
motor = "bend"
turns = {{ bend = 45.0 }}
"""


def wrist(tmp_path, turns="{ bend = 32.0, roll = -32.0 }"):
    path = tmp_path / "wrist.toml"
    path.write_text(TEXT.format(turns=turns))
    return read_model(path)


def test_recordings_of_motors_are_those_of_the_joints(tmp_path):
    model = wrist(tmp_path)
    rng = np.random.default_rng(1)
    t, q, tau = np.arange(50) / 100.0, rng.normal(size=(50, 2)), rng.normal(size=(50, 2))
    motors, work = np.column_stack([45.0 * q[:, 0], 32.0 * (q[:, 0] - q[:, 1])]), tau
    found = read_as(Recording("run", t, motors, work, joints=model.joints), "motors")
    shift = found.q - q
    np.testing.assert_allclose(shift - shift[0], 0.0, atol=1e-12)  # whole turns are taken off
    # The power of the motors is that of the joints, whichever way they turn.
    power = np.sum(np.diff(found.q, axis=0) * found.tau[1:], axis=1)
    np.testing.assert_allclose(power, np.sum(np.diff(motors, axis=0) * work[1:], axis=1), atol=1e-9)
    torques = read_as(Recording("run", t, q, work, joints=model.joints), "motors-torques")
    np.testing.assert_allclose(torques.tau, found.tau)
    np.testing.assert_array_equal(torques.q, q)


def test_a_model_file_keeps_its_couplings(tmp_path):
    model = wrist(tmp_path)
    assert read_model(write_model(model, tmp_path / "again.toml")).joints == model.joints


@pytest.mark.parametrize(
    ("turns", "said"),
    [
        ("{ bend = 32.0 }", "do not tell those of the joints"),
        ("{ neck = 32.0, roll = 1.0 }", "neck"),
        ("{ roll = 0.0 }", "turns with nothing"),
        ("{}", "turns with nothing"),
    ],
)
def test_what_is_no_coupling_is_refused_with_its_line(tmp_path, turns, said):
    with pytest.raises(ModelFileError) as found:
        wrist(tmp_path, turns)
    assert said in str(found.value)
    assert "line" in str(found.value)
