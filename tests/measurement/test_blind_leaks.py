"""What is hidden shows in nothing but the torques: no name, header, size or time of a file tells it."""

import re

import numpy as np
import pytest

from exoid.measurement.bench.blind import write_runs
from exoid.measurement.bench.hidden import Hidden
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.measurement.reading.read import read_recording
from exoid.symbolic.effect_catalogue import catalogue

SHORT = Bench(duration=4.0)
HIDDEN = ((), (Hidden("stribeck", "knee"),), (Hidden("gravity_tilt"), Hidden("torque_ripple", "hip")))


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    made = []
    for k, hidden in enumerate(HIDDEN):
        folder = tmp_path_factory.mktemp(f"blind{k}")
        write_runs(folder, simulate_runs(2, effects=hidden, seed=5, bench=SHORT))
        made.append(folder)
    return made


def test_names_headers_and_lengths_are_those_of_any_other(folders):
    looks = []
    for folder in folders:
        files = sorted(folder.iterdir())
        texts = [file.read_text() for file in files if file.suffix == ".csv"]
        looks.append(([file.name for file in files], [(text.splitlines()[0], text.count("\n")) for text in texts]))
    assert looks[0] == looks[1] == looks[2]


def test_recordings_hold_numbers_only(folders):
    for file in (file for folder in folders for file in folder.glob("*.csv")):
        body = file.read_text().partition("\n")[2]
        assert re.fullmatch(r"[-0-9.e,\n]*", body)
        stamps = np.loadtxt(file, delimiter=",", skiprows=1)[:, 0]
        np.testing.assert_allclose(stamps, np.arange(400) / 100.0)


def test_neither_content_nor_length_of_the_seal_tells(folders):
    seals = [(folder / "truth.seal").read_text() for folder in folders]
    assert len({len(seal) for seal in seals}) == 1
    words = {*catalogue(), "hip", "knee", "effects", "seed", "standard"}
    assert not any(re.search(rf"\b{word}\b", seal) for seal in seals for word in words)


@pytest.mark.parametrize("kind", ["npz", "h5", "mat"])
def test_what_was_read_is_written_on_without_a_trace(folders, tmp_path, kind):
    """A recording carries nothing but its columns into another format."""
    recording = read_recording(folders[1] / "run_0.csv")
    columns, path = recording.columns(), tmp_path / f"run.{kind}"
    if kind == "npz":
        np.savez(path, **columns)
    elif kind == "mat":
        pytest.importorskip("scipy.io").savemat(path, columns)
    else:
        with pytest.importorskip("h5py").File(path, "w") as file:
            for name, column in columns.items():
                file[name] = column
    assert set(columns) == {"t", "q1", "q2", "tau1", "tau2"}
    assert not any(name.encode() in path.read_bytes() for name in catalogue())
    np.testing.assert_array_equal(read_recording(path).tau, recording.tau)
