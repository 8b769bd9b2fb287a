"""Units nobody wrote down: what the audit says when the numbers are those of no leg."""

import sys
from pathlib import Path

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.read import read_recording
from exoid.measurement.reading.units import factor

sys.path.insert(0, str(Path(__file__).parents[1] / "measurement"))
from tables import leg, text


def said(tmp_path, columns, **options):
    path = tmp_path / "run.csv"
    path.write_text(text(columns))
    recording = read_recording(path, **options)
    return recording, {f.what for f in recording.findings if f.severity != "info" and f.check in ("units", "time")}


def changed(**factors):
    return {name: values * factors.get(name.rstrip("12"), 1.0) for name, values in leg().items()}


def test_a_usual_leg_is_not_remarked_on(tmp_path):
    assert said(tmp_path, leg())[1] == set()


@pytest.mark.slow
@pytest.mark.parametrize("factors, words", [
    ({"tau": 1e-3}, "kN·m"), ({"tau": 1e-6}, "MN·m"), ({"tau": 1e3}, "mN·m"),
    ({"q": 0.5 / np.pi}, "turns"), ({"q": 180 / np.pi}, "degrees"),
])  # fmt: skip
def test_a_unit_that_makes_no_leg_is_named(tmp_path, factors, words):
    found = said(tmp_path, changed(**factors))[1]
    assert any(words in what for what in found), found


def test_what_it_advises_helps(tmp_path):
    for factors, units in (({"tau": 1e-3}, {"tau": "kNm"}), ({"tau": 1e-6}, {"tau": "MNm"}),
                           ({"q": 0.5 / np.pi}, {"q": "turns"})):  # fmt: skip
        recording, found = said(tmp_path, changed(**factors), units=units)
        assert not found
        np.testing.assert_allclose(recording.tau[:, 0], leg()["tau1"], rtol=1e-6)


def test_mega_is_not_milli():
    assert [factor("tau", unit) for unit in ("MNm", "MN·m", "mNm", "mN·m", "kNm", "Nm", "NM")] == [
        1e6, 1e6, 1e-3, 1e-3, 1e3, 1.0, 1.0
    ]  # fmt: skip
    assert (factor("f", "MN"), factor("f", "mN"), factor("tau", "MNM")) == (1e6, 1e-3, None)
    assert (factor("t", "MS"), factor("t", "ms")) == (1e-3, 1e-3)


@pytest.mark.parametrize("unit", ["-1 s", "-s", "-ms", "-10 ms", "-2*s"])
def test_time_does_not_count_backwards(tmp_path, unit):
    path = tmp_path / "run.csv"
    path.write_text(text())
    with pytest.raises(RecordingError, match=r"backwards|not known"):
        read_recording(path, units={"t": unit})


def test_rows_that_are_turned_round_say_what_that_means(tmp_path):
    backwards = {name: values[::-1] for name, values in leg().items()}
    recording, found = said(tmp_path, backwards)
    (finding,) = (f for f in recording.findings if f.check == "time")
    assert finding.severity == "warning" and "every velocity" in finding.what and "friction" in finding.consequence
    assert found == {finding.what}
