"""The convention of recordings, judged by physics: a machine fits a pendulum one way round only.

Angles and torques are read in every usual way and combination; for each reading a rough pendulum (`rough.py`) with
inertias, weights and frictions that are not negative is fitted to all recordings at once. The whole machine mirrored
(angles and torques negated) is the same one, so such pairs of readings count as one. A reading is only named where the
recordings as they stand contradict the pendulum and the other reading fits far better, and where the recordings as they
stand are not explained better still for part of the time, or with late torques: a foot on the ground is no wrong sign.
The zeros of encoders are looked for where angles are counts: these start anywhere, so that no usual zero need fit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from exoid.ground.minimum import minimum
from exoid.ground.thresholds import Threshold
from exoid.ground.ties import ascending, index_of_least, order_of, tied
from exoid.measurement.auditing.channels import place_of_all
from exoid.measurement.auditing.hypotheses import RATIOS, ConventionHypothesis, hypothesis, stages, turning_joints
from exoid.measurement.auditing.power_left import left_in_part, motions_of, power_left, quiet_torques, read_so
from exoid.measurement.auditing.rough import Smooth
from exoid.measurement.finding import Finding
from exoid.measurement.reading.conventions import Convention, Map, combined_map
from exoid.measurement.recording import Recording
from exoid.symbolic.force import Force
from exoid.symbolic.joints import Vector, is_leg, is_spatial, machine_word, parents
from exoid.symbolic.motion import Float

GOOD: Threshold = 0.4
"""share of the torques' power that a reading leaves at most: one that fits nothing would be named"""
GAIN: Threshold = 0.08
"""share of power left as recorded, from which another reading is looked for: friction left out"""
TIMES: Threshold = 4.0
"""times more than the other reading leaves: two readings that fit alike"""
SLIGHT_GAIN: Threshold = 0.03
"""the same share where the other reading is far better: a light payload or a small tilt"""
SLIGHT_TIMES: Threshold = 15.0
"""times more that is far better: a reading that absorbs what the rough leg leaves out"""
GAINS = ((GAIN, TIMES), (SLIGHT_GAIN, SLIGHT_TIMES))
LEAST = float(min(least for least, _ in GAINS))
AS_GOOD: Threshold = 1.5
"""times what the best reading leaves, within which the one with the fewest names is named: three errors for one"""
COARSE = 30.0
"""Degrees between the zeros of encoders that are tried first: the weight of a link changes by half of itself."""
FINER, MOST_STEPS = (7.0, 2.5, 0.8, 0.3, 0.1), 20
"""Steps in degrees by which the best of them moves then, and how often by each."""
MOST_COUNTED = 2
"""Joints whose zeros are tried in every combination."""
DELAYS = np.arange(-22, 23) * 2e-2
"""s by which torques may be late, where a reading is only what these look like."""


@dataclass(frozen=True, eq=False)
class Better:
    """A reading that fits far better: shares of the torques' power (of 2.0) left `now` and `then`; what fits alike.

    Of the `rivals` those that are the `same` leave as much to rounding: another machine that moves alike.
    """

    reading: ConventionHypothesis
    now: float
    then: float
    rivals: tuple[ConventionHypothesis, ...]
    same: tuple[ConventionHypothesis, ...] = ()


def check_conventions(
    recordings: Sequence[Recording], weighs: float | Vector = True, forces: tuple[Force, ...] | None = None
) -> tuple[Finding, ...]:
    """Return a warning that names the option to give where another reading of `recordings` fits far better.

    All are looked at together; where no reading fits them all, those alone that leave far more than another one. One in
    which little moves fits many machines: what some say alone must not make the fit of all together worse.
    `weighs` says whether the machine moves under gravity, of one in space under which (3,), in m/s², `forces` what its
    measured forces are, None the usual.
    """
    if not all(map(_known, recordings)):
        return ()
    motions = {item: motion for item in recordings for motion in motions_of([item], weighs, forces)}
    every = [*motions.values()]
    if not every or _stands(every) < LEAST:
        return ()
    if (better := better_reading(every)) is not None:
        return (_finding(recordings, better),) if _is_plain(every, better) else ()
    if len(motions) == 1:
        return ()
    left = {item: _stands([motion]) for item, motion in motions.items()}
    odd = [item for item, share in left.items() if share >= max(LEAST, TIMES * min(left.values()))]
    alone = {item: better for item in odd if (better := better_reading([motions[item]])) is not None}
    findings = []
    for option in dict.fromkeys(better.reading.option for better in alone.values()):
        some = {item: better for item, better in alone.items() if better.reading.option == option}
        read = [read_so(_as_in_the_files([motions[k]])[0], better.reading) for k, better in some.items()]
        rest = [motion for item, motion in motions.items() if item not in some]
        if _stands([*rest, *read]) < _stands(every):
            kept = {item: better for item, better in some.items() if _is_plain([motions[item]], better)}
            findings += [_finding([item], better, item) for item, better in kept.items()]
    return tuple(findings)


