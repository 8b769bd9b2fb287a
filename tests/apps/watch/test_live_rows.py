"""Lines of a stream: what their columns are, and what is no sample."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exoid.apps.watch.io.growing import Text, grown
from exoid.apps.watch.live import Lines
from exoid.ground.errors import RecordingError
from exoid.measurement.reading.mapping import StatedMapping
from exoid.measurement.reading.sniff import LONGEST_LINE

HEADER = "t,q1,q2,tau1,tau2\n"


def rows(first: int, last: int, step: float = 0.01) -> str:
    return "".join(f"{k * step:.3f},0.1,0.2,3,4\n" for k in range(first, last))


def events(lines: Lines) -> list[tuple[str, int]]:
    return [(note.event, note.line) for note in lines.taken()]


def test_lines_of_csv_come_in_pieces_and_bad_ones_are_told() -> None:
    lines = Lines()
    text = "time;hip_angle [deg];knee_angle [deg];hip_torque;knee_torque\n0,0;10;20;1;2\nrubbish\n0,01;10;20;1"
    assert not len(lines.feed(text))  # the second sample tells that the clock is in s
    found = lines.feed(",5;2\n0,02;nan;1;1;1\n")
    assert found.shape == (3, 5)
    assert found[0, 1] == pytest.approx(np.deg2rad(10.0))
    assert found[1, 3] == pytest.approx(1.5)
    assert np.isnan(found[2, 1])
    assert events(lines) == [("skipped", 3)]


def test_json_lines_may_hold_lists_and_names_in_any_order() -> None:
    lines = Lines()
    text = '{"tau": [1, 2], "q": [0.1, 0.2], "t": 0.5}\n{"t": 1}\n[1]\n{"t": 0.51, "q": [1, null], "tau": [0, 0]}\n'
    found = lines.feed(text + '{"t": 1, "q": [1, 1e999], "tau": [0, "x"]}\n', last=True)
    np.testing.assert_allclose(found, [[0.5, 0.1, 0.2, 1.0, 2.0], [0.51, 1.0, np.nan, 0.0, 0.0]])
    assert lines.skipped_count == 3
    huge = json.dumps({"t": 0.52, "q": [1, 10**400], "tau": [0, 0]})
    lines.feed(huge + "\n")
    assert lines.skipped_count == 4


def test_columns_that_are_not_there_are_refused() -> None:
    with pytest.raises(RecordingError, match="tau"):
        Lines().feed("t,q1,q2\n0,0,0\n")
    with pytest.raises(RecordingError, match="tau"):
        Lines().feed('{"t": 1, "q": [1, 2]}\n')


@pytest.mark.parametrize(
    "banner",
    ["Logger v1.2 started\n", "Run 7, subject A, left, slow, 3 kg\n", "# by hand, on Monday\n", "\n\n", "\ufeff",
     '{"message": "started", "version": 2}\n', "date;12.3.2026\nsubject;A\n"],
)  # fmt: skip
@pytest.mark.parametrize("header", [HEADER, "# t q1 q2 tau1 tau2\n".replace(" ", ",").replace("#,", "# ")])
def test_a_banner_above_the_names_is_passed_over(banner: str, header: str) -> None:
    lines = Lines()
    found = lines.feed(banner + header.replace("q1,q2", "q2,q1") + rows(0, 3))
    np.testing.assert_allclose(found[:, 1:], [[0.2, 0.1, 3.0, 4.0]] * 3)


def test_units_may_stand_in_a_row_of_their_own() -> None:
    found = Lines().feed(HEADER + "s,deg,deg,Nm,Nm\n" + rows(0, 2))
    np.testing.assert_allclose(found[0, 1:3], np.deg2rad([0.1, 0.2]))


@pytest.mark.parametrize(
    ("header", "row", "wanted"),
    [
        ("t,tau2,tau1,q2,q1\n", "0.03,4,3,0.2,0.1\n", [0.1, 0.2, 3.0, 4.0]),
        ("t,q1 [deg],q2 [deg],tau1,tau2\n", "0.03,180,-90,3,4\n", [np.pi, -np.pi / 2, 3.0, 4.0]),
        ("time;theta1;theta2;hip_torque;knee_torque;temperature\n", "0,03;0,1;0,2;3;4;20\n", [0.1, 0.2, 3.0, 4.0]),
        ("Logger restarted\n# unit of time is s\n" + "t,q2,q1,tau1,tau2\n", "0.03,0.2,0.1,3,4\n", [0.1, 0.2, 3.0, 4.0]),
    ],
)
def test_a_logger_that_starts_again_says_anew_what_its_columns_are(header: str, row: str, wanted: list[float]) -> None:
    lines = Lines()
    lines.feed(HEADER + rows(0, 3))
    assert not events(lines)
    found = lines.feed(header + row + row.replace("03", "04", 1))
    np.testing.assert_allclose(found[:, 1:], [wanted, wanted])
    assert "columns" in [event for event, _ in events(lines)]


def test_the_same_names_again_are_nothing_to_tell() -> None:
    lines = Lines()
    found = lines.feed((HEADER + rows(0, 3)) * 3)
    assert len(found) == 9
    assert not events(lines)


def test_names_that_no_longer_suffice_stop_the_reading_until_others_come() -> None:
    lines = Lines()
    lines.feed(HEADER + rows(0, 3))
    assert not len(lines.feed("t,q1,q2,current1,current2\n" + rows(3, 6)))
    told = lines.taken()
    assert "tau" in told[0].what
    assert len(lines.feed(HEADER + rows(6, 9))) == 3
    assert events(lines) == [("columns", 10)]


def test_keys_of_objects_may_become_others() -> None:
    lines = Lines()
    lines.feed("".join(json.dumps({"t": k / 100, "q": [1, 2], "tau": [3, 4]}) + "\n" for k in range(3)))
    other = {"time": 0.03, "hip_angle": 1, "knee_angle": 2, "hip_torque": 3, "knee_torque": 4}
    found = lines.feed(json.dumps(other) + "\n" + json.dumps(other | {"time": 0.04}) + "\n")
    np.testing.assert_allclose(found[:, 1:], [[1, 2, 3, 4]] * 2)
    assert [event for event, _ in events(lines)] == ["columns"]


def test_two_lines_run_into_one_are_no_sample() -> None:
    lines = Lines()
    found = lines.feed(HEADER + rows(0, 2) + "0.020,0.1,0.0.030,0.1,0.2,3,4\n0.04,0.1\n" + rows(5, 6))
    assert len(found) == 3
    assert events(lines) == [("skipped", 4), ("skipped", 5)]


def test_a_clock_in_ms_is_read_as_in_a_file_and_a_mere_count_is_refused() -> None:
    lines = Lines()
    t = 10.0 * np.arange(60)
    text = "".join(f"{x:g},{np.sin(x / 1000):.6f},{np.cos(x / 900):.6f},3,4\n" for x in t)
    found = lines.feed(HEADER + text)
    np.testing.assert_allclose(found[:, 0], t / 1000)
    assert "read in ms" in lines.taken()[0].what
    with pytest.raises(RecordingError, match="row numbers"):
        Lines().feed(HEADER + "".join(f"{k},{np.sin(k / 100):.6f},0.2,3,4\n" for k in range(60)))
    told = Lines(told=StatedMapping({}, {"t": "ms"})).feed(HEADER + "0,0,0,0,0\n")
    assert told.shape == (1, 5)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("size", [1, 3, 64])
def test_text_may_come_in_any_encoding_and_in_pieces_of_any_size(encoding: str, end: str, size: int) -> None:
    data = (HEADER + rows(0, 5)).replace("\n", end).encode(encoding)
    text, lines = Text(), Lines()
    parts = [lines.feed(text.decode(data[k : k + size])) for k in range(0, len(data), size)]
    assert len(np.concatenate([*parts, lines.feed("", last=True)])) == 5
    assert not lines.taken()


def test_a_line_of_a_megabyte_is_passed_over_and_not_kept() -> None:
    lines = Lines()
    lines.feed(HEADER + rows(0, 2))
    for _ in range(20):
        lines.feed("1" * 50_000)
        assert len(lines.rest) <= LONGEST_LINE
    assert len(lines.feed("\n" + rows(2, 4))) == 2
    assert events(lines) == [("skipped", 4)]


def test_a_file_in_utf_16_is_followed(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(HEADER + rows(0, 3), encoding="utf-16")
    lines = Lines()
    assert len(np.concatenate([lines.feed(text or "") for text in grown(path, False)])) == 3


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(st.lists(st.text(st.sampled_from('0123456789.,;:-+e{}[]"tq_au# \t\r\nnaif\x00\ufeff'), max_size=60), max_size=6))
def test_whatever_comes_is_read_or_refused_in_words(pieces: list[str]) -> None:
    lines = Lines()
    try:
        for piece in [HEADER, *pieces, "\n" + rows(0, 3)]:
            found = lines.feed(piece)
            assert found.shape[1] == 5
    except RecordingError as error:
        assert str(error)


@pytest.mark.parametrize(
    "lines",
    [
        'time,A,B,duty,volts,M\n0.00,0.1,-0.9,0.5,24,3\n0.01,0.1,-0.9,0.5,12,3\n',
        "".join(f'{{"time": {t}, "A": 0.1, "B": -0.9, "duty": 0.5, "volts": {v}, "M": 3}}\n'
                for t, v in ((0.0, 24), (0.01, 12))),
    ],
)  # fmt: skip
def test_a_product_is_a_channel_of_samples_that_come_one_by_one(lines):
    told = StatedMapping({"q1": "A", "q2": "B", "tau1": "duty*volts", "tau2": "M"}, {"tau1": "Nm*2"})
    rows = Lines(told=told).feed(lines, last=True)
    assert rows[:, 3].tolist() == [24.0, 12.0]


def test_a_force_in_a_unit_that_is_none_of_it_is_refused() -> None:
    lines = Lines()
    with pytest.raises(RecordingError, match="is in kg"):
        lines.feed("t,q1,q2,tau1,tau2,f1 [kg]\n0,0.1,0.2,3,4,5\n0.01,0.1,0.2,3,4,5\n")


def test_a_stream_without_a_time_is_told_to_bring_one() -> None:
    with pytest.raises(RecordingError) as found:
        Lines().feed("q1,q2,tau1,tau2\n0.1,0.2,3,4\n0.1,0.2,3,4\n")
    assert "--map t=COLUMN" in found.value.remedy and "--rate" not in found.value.remedy
