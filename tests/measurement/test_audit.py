"""What the audit finds, and that it keeps quiet when there is nothing."""

import json

import numpy as np
import pytest
from tables import HEADER, leg, lines, text

from exoid.measurement.auditing.audit import audit, find_checks
from exoid.measurement.auditing.convention import check_conventions
from exoid.measurement.finding import Finding, row_ranges
from exoid.measurement.reading.read import read_recording
from exoid.measurement.recording import Recording


def found(tmp_path, columns=None, rows=None, **options):
    path = tmp_path / "run.csv"
    header = ",".join(columns) if columns else HEADER
    path.write_text("\n".join(rows) if rows else text(columns, header=header))
    recording = read_recording(path, **options)
    findings = (*recording.findings, *check_conventions([recording]))
    return recording, {finding.check: finding for finding in reversed(findings)}


def test_a_good_recording_is_left_in_peace(tmp_path):
    recording, findings = found(tmp_path)
    assert not findings and recording.rate == pytest.approx(100.0) and recording.duration == pytest.approx(14.99)


def test_bad_cells_are_masked_and_counted(tmp_path):
    rows = lines()
    rows[10] = rows[10].replace(rows[10].split(",")[1], "ERR")
    rows[20] = ",".join(rows[20].split(",")[:3])
    rows[30] += ",1,2"
    rows[40] = rows[40].replace(rows[40].split(",")[3], "inf")
    recording, _ = found(tmp_path, rows=rows)
    assert np.flatnonzero(~recording.complete).tolist() == [9, 19, 29, 39]
    assert recording.row[9] == 11
    told = " ".join(f"{f.what} {f.where}" for f in recording.findings if f.check == "cells")
    assert "'ERR' in row 11" in told and "rows 21, 31" in told and "infinite" in told
    assert np.isfinite(recording.q).all() and np.isfinite(recording.tau).all()


def _clock(change):
    columns = leg()
    columns["t"] = change(columns["t"].copy())
    return columns


def _glitch(t):
    t[100], t[200], t[300] = t[99], t[198], 1e5
    return t


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "severity", "words"),
    [
        (_glitch, "repaired", "repeats or goes back in 3"),
        (lambda t: t * 1000, "repaired", "read in ms (100 Hz)"),
        (lambda t: np.round(t * 1e6), "repaired", "read in µs"),
        (lambda t: np.floor(t * 20 + 1e-9) / 20, "warning", "spaced evenly"),
        (lambda t: t[::-1], "warning", "backwards"),
    ],
)
def test_clocks(tmp_path, change, severity, words):
    recording, findings = found(tmp_path, _clock(change))
    assert findings["time"].severity == severity and words in findings["time"].what
    assert recording.rate == pytest.approx(100.0, rel=1e-3) and np.all(np.diff(recording.t) > 0)


def test_rows_out_of_order_are_sorted(tmp_path):
    rows = lines()
    rows[100], rows[101] = rows[101], rows[100]
    recording, findings = found(tmp_path, rows=rows)
    assert "2 rows stood out of order" in findings["time"].what and recording.valid.all()
    np.testing.assert_allclose(recording.q[:, 0], leg()["q1"], rtol=1e-7)


def test_dates_become_seconds(tmp_path):
    rows = lines()
    for i in range(1, len(rows)):
        rows[i] = f"2024-03-01T12:{(i // 6000):02d}:{(i % 6000) / 100:06.3f}," + rows[i].split(",", 1)[1]
    recording, _ = found(tmp_path, rows=rows)
    assert recording.t[0] == 0.0 and recording.rate == pytest.approx(100.0)


def _with(**changes):
    columns = leg()
    for name, change in changes.items():
        columns[name] = change(columns[name].copy())
    return columns


def _held(x):
    x[200:300] = x[200]
    return x


def _bursts(x):
    x[::6] += 40.0 * np.sign(np.sin(np.arange(x[::6].size)))
    return x


def _spiked(x):
    x[[100, 500]] += 1.0
    return x