def _is_plain(motions: Sequence[Smooth], better: Better) -> bool:
    """True if motions are not explained better still as they stand for part of the time, or with late torques."""
    late = [_stands([_late(motion, delay) for motion in motions]) for delay in DELAYS]
    if min(late) <= better.then:
        return False
    if is_spatial(motions[0].joints):  # where links have so many numbers that some fit any part
        return True
    in_part = left_in_part(_as_in_the_files(motions), better.reading)
    return not left_in_part(motions, hypothesis((), motions[0].joints)) < in_part


def _late(motion: Smooth, delay: float) -> Smooth:
    """The motion with torques that are late by so many s read in time."""
    at = np.arange(len(motion.tau))
    return replace(motion, tau=np.column_stack([np.interp(at + delay / motion.step, at, x) for x in motion.tau.T]))


def _as_in_the_files(motions: Sequence[Smooth]) -> list[Smooth]:
    """Return the motions as the files hold them, where all were read alike: the option to give is looked for there."""
    kept, *others = {motion.kept: None for motion in motions}
    if others:
        return list(motions)
    to = combined_map(kept, motions[0].joints)
    angle, torque = (np.asarray(np.linalg.inv(part), dtype=float) for part in (to.angle, to.torque))
    back = ConventionHypothesis((), Map(angle, -angle @ to.zero, torque))
    return [replace(read_so(motion, back), kept=()) for motion in motions]


def _known(recording: Recording) -> bool:
    """True if the lengths of its machine are known, or need not be: joints that nobody named have none. What a base or
    a force does to one in space is not asked here.
    """
    joints = recording.joints
    if is_spatial(joints):
        return recording.base is None and not recording.forces
    return is_leg(joints) or all(above is None or joints[above].length is not None for above in parents(joints))


def _finding(recordings: Sequence[Recording], found: Better, each: Recording | None = None) -> Finding:
    """The warning that another reading fits; its option is that of `each` file where others are right as they stand."""
    joints = recordings[0].joints
    what = f"it looks as if {', or '.join(reading.what for reading in (found.reading, *found.rivals))}"
    what += f": a {machine_word(joints)} so read leaves {found.then / len(joints):.1%} of the torques' variance "
    what += f"unexplained, as it stands {found.now / len(joints):.0%}"
    file, option = "" if each is None else f"{Path(each.source.path).name or each.name}=", found.reading.option
    remedy = f"if so, give --convention {file}{option}" if option else "if so, leave --convention away"
    same = " or ".join(reading.option for reading in found.same)
    remedy += f"; no motion distinguishes it from {same}: look at the machine" if same else ""
    return Finding(
        "convention", "warning", what, place_of_all(recordings), found.now, LEAST, remedy, "every parameter is wrong",
        "possible" if found.rivals or found.then > GAIN else "likely", "" if file else option,
    )  # fmt: skip


