"""Formulas of columns in a mapping: sums, differences, products and numbers, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.read import read_recording
from exoid.workbench.command import main

T = np.arange(800) * 0.01
Q = np.column_stack([np.sin(T), np.sin(1.3 * T)])
TAU = np.column_stack([3 * np.cos(T), 2 * np.cos(1.3 * T)])


@pytest.fixture
def run(tmp_path):
    """A position controller's log: torque 1 is 12 times the error of the position, motor 2 turns by 6 and from 0.5."""
    rows = np.column_stack([T, Q[:, 0], Q[:, 0] + TAU[:, 0] / 12, 6 * Q[:, 1] + 0.5, TAU[:, 1]])
    text = "\n".join(",".join(f"{x:.8g}" for x in row) for row in rows)
    (tmp_path / "run.csv").write_text(f"t,actual-1,target pos,motor,tau2\n{text}\n", encoding="utf-8")
    return tmp_path / "run.csv"


def test_sums_differences_and_constants_are_computed(run):
    told = {"q1": "actual-1", "tau1": "12*(target pos-actual-1)", "q2": "(motor - 0.5)/6"}
    found = read_recording(run, columns=told)
    assert np.allclose(found.q, Q, atol=1e-6) and np.allclose(found.tau, TAU, atol=1e-5)
    words = "q1=actual-1,tau1=12*(target pos-actual-1),q2=(motor - 0.5)/6"
    assert main(["compare", str(run), "--map", words, "--quiet"]) == 0


@pytest.mark.parametrize("text", ["motor**9**9", "(motor", "motor 2", "open(motor)", "motor-nowhere"])
def test_nothing_else_is(run, text):
    with pytest.raises(RecordingError):
        read_recording(run, columns={"q1": "actual-1", "tau1": text, "q2": "motor"})


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("12*(target pos-actul)", "column 'actul' (tau1) is not in the file; did you mean 'actual-1'"),
        ("2*(angle-zero)", "unit 'deg+rad'"),
        ("angle/turn", "unit 'deg/deg'"),
    ],
)
def test_what_is_lacking_or_does_not_fit_is_told(text, said):
    names = ("t", "q1", "q2", "tau2", "target pos", "actual-1", "angle [deg]", "turn [deg]", "zero [rad]")
    table = {"t": T, **{name: TAU[:, 0] for name in names[1:]}}
    with pytest.raises(RecordingError) as error:
        read_recording(table, columns={"tau1": text})
    assert said in str(error.value).replace("\n  what to do: ", "; ")
