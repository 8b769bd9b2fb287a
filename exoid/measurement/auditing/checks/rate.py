"""Check that a recording was sampled fast enough to give accelerations."""

from __future__ import annotations

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import place
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording

LEAST: Threshold = 10.0
"""Hz: inertias from accelerations that were never sampled"""
GOOD: Threshold = 40.0
"""Hz, below which it is warned: a leg moves at a few hertz, accelerations need ten times that"""


def check(recording: Recording) -> list[Finding]:
    """Refuse below 10 Hz, warn below 40 Hz."""
    rate = recording.rate
    if rate >= GOOD or len(recording) < 2:
        return []
    severity, slow, limit = ("refused", "too slow", LEAST) if rate < LEAST else ("warning", "slow", GOOD)
    what = f"sampled at {rate:.3g} Hz, {slow} for accelerations"
    remedy = "sample at 100 Hz or faster; if the time column is not in seconds, say so: --units t=ms"
    consequence = "fast motion is cut off: inertias come out too small"
    return [Finding("rate", severity, what, place(recording, "t"), rate, limit, remedy, consequence)]
