"""The benchmark of arms beside the leg runs, and says how many times the leg's processor and memory they take."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.waiting import HUNG

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.slow
def test_arms_are_measured_beside_the_leg():
    pytest.importorskip("pinocchio")
    without = {name: value for name, value in os.environ.items() if name != "EXOID_SHARED_DATA"}
    asked = [sys.executable, "benchmarks/arm_speed.py", "--joints", "3", "--shorter", "4"]
    said = subprocess.run(asked, cwd=ROOT, env=without, capture_output=True, text=True, timeout=HUNG)
    assert said.returncode == 0, said.stderr
    assert re.search(r"^3 joints: processor [\d.]+ s, peak \d+ MB, [\d.]+ and [\d.]+ times the leg$", said.stdout, re.M)
    assert "UR10, one recording: not there" in said.stdout
