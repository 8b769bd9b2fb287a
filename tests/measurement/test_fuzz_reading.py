"""Whatever a file holds, it is read or refused; nothing else ever escapes."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tables import HEADER, lines

from exoid.ground.errors import ExoidError
from exoid.measurement.reading.clock import longest_increasing
from exoid.measurement.reading.raw import column_from_cells
from exoid.measurement.reading.read import read_recording
from exoid.measurement.recording import Recording, to_csv

GOOD = lines()[1:120]
CALM = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
)
CELL = st.one_of(
    st.floats(width=32).map(repr),
    st.sampled_from(
        [
            "",
            "nan",
            "inf",
            "-inf",
            "1e999",
            "-1e308",
            "1,5",
            "abc",
            '"',
            '"1"',
            "0x10",
            "1_0",
            "١",
            "1e-320",
            "#",
            "True",
            "2024-01-01T00:00:00",
            "12:00:00",
            "-",
            "\x00",
            "NaT",
            "1" * 400,
        ]
    ),
    st.text(max_size=4),
)


def read(tmp_path, data, name="fuzz.csv", **options):
    path = tmp_path / name
    path.write_bytes(data)
    try:
        recording = read_recording(path, **options)
    except ExoidError as error:
        assert str(error)
        return None
    assert isinstance(recording, Recording)
    assert np.isfinite(recording.q).all() and np.all(np.diff(recording.t) > 0)
    assert path.read_bytes() == data
    return recording


@pytest.mark.slow
@CALM
@given(st.binary(max_size=600))
def test_random_bytes(tmp_path, data):
    for name in ("a.csv", "a.npz", "a.mat", "a.h5", "a.parquet"):
        read(tmp_path, data, name)


@pytest.mark.slow
@CALM
@given(st.text(max_size=400))
def test_random_text(tmp_path, text):
    read(tmp_path, text.encode("utf-8", "surrogatepass"))
    read(tmp_path, (HEADER + "\n" + text).encode("utf-8", "surrogatepass"))


@pytest.mark.slow
@CALM
@given(
    st.lists(st.tuples(st.integers(0, 118), st.integers(0, 4), CELL), max_size=8),
    st.sampled_from([",", ";", "\t", " "]),
)
def test_good_rows_with_wild_cells(tmp_path, changes, sep):
    rows = [row.split(",") for row in GOOD]
    for row, column, cell in changes:
        rows[row][column] = cell
    text = "\n".join([HEADER.replace(",", sep), *(sep.join(row) for row in rows)])
    read(tmp_path, text.encode("utf-8", "surrogatepass"))


@pytest.mark.slow
@CALM
@given(st.lists(st.lists(CELL, min_size=5, max_size=5), max_size=30))
def test_wild_tables(tmp_path, rows):
    text = "\n".join([HEADER, *(",".join(row) for row in rows), *GOOD[:60]])
    read(tmp_path, text.encode("utf-8", "surrogatepass"))


@pytest.mark.slow
@CALM
@given(
    st.dictionaries(st.text(max_size=5), st.text(max_size=12), max_size=3),
    st.lists(st.text(max_size=9), min_size=5, max_size=5),
)
def test_wild_options_and_headers(tmp_path, options, names):
    data = "\n".join([HEADER, *GOOD]).encode()
    read(tmp_path, data, columns=options)
    read(tmp_path, data, units=options)
    read(tmp_path, data, units=dict.fromkeys(("q", "t", "tau1"), next(iter(options.values()), "rad")))
    read(tmp_path, "\n".join([",".join(names), *GOOD]).encode("utf-8", "surrogatepass"))


@CALM
@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=80, max_size=80))
def test_wild_clocks(tmp_path, stamps):
    rows = [f"{t!r}," + row.split(",", 1)[1] for t, row in zip(stamps, GOOD, strict=False)]
    recording = read(tmp_path, "\n".join([HEADER, *rows]).encode())
    if recording is not None:
        to_csv(recording)


@given(st.lists(st.integers(-20, 20), max_size=30))
def test_the_longest_increasing_chain_is_increasing_and_longest(values):
    chain = longest_increasing(np.array(values, dtype=float))
    picked = [values[i] for i in chain]
    assert picked == sorted(set(picked)) and sorted(chain) == list(chain)
    best: list[int] = []
    for i, value in enumerate(values):
        best.append(1 + max((best[j] for j in range(i) if values[j] < value), default=0))
    assert len(picked) == max(best, default=0)


@given(st.lists(st.one_of(st.text(max_size=6), st.floats(), st.integers(), st.booleans(), st.none()), max_size=20))
def test_any_cells_make_a_column(cells):
    column = column_from_cells("x", np.array(cells, dtype=object))
    assert column.values.shape == (len(cells),)
    assert column.text_count >= len(column.texts)