def better_reading(motions: Sequence[Smooth]) -> Better | None:
    """Return the reading that explains all motions far better than they stand, None for none."""
    if not motions or (now := _stands(motions)) < LEAST:
        return None
    joints, several, motions = motions[0].joints, len(motions) > 1, _as_in_the_files(motions)
    doubts = GAINS if is_leg(joints) else ((SLIGHT_GAIN, TIMES),)
    enough = min(GOOD, now / min(times for least, times in doubts if now >= least))
    # Beyond, it would be doubted itself. In space one name of two may leave so little, and both far less.
    settled = min(enough, SLIGHT_GAIN) / (TIMES if is_spatial(joints) else 1.0)
    counted = sorted(frozenset.intersection(*(motion.counted for motion in motions)))[:MOST_COUNTED]
    kinds = [_best_zeros(motions, counted)] if counted and not is_spatial(joints) else []
    left, quiet = power_left(motions, kinds), quiet_torques(motions)
    still = not is_spatial(joints) and all(motion.base is None for motion in motions)
    for stage in stages(now, turning_joints(motions), joints, still, several):
        more = [item for item in stage([kinds[k] for k in order_of(left, 1.0)]) if not _another(item, quiet)]
        kinds = [*kinds, *more]
        left = np.concatenate([left, power_left(motions, more)])
        if left.min(initial=np.inf) <= settled:
            break
    best = float(left.min())
    if best > enough:
        return None
    as_good = [k for k in range(len(kinds)) if left[k] <= AS_GOOD * best]
    # Of counts a zero at a right angle is no likelier than any other. How many steps a turn has is easily said wrongly,
    # and a sensor of torque stands behind the gear.
    motors = {f"{joints[k].name}-motor" for k in counted}

    def unlikely(item: Convention) -> bool:
        at_right_angle = bool(item.zero) and any(item.zero[k] for k in counted) and "-zero=" not in item.name
        return at_right_angle or item.name.partition("=")[0] in motors

    cost = {k: kinds[k].cost + 2 * any(map(unlikely, kinds[k].names)) for k in as_good}
    chosen = ascending((k for k in as_good if cost[k] == min(cost.values())), lambda k: left[k], 1.0)
    first, *others = chosen[:4]
    if any("-motor" in name.name for name in kinds[first].names):
        return Better(_refined(motions, kinds[first]), now, float(left[first]), ())
    same = tuple(kinds[k] for k in others if tied([left[first], left[k]], 1.0).all())
    return Better(kinds[first], now, float(left[first]), tuple(kinds[k] for k in others), same)


def _best_zeros(motions: Sequence[Smooth], counted: Sequence[int]) -> ConventionHypothesis:
    """Return the zeros of the `counted` joints that leave least of the torques' power: an encoder starts anywhere."""
    joints = motions[0].joints

    def at(zeros: Float) -> ConventionHypothesis:
        return hypothesis([f"{joints[k].name}-zero={z:.1f}" for k, z in zip(counted, zeros, strict=True)], joints)

    def best(some: Sequence[Float]) -> tuple[Float, float]:
        left = power_left(motions, [at(zeros) for zeros in some])
        k = index_of_least(left, 1.0)
        return some[k], float(left[k])

    places = np.arange(-180.0, 180.0, COARSE)
    zeros, least = best([np.array(entry) for entry in product(places, repeat=len(counted))])
    moves = [np.array(item) for item in product((0.0, -1.0, 1.0), repeat=len(counted))]
    for step in FINER:
        for _ in range(MOST_STEPS):
            near, left = best([zeros + step * move for move in moves])
            if not left < least:
                break
            zeros, least = near, left
    return at((zeros + 180.0) % 360.0 - 180.0)


def _another(reading: ConventionHypothesis, quiet: NDArray[np.bool_]) -> bool:
    """True if `reading` exchanges the columns of a joint whose torque is `quiet`: beside a joint that only swings along
    any torque fits, so none says that it is another's.
    """
    turned = (part for name in reading.names for part in (name.angle, name.torque) if part)
    return any(quiet[k] and row[k] == 0.0 for part in turned for k, row in enumerate(part))


def _stands(motions: Sequence[Smooth]) -> float:
    """Return the share that is left of the torques' power as the recordings stand."""
    return float(power_left(motions, [hypothesis((), motions[0].joints)])[0])


def _refined(motions: Sequence[Smooth], found: ConventionHypothesis) -> ConventionHypothesis:
    """Return a reading with its gear ratios as near as they are known: of two digits where these fit as well."""
    step = float(np.log(RATIOS[-1] / RATIOS[-2]))
    grid = np.linspace(-step, step, 41)

    def geared(reading: ConventionHypothesis, change: Callable[[float], float]) -> ConventionHypothesis:
        names = []
        for item in reading.names:
            stem, _, ratio = item.name.partition("=")
            motor = "-motor" in stem and ratio
            names.append(f"{stem}={change(float(ratio)):.4f}".rstrip("0").rstrip(".") if motor else item.name)
        return hypothesis(names, motions[0].joints)

    def share(x: float) -> float:
        return float(power_left(motions, [geared(found, lambda ratio: ratio * np.exp(x))])[0])

    near, wide = float(grid[index_of_least([share(float(x)) for x in grid], 1.0)]), float(grid[1] - grid[0])
    change, least = minimum(share, near - wide, near + wide, 1e-5)
    best = geared(found, lambda ratio: ratio * np.exp(change))
    rounded = geared(best, lambda ratio: float(f"{ratio:.2g}" if ratio > 10 else round(ratio)))
    return rounded if power_left(motions, [rounded])[0] <= AS_GOOD * least else best
