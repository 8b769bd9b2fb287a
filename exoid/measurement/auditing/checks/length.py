"""Check that a recording is long enough."""

from __future__ import annotations

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import place
from exoid.measurement.finding import SELECTION, Finding
from exoid.measurement.recording import Recording

LEAST_ROWS: Threshold = 50
"""usable rows: a fit of ten parameters to a handful of samples"""
LEAST_SECONDS: Threshold = 1.0
"""s: the filter alone takes more"""
GOOD_SECONDS: Threshold = 5.0
"""s, below which it is warned: one stroke of a leg shows no effect twice"""
USABLE: Threshold = 0.8
"""share of rows that are not masked, below which it is warned: little data is left"""
REMEDY = "record at least 10 s of motion of every joint at 100 Hz (35 s is usual)"


def check(recording: Recording) -> list[Finding]:
    """Refuse fewer than 50 usable rows or less than 1 s; warn below 5 s and when most rows are masked."""
    where, usable, count = place(recording), int(recording.complete.sum()), len(recording)
    if usable < LEAST_ROWS:
        what = f"only {usable} usable rows of {count}: too short to identify anything (at least {LEAST_ROWS:g})"
        return [Finding("length", "refused", what, where, usable, LEAST_ROWS, REMEDY)]
    if recording.duration < LEAST_SECONDS:
        what = f"the recording lasts {recording.duration:.3g} s: too short to identify anything (at least 1 s)"
        return [Finding("length", "refused", what, where, recording.duration, LEAST_SECONDS, REMEDY)]
    found = []
    if recording.duration < GOOD_SECONDS:
        what = f"the recording lasts only {recording.duration:.3g} s"
        consequence = "wide intervals; small effects cannot be seen"
        found.append(Finding("length", "warning", what, where, recording.duration, GOOD_SECONDS, REMEDY, consequence))
    share = usable / count
    chosen = any(item.check == SELECTION for item in recording.findings)  # which says itself how much it leaves out
    if share < USABLE and not chosen:
        what = f"{1 - share:.0%} of the rows are masked"
        remedy = "look at the findings above for the reason, and at the logger"
        found.append(Finding("length", "warning", what, where, share, USABLE, remedy, "little data is left"))
    return found
