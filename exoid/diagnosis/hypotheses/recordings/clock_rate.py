"""The torques were logged by a clock that runs faster or slower than that of the angles, in all recordings or some."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from exoid.diagnosis.hypotheses.recordings import Claim, Seen, StateColumn, each_said, listed, moving, sides
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

MOST = 0.05
"""Part by which a clock may run faster: no clock is as bad."""


def claims(model: Model, columns: Sequence[StateColumn]) -> tuple[Claim, ...]:
    """Return another rate of the torques' clock, the same in all recordings, and that of some."""
    claim = moving("clock_rate", "1", _fast, MOST, (1e2, "%"))
    # No clock begins to run at another rate, and a delay that all have is the machine's.
    return replace(claim, whole=True), replace(claim, common=True, unlike="clock_offset")


def _fast(seen: Seen) -> Float:
    return seen.began + (seen.t - seen.began) * (1.0 + seen.number)


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on the rates {recording: words} of the torques' clock."""
    values = sides(values, "faster", "slower")
    rate, *others = dict.fromkeys(values.values())
    if others:
        return f"The clock of the torques runs at another rate than that of the angles: {each_said(values)}"
    return f"The clock of the torques runs {rate} than that of the angles in {listed(values)}"
