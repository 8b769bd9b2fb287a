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
    """Refuse below 10 Hz, warn below 40 Hz: a leg moves at up to a few hertz and accelerations need ten times
    that."""
    rate = recording.rate
    if rate >= GOOD or len(recording) < 2:
        return []
    severity = "refused" if rate < LEAST else "warning"
    what = f"sampled at {rate:.3g} Hz, {'too slow for' if rate < LEAST else 'slow for'} accelerations"
    remedy = "sample at 100 Hz or faster; if the time column is not in seconds, say so: --units t=ms"
    consequence = "fast motion is cut off: inertias come out too small"
    limit = LEAST if rate < LEAST else GOOD
    return [Finding("rate", severity, what, place(recording, "t"), rate, limit, remedy, consequence)]
