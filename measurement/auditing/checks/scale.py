"""Factors of torques (torque constants, gears, rated torques) that no rigid leg agrees with.

The shank pulls on both joints, so a leg fixes the ratio of the two torques: where hip and knee fit together only when
one of them is multiplied, its factor is wrong. The size of both is free for a leg of any mass, within reason.
"""

from __future__ import annotations

import numpy as np

from ground.thresholds import Threshold
from measurement.auditing.channels import place
from measurement.auditing.rough import Smooth, smooth, unexplained
from measurement.finding import Finding
from measurement.recording import Recording
from symbolic.joints import is_leg

TRIED = np.logspace(-3, 3, 37)
DOUBT = Threshold(0.02, "share of the torques' power left, from which a factor is looked for: friction left out")
GOOD = Threshold(0.12, "share of power that the factor leaves at most: one that fits nothing would be named")
TIMES = Threshold(4.0, "times less than without it: two scales that fit alike")
WEAK = Threshold(0.02, "N·m, standard deviation of the larger torque: a small rig would be taken for kN·m or currents")


def check(recording: Recording) -> list[Finding]:
    """Warn of torques that fit together only when one of them is multiplied, and of torques too small for any leg."""
    motion = smooth(recording) if is_leg(recording.joints) else None
    if motion is None or not np.all(motion.tau.std(axis=0) > 0) or not np.any(motion.q.std(axis=0) > 0.02):
        return []
    found = []
    size = float(motion.tau.std(axis=0).max())
    if size < WEAK:
        found.append(
            _finding(
                recording, f"the torques vary by {size:.2g} N·m only: they look like kN·m or currents", size, WEAK,
                "say so with --units tau=kNm, or give torque constant and gear: --units tau=Nm/A*0.1*50",
            )
        )  # fmt: skip
    now = float(unexplained(motion).sum())
    if now < DOUBT:
        return found
    left = [_left(motion, factor) for factor in TRIED]
    best = int(np.argmin(left))
    if 0 < best < TRIED.size - 1:
        fine = np.geomspace(TRIED[best - 1], TRIED[best + 1], 13)
        left = [_left(motion, factor) for factor in fine]
        wanted, least = float(fine[int(np.argmin(left))]), min(left)
        if least < GOOD and now > TIMES * least:
            what = (
                f"hip and knee torque do not belong to one leg: a rigid leg wants the knee torque multiplied by "
                f"{wanted:.3g}, or the hip torque by {1 / wanted:.3g}; so it leaves {least / 2:.1%} of the torques' "
                f"variance unexplained, as they stand {now / 2:.0%}"
            )
            remedy = f"check torque constant and gear: --units tau2=Nm*{wanted:.3g} or tau1=Nm*{1 / wanted:.3g}"
            found.append(_finding(recording, what, wanted, None, remedy))
    return found


def _left(motion: Smooth, factor: float) -> float:
    """Return the share of the torques' power that is left when the knee torque is multiplied by `factor`."""
    return float(unexplained(motion, factors=(1.0, factor)).sum())


def _finding(recording: Recording, what: str, value: float, limit: float | None, remedy: str) -> Finding:
    return Finding(
        "scale", "warning", what, place(recording), value, limit, remedy,
        consequence="every parameter is wrong", confidence="likely",
    )  # fmt: skip
