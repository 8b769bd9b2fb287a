"""Factors of torques (torque constants, gears, rated torques) that no rigid leg agrees with.

The shank pulls on both joints, so a leg fixes the ratio of the two torques: where hip and knee fit together only when
one of them is multiplied, its factor is wrong. The size of both is free for a leg of any mass, within reason.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exoid.ground.thresholds import threshold
from exoid.ground.ties import index_of_least, least_of
from exoid.measurement.auditing.channels import place
from exoid.measurement.auditing.rough import Smooth, smooth, unexplained
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import is_leg
from exoid.symbolic.motion import Float

TRIED = np.logspace(-3, 3, 37)
SPARSE = TRIED[::3]
"""Near enough to tell on which side of one a plain factor lies."""
LEAST_GAIN = threshold(
    __name__, "LEAST_GAIN", 0.02,
    "share of the torques' power left, from which a factor is looked for: friction left out",
)  # fmt: skip
GOOD = threshold(
    __name__, "GOOD", 0.12,
    "share of power that the factor leaves at most: one that fits nothing would be named",
)  # fmt: skip
TIMES = threshold(__name__, "TIMES", 4.0, "times less than without it: two scales that fit alike")
PLAIN = threshold(
    __name__, "PLAIN", 5.0,
    "factor, or one over it, that no effect of a drive is: a wrong gain would be called a gear",
)  # fmt: skip
SHOWN = threshold(
    __name__, "SHOWN", 0.005,
    "share of a joint's power that a plain factor explains at least: rounding beside a good fit",
)  # fmt: skip
WEAK = threshold(
    __name__, "WEAK", 0.02,
    "N·m, standard deviation of the larger torque: a small rig would be taken for kN·m or currents",
)  # fmt: skip


def check(recording: Recording) -> list[Finding]:
    """Warn of torques that fit together only when one of them is multiplied, and of torques too small for any leg."""
    motions = _motions([recording])
    found = []
    for motion in motions:
        size = float(motion.tau.std(axis=0).max())
        if size < WEAK:
            found.append(
                _finding(
                    place(recording), f"the torques vary by {size:.2g} N·m only: they look like kN·m or currents", size,
                    WEAK, "say so with --units tau=kNm, or give torque constant and gear: --units tau=Nm/A*0.1*50",
                )
            )  # fmt: skip
    return [*found, *_factor(motions, place(recording))]


def check_scales(recordings: Sequence[Recording]) -> tuple[Finding, ...]:
    """Return a warning where `recordings` together want a plain factor between the torques: a gear, or another unit."""
    found = _factor(_motions(recordings), f"{len(recordings)} recordings together", only_plain=True)
    return tuple(item for item in found if item.value is not None and _is_plain(item.value))


def _motions(recordings: Sequence[Recording]) -> list[Smooth]:
    """Return the smoothed recordings in which a leg moves and both its joints carry torque."""
    motions = [smooth(recording) for recording in recordings if is_leg(recording.joints)]
    return [m for m in motions if m is not None and np.all(m.tau.std(axis=0) > 0) and np.any(m.q.std(axis=0) > 0.02)]


def _is_plain(factor: float) -> bool:
    return bool(abs(np.log(factor)) > np.log(PLAIN))


def _factor(motions: Sequence[Smooth], where: str, only_plain: bool = False) -> list[Finding]:
    """Return that a rigid leg wants the knee torque of all `motions` multiplied by one factor; [] where none does.

    With `only_plain` one recording is enough to see that no plain factor is wanted.
    """
    if not motions:
        return []
    now = _left(motions, 1.0)
    if now.sum() < LEAST_GAIN:
        return []
    if only_plain:
        near = SPARSE[index_of_least([_left(motions[:1], factor).sum() for factor in SPARSE], 1.0)]
        if not _is_plain(near**2):  # half way to a plain one
            return []
    left = [_left(motions, factor).sum() for factor in TRIED]
    best = index_of_least(left, 1.0)
    if not 0 < best < TRIED.size - 1:
        return []
    fine = np.geomspace(TRIED[best - 1], TRIED[best + 1], 13)
    least, wanted = least_of(((_left(motions, item), float(item)) for item in fine), lambda one: one[0].sum(), 1.0)
    far = now.sum() > TIMES * least.sum()
    # A knee torque that is far too small leaves the shank no mass: only the hip shows that, and only a little.
    alone = _is_plain(wanted) and np.any((now > TIMES * least) & (now - least > SHOWN))
    if least.sum() >= GOOD or not (far or alone):
        return []
    what = (
        f"hip and knee torque do not belong to one leg: a rigid leg wants the knee torque multiplied by "
        f"{wanted:.3g}, or the hip torque by {1 / wanted:.3g}; so it leaves {least.mean():.1%} of the torques' "
        f"variance unexplained, as they stand {now.mean():.0%}"
    )
    remedy = f"check torque constant and gear: --units tau2=Nm*{wanted:.3g} or tau1=Nm*{1 / wanted:.3g}"
    return [_finding(where, what, wanted, None, remedy)]


def _left(motions: Sequence[Smooth], factor: float) -> Float:
    """Return the share (J,) of the torques' power that is left when the knee torque is multiplied by `factor`."""
    return np.asarray(np.mean([unexplained(motion, factors=(1.0, factor))[0] for motion in motions], axis=0))


def _finding(where: str, what: str, value: float, limit: float | None, remedy: str) -> Finding:
    return Finding(
        "scale", "warning", what, where, value, limit, remedy,
        consequence="every parameter is wrong", confidence="likely",
    )  # fmt: skip
