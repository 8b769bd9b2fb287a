"""Factors of torques (torque constants, gears, rated torques) that no rigid leg agrees with.

The shank pulls on both joints, so a leg fixes the ratio of the two torques: where hip and knee fit together only when
one of them is multiplied, its factor is wrong. The size of both is free for a leg of any mass, within reason.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.ground.ties import index_of_least, least_of
from exoid.measurement.auditing.channels import place, place_of_all
from exoid.measurement.auditing.non_negative import non_negative
from exoid.measurement.auditing.power_left import Sums, smoothed_groups, sums_as_they_stand
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import is_leg
from exoid.symbolic.motion import Float

CONSEQUENCE = "every parameter is wrong"
TRIED = np.logspace(-3, 3, 37)
ROUNDING = 1e-24
"""(N·m)², summed: of a joint without a torque."""
LEAST_GAIN: Threshold = 0.02
"""share of the torques' power left, from which a factor is looked for: friction left out"""
GOOD: Threshold = 0.12
"""share of power that the factor leaves at most: one that fits nothing would be named"""
TIMES: Threshold = 4.0
"""times less than without it: two scales that fit alike"""
PLAIN: Threshold = 5.0
"""factor, or one over it, that no effect of a drive is: a wrong gain would be called a gear"""
SHOWN: Threshold = 0.005
"""share of a joint's power that a plain factor explains at least: rounding beside a good fit"""
WEAK: Threshold = 0.02
"""N·m, standard deviation of the larger torque: a small rig would be taken for kN·m or currents"""


def check(recording: Recording) -> list[Finding]:
    """Warn of torques that fit together only when one of them is multiplied, and of torques too small for any leg."""
    if not is_leg(recording.joints):
        return []
    where, found, sets = place(recording), [], smoothed_groups([recording])
    size = float(sets[0][0].tau.std(axis=0).max()) if sets else WEAK
    if size < WEAK:
        what = f"the torques vary by {size:.2g} N·m only: they look like kN·m or currents"
        remedy = "say so with --units tau=kNm, or give torque constant and gear: --units tau=Nm/A*0.1*50"
        found.append(Finding("scale", "warning", what, where, size, WEAK, remedy, CONSEQUENCE, "likely"))
    return found + _factor([recording], where)


def check_scales(recordings: Sequence[Recording]) -> tuple[Finding, ...]:
    """Return a warning where `recordings` together want a plain factor between the torques: a gear, or another unit."""
    found = _factor(recordings, place_of_all(recordings)) if is_leg(recordings[0].joints) else []
    return tuple(item for item in found if item.value is not None and _is_plain(item.value))


def _is_plain(factor: float) -> bool:
    return bool(abs(np.log(factor)) > np.log(PLAIN))


def _factor(recordings: Sequence[Recording], where: str) -> list[Finding]:
    """Findings that a rigid leg wants the knee torque of all motions multiplied by one factor; [] where none does."""
    sums = [part for part in sums_as_they_stand(smoothed_groups(recordings)) if np.all(part.power > ROUNDING)]
    if not sums or (now := _left(sums, 1.0)).sum() < LEAST_GAIN:
        return []
    best = index_of_least([_left(sums, factor).sum() for factor in TRIED], 1.0)
    if not 0 < best < TRIED.size - 1:
        return []
    fine = np.geomspace(TRIED[best - 1], TRIED[best + 1], 13)
    least, wanted = least_of(((_left(sums, item), float(item)) for item in fine), lambda one: one[0].sum(), 1.0)
    far = now.sum() > TIMES * least.sum()
    # A knee torque that is far too small leaves the shank no mass: only the hip shows that, and only a little.
    alone = _is_plain(wanted) and np.any((now > TIMES * least) & (now - least > SHOWN))
    if least.sum() >= GOOD or not (far or alone):
        return []
    what = f"hip and knee torque do not belong to one leg: a rigid leg wants the knee torque multiplied by {wanted:.3g}"
    what += f", or the hip torque by {1 / wanted:.3g}; so it leaves {least.mean():.1%} of the torques' variance "
    what += f"unexplained, as they stand {now.mean():.0%}"
    remedy = f"check torque constant and gear: --units tau2=Nm*{wanted:.3g} or tau1=Nm*{1 / wanted:.3g}"
    return [Finding("scale", "warning", what, where, wanted, None, remedy, CONSEQUENCE, "likely")]


def _left(sets: Sequence[Sums], factor: float) -> Float:
    """Return the share (J,) of the torques' power that is left when the knee torque is multiplied by `factor`."""
    left, own = [], [0, 1]
    for sums in sets:
        # Each joint counts alike, whatever its torque.
        slopes = sums.slope[own, 0, own] / (sums.power * [[1.0], [factor]])
        grams = sums.gram[own, own, own] / (sums.power[:, :, None] * [[[1.0]], [[factor**2]]])
        x = non_negative(grams.sum(axis=0), slopes.sum(axis=0))
        left.append(np.maximum(1.0 + x @ grams @ x - 2.0 * slopes @ x, 0.0))
    return np.asarray(np.mean(left, axis=0))
