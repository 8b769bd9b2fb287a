"""Check of the resolution of the channels."""

from __future__ import annotations

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import NOTHING, channels, place, step_of, torque_spans
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording

NOTED: Threshold = 500.0
"""grid steps within a channel's usual range, below which the grid is worth knowing"""
COARSE: Threshold = 60.0
"""the same, below which it is warned of: accelerations drown in the steps"""


def check(recording: Recording) -> list[Finding]:
    """Note the grid of channels with fewer than 500 steps in their range; warn below 60, but for idle torques."""
    found = []
    spans = torque_spans(recording)
    idle = {f"tau{j + 1}" for j, span in enumerate(spans) if span < NOTHING * max(spans)}
    for channel in channels(recording, "q", "tau"):
        step = step_of(channel.some)
        if step == 0.0 or not 0.0 < (steps := channel.span(1) / step) < NOTED:
            continue
        where = place(recording, channel.name)
        what = f"the {channel.label} comes in steps of {step:.3g} {channel.unit} ({steps:.0f} steps in its range)"
        severity, limit, remedy, consequence = "info", NOTED, "nothing", "adds noise of about a third of a step"
        if steps < COARSE and channel.name not in idle:
            severity, limit, remedy = "warning", COARSE, "log the channel with its full resolution"
            consequence = "accelerations drown in the steps" if channel.name[0] == "q" else consequence
        found.append(Finding("quantised", severity, what, where, steps, limit, remedy, consequence))
    return found
