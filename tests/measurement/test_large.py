"""Files too long for memory: pieces of the same file say what the whole would say."""

import numpy as np
import pandas as pd
import pytest
from tables import leg

from exoid.ground.errors import RecordingError
from exoid.measurement.reading import large
from exoid.measurement.reading.read import read_recordings


@pytest.fixture(scope="module")
def day():
    """A leg at 100 Hz that rests in the first half and moves in the second, 300 s."""
    columns = leg(30_000)
    still = np.arange(30_000) < 12_000
    for name in ("q1", "q2", "tau1", "tau2"):
        columns[name] = np.where(still, columns[name][12_000] + 1e-3 * np.random.default_rng(0).normal(size=30_000),
                                 columns[name])  # fmt: skip
    return pd.DataFrame(columns)


@pytest.mark.slow
def test_stretches_of_a_long_text_are_the_rows_of_the_file(day, tmp_path):
    path = tmp_path / "day.csv"
    path.write_text("# made by a logger\n" + day.to_csv(index=False))
    seen = []
    runs = read_recordings([path], most_bytes=1_200_000, progress=lambda share, text: seen.append(share))
    assert len(runs) > 1 and seen == sorted(seen) and seen[-1] == 1.0
    for run in runs:
        first = int(run.row[0]) - 3
        np.testing.assert_allclose(run.q[:, 0], day["q1"].to_numpy()[first : first + len(run)], atol=0.05)
    assert runs[0].findings[0].check == "large" and "30000 rows" in runs[0].findings[0].what
    assert all(run.duration < 151 for run in runs)


def test_parquet_is_cut_alike(day, tmp_path):
    pytest.importorskip("pyarrow")
    path = tmp_path / "day.parquet"
    day.to_parquet(path, row_group_size=5_000)
    runs = read_recordings([path], most_bytes=1_200_000)
    assert len(runs) > 1 and len({run.name for run in runs}) == len(runs)
    run = runs[-1]
    first = int(run.row[0]) - 1
    np.testing.assert_allclose(run.tau[:, 1], day["tau2"].to_numpy()[first : first + len(run)])


@pytest.mark.slow
def test_a_measured_base_is_cut_with_its_recording(day, tmp_path, monkeypatch):
    monkeypatch.setattr(large, "STRETCH", 20.0)
    path = tmp_path / "day.csv"
    path.write_text(day.assign(base_angle=0.01 * np.sin(day["t"])).to_csv(index=False))
    for run in read_recordings([path], most_bytes=1_200_000):
        np.testing.assert_allclose(run.base[:, 0], 0.01 * np.sin(day["t"].to_numpy()[run.row - 2]), atol=1e-9)


@pytest.mark.slow
def test_what_is_wrong_in_one_piece_is_said(day, tmp_path):
    table = day.copy()
    table.loc[20_000:20_100, "q1"] = np.nan
    path = tmp_path / "day.csv"
    path.write_text(table.to_csv(index=False))
    found = read_recordings([path], most_bytes=1_200_000)[0].findings
    assert any(f.check == "cells" and "row" in f.where and "2000" in f.where for f in found)


def test_a_long_file_that_cannot_be_read_says_why(day, tmp_path):
    path = tmp_path / "day.csv"
    path.write_text(day.rename(columns={"q2": "x"}).to_csv(index=False))
    with pytest.raises(RecordingError, match="no column for q2"):
        read_recordings([path], most_bytes=1_200_000)
