"""The same recordings, the same answer, whatever processor sums their samples, in however many threads."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]


@cache
def answers(threads: int = 1, kernel: str = "", change: float = 0.0) -> Any:
    """Return what another process says: with so many threads, the `kernel` of another processor, inputs changed."""
    given = {"OPENBLAS_NUM_THREADS": str(threads), "OMP_NUM_THREADS": str(threads)}
    if kernel:
        given["OPENBLAS_CORETYPE"] = kernel
    run = subprocess.run(
        [sys.executable, "-m", "tests.diagnosis.answers", str(change)],
        cwd=ROOT, env={**os.environ, **given}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return json.loads(run.stdout)


@pytest.mark.slow
@pytest.mark.parametrize(
    "other",
    [{"threads": 4, "kernel": "Nehalem"}, {"change": 1e-12}],
    ids=["another processor with several threads", "inputs that differ by rounding"],
)
def test_every_processor_says_the_same(other):
    assert answers(**other) == answers()


def test_readings_that_no_recording_can_tell_apart_are_both_told():
    """Of two legs that hang side by side, one mirrored alone is the same machine."""
    ((what, remedy),) = answers()["readings"][0]
    assert "the right torque has the wrong sign" in what and "the right angle has the wrong sign" in what
    assert "--convention right-torque-negated;" in remedy and "right-angle-negated" in remedy