@pytest.mark.slow
@pytest.mark.parametrize(
    ("columns", "check", "words"),
    [
        (_with(q1=np.degrees, q2=np.degrees), "units", "were read in degrees"),
        (_with(tau1=lambda x: x * 1000), "units", "looks like mN·m"),
        (_with(tau2=lambda x: -x), "convention", "knee torque has the wrong sign"),
        (_with(tau1=lambda x: -x), "convention", "hip torque has the wrong sign"),
        (_with(tau1=lambda x: -x, tau2=lambda x: -x), "convention", "both torques (or both angles) have the wrong"),
        (_with(q1=lambda x: -x), "convention", "hip angle has the wrong sign"),
        (_with(q2=lambda x: -x), "convention", "knee angle has the wrong sign"),
        (_with(tau1=lambda x: leg()["tau2"], tau2=lambda x: leg()["tau1"]), "convention", "torque are swapped"),
        (_with(q1=lambda x: leg()["q2"], q2=lambda x: leg()["q1"]), "convention", "angle are swapped"),
        (_with(tau1=lambda x: np.minimum(x, 20.0)), "saturated", "exactly 20 N·m"),
        (_with(tau2=_held), "frozen", "knee torque is frozen in 100 rows"),
        (_with(q2=_held), "frozen", "knee angle is frozen"),
        (_with(q1=lambda x: np.round(x / 0.03) * 0.03), "quantised", "steps of 0.03 rad"),
        (_with(tau1=_bursts), "outliers", "stand far off"),
        (_with(q2=lambda x: x * 0 - 0.5), "motion", "knee stands still"),
        (_with(tau2=lambda x: x * 0), "motion", "knee torque is 0 N·m throughout"),
        (_with(q1=_spiked), "spikes", "2 spikes"),
        (_with(q1=lambda x: (x + 2.6 + np.pi) % (2 * np.pi) - np.pi), "wraps", "jumps by a full turn"),
    ],
)
def test_faults_are_named(tmp_path, columns, check, words):
    _, findings = found(tmp_path, columns)
    assert check in findings, sorted(findings)
    assert words in findings[check].what and findings[check].remedy


def test_gaps_rate_jitter_and_length(tmp_path):
    rows = lines()
    _, findings = found(tmp_path, rows=rows[:300] + rows[330:])
    assert "1 gaps with about 30 samples missing" in findings["gaps"].what and "row 301" in findings["gaps"].where
    _, findings = found(tmp_path, leg(400, 20.0))
    assert "slow for accelerations" in findings["rate"].what
    _, findings = found(tmp_path, _clock(lambda t: t + np.random.default_rng(0).uniform(0, 0.008, t.size)))
    assert findings["jitter"].severity == "warning"
    _, findings = found(tmp_path, leg(300))
    assert "lasts only" in findings["length"].what


@pytest.mark.parametrize(
    ("scale", "words"), [(57.29578, "degrees per second"), (-1, "other way round"), (3, "3 times")]
)
def test_a_logged_velocity_must_be_that_of_the_angle(tmp_path, scale, words):
    columns = leg()
    for joint in "12":
        columns[f"dq{joint}"] = np.gradient(columns[f"q{joint}"], columns["t"])
    _, findings = found(tmp_path, columns)
    assert "velocity" not in findings
    columns["dq2"] = columns["dq2"] * scale
    _, findings = found(tmp_path, columns)
    assert words in findings["velocity"].what


def test_the_remedies_work(tmp_path):
    recording, findings = found(tmp_path, _with(tau2=lambda x: -x), units={"tau2": "-Nm"})
    assert "convention" not in findings
    np.testing.assert_allclose(recording.tau[:, 1], leg()["tau2"], rtol=1e-7)


@pytest.mark.slow
def test_shared_recordings_are_judged_calmly(shared_data):
    paths = [path for part in ("practice", "two_link_rig") for path in sorted((shared_data / part).rglob("*.csv"))]
    assert paths
    for path in paths:
        recording = read_recording(path)
        assert recording.valid.all(), path
        assert {finding.severity for finding in recording.findings} <= {"info"}, (path, recording.findings)


def test_checks_are_files_and_never_raise_on_little_data():
    assert {"gaps", "units", "frozen", "saturated", "motion"} <= set(find_checks())
    for count in (0, 1, 2, 12, 60):
        t = np.arange(count) * 0.01
        for value in (np.zeros((count, 2)), np.column_stack([np.sin(40 * t), np.cos(50 * t)])):
            for valid in (np.ones(count, bool), np.zeros(count, bool), np.arange(count) % 2 == 0):
                audit(Recording("r", t, value, value, valid, dq=value))


def test_findings_print_and_travel():
    finding = Finding("gaps", "info", "what", "file, row 3", float("nan"), 1.0, "nothing")
    assert json.loads(json.dumps(finding.to_json()))["value"] is None
    assert str(finding) == "info: file, row 3: what (nothing)"
    assert row_ranges(np.array([1, 2, 3, 7, 9, 10])) == "rows 1-3, 7, 9-10"
    assert row_ranges(np.array([5])) == "row 5" and row_ranges(np.array([], dtype=int)) == ""
    with pytest.raises(ValueError, match="severity"):
        Finding("x", "bad", "y")
