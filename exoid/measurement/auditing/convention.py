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
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from exoid.ground.minimum import minimum
from exoid.ground.thresholds import Threshold
from exoid.ground.ties import ascending, index_of_least, order_of, tied
from exoid.measurement.auditing.channels import place_of_all
from exoid.measurement.auditing.hypotheses import RATIOS, ConventionHypothesis, hypothesis, stages, turning_joints
from exoid.measurement.auditing.power_left import left_if_late, left_in_part, power_left, quiet_torques, smoothed_groups
from exoid.measurement.auditing.rough import Smooth
from exoid.measurement.finding import Finding
from exoid.measurement.reading.conventions import combined_map, conventions
from exoid.measurement.reading.registers import COUNTED
from exoid.measurement.recording import Recording
from exoid.symbolic.force import Force
from exoid.symbolic.joints import Vector, is_leg, is_spatial, machine_word, parents
from exoid.symbolic.motion import Float

CHECK, SIGN = "convention", "sign"
CHECKS = (CHECK, SIGN)
"""What findings on the convention of recordings are called: of several, or of another kind; of the sides of one."""
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
DELAYS = np.arange(-45, 46) * 1e-2
"""s by which torques may be late, where a reading is only what these look like."""
NEAR = 0.09
"""rad from a usual zero, within which that of an encoder is taken for it: what the rough machine lacks moves it."""
COARSE = 30.0
"""Degrees between the zeros of encoders that are tried first: the weight of a link changes by half of itself."""
FINER, MOST_STEPS = (7.0, 2.5, 0.8, 0.3, 0.1, 0.03), 20
"""Steps in degrees by which the best of them moves then, and how often by each."""
MOST_COUNTED = 2
"""Joints whose zeros are tried in every combination."""


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
    recordings: Sequence[Recording],
    weighs: float | Vector = True,
    forces: tuple[Force, ...] | None = None,
    beside: Sequence[Recording] = (),
    likely: Sequence[str] = (),
    others: Sequence[Recording] = (),
) -> tuple[Finding, ...]:
    """Return a warning that names the option to give where another reading of `recordings` fits far better.

    All are looked at together; where no reading fits them all, each alone: they may keep different conventions. One in
    which little moves fits many machines: what it says alone must not make the fit of all together worse.
    `weighs` says whether the machine moves under gravity, of one in space under which (3,), in m/s², `forces` what its
    measured forces are, None the usual; `beside` are recordings of the same machine that are read rightly, `others`
    some of which nobody knows, `likely` options that others of it should be given: they are tried before all readings.
    Where one of these recordings is better read as it stands, the option is that of the files.
    """
    if not all(map(_known, recordings)):
        return ()
    smoothed = partial(smoothed_groups, weighs=weighs, forces=forces)
    sets, every = smoothed(recordings), [*beside, *recordings]
    if not sets or any(_stands(part) < LEAST for part in (sets, smoothed(every))):
        return ()
    found = _with_zeros(recordings, sets, better_reading(recordings, weighs, forces, likely))
    asked, spatial = [(recordings, found)], is_spatial(recordings[0].joints)
    if found is None and len(recordings) > 1:
        odd = recordings
        if spatial:  # where asking takes long: those that leave far more than another one
            left = {item: _stands(part) for item in recordings if (part := smoothed([item]))}
            odd = [item for item, share in left.items() if share >= max(LEAST, TIMES * min(left.values()))]
        asked = [([item], better_reading([item], weighs, forces)) for item in odd]
    findings = []
    for some, better in asked:
        own = smoothed(some)
        if better is None or left_if_late(own, DELAYS.tolist()).min() <= better.then:
            continue
        if not spatial:  # where links have so many numbers that some fit any part
            in_part = left_in_part(_as_in_the_files(some, own), better.reading)
            if left_in_part(own, hypothesis((), some[0].joints)) < in_part:
                continue
        rest = [item for item in every if item not in some]
        read = [_read_so(item, better.reading) for item in some] if rest else []
        if not rest or _stands(smoothed([*rest, *read])) < _stands(smoothed(every)):
            told = [] if found is None else [*beside, *others]
            right = any(_stands(smoothed([k])) < _stands(smoothed([_read_so(k, better.reading)])) for k in told)
            findings.append(_finding(some, better, each=found is None or right))
    return tuple(findings)


def counted_joints(recordings: Sequence[Recording]) -> list[int]:
    """Return the joints whose angles are counts of an encoder in every recording, read without a convention: any other
    has its zero where somebody put it.
    """
    if is_spatial(recordings[0].joints) or any(item.conventions for item in recordings):
        return []
    checks = [{finding.check for finding in item.findings} for item in recordings]
    counts = [COUNTED.format(f"q{k + 1}") for k in range(len(recordings[0].joints))]
    return [k for k, check in enumerate(counts) if all(check in there for there in checks)][:MOST_COUNTED]


def _with_zeros(
    recordings: Sequence[Recording], sets: Sequence[Sequence[Smooth]], found: Better | None
) -> Better | None:
    """Return the zeros of encoders where they fit no worse than the usual reading that was `found`, or else that: of
    counts a zero at a right angle is no likelier than any other, unless it is the one that fits.
    """
    counted = counted_joints(recordings)
    if not counted or (found is not None and not any(name.zero for name in found.reading.names)):
        return found
    now = _stands(sets)
    reading, left = _best_zeros(sets, counted)
    if left > min(GAIN, now / TIMES, np.inf if found is None else found.then):
        return found
    if found is None:
        return Better(reading, now, left, ())
    apart = np.angle(np.exp(1j * (reading.map.zero - found.reading.map.zero)))
    same = np.allclose(found.reading.map.angle, reading.map.angle) and np.abs(apart).max() < NEAR
    return found if same else Better(reading, now, left, (found.reading,))


def _best_zeros(sets: Sequence[Sequence[Smooth]], counted: Sequence[int]) -> tuple[ConventionHypothesis, float]:
    """Return the zeros of the `counted` joints that leave least of the torques' power, and what they leave."""
    joints = sets[0][0].joints

    def at(zeros: Float) -> ConventionHypothesis:
        return hypothesis([f"{joints[k].name}-zero={z:.2f}" for k, z in zip(counted, zeros, strict=True)], joints)

    def best(some: Sequence[Float]) -> tuple[Float, float]:
        left = power_left(sets, [at(zeros) for zeros in some])
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
    return at((zeros + 180.0) % 360.0 - 180.0), least


def _as_in_the_files(recordings: Sequence[Recording], sets: Sequence[Sequence[Smooth]]) -> list[list[Smooth]]:
    """Return the motions as the files hold them, where all were read alike: the option to give is looked for there."""
    kept, *others = {recording.conventions for recording in recordings}
    to = combined_map(conventions(() if others else kept, recordings[0].joints), recordings[0].joints)
    back = np.linalg.inv(to.angle).T

    def undone(motion: Smooth) -> Smooth:
        q, tau = to.undone(motion.q, motion.tau)
        return replace(motion, q=q, dq=motion.dq @ back, ddq=motion.ddq @ back, tau=tau, elsewhere=False)

    return [[motion if others else undone(motion) for motion in group] for group in sets]


def _read_so(item: Recording, reading: ConventionHypothesis) -> Recording:
    """Return a recording whose file is read in another way."""
    kept = combined_map(conventions(item.conventions, item.joints), item.joints)
    q, tau = reading.map.applied(*kept.undone(item.q, item.tau))
    return replace(item, q=q, tau=tau, dq=None, ddq=None)


def _known(recording: Recording) -> bool:
    """True if the lengths of its machine are known, or need not be: joints that nobody named have none. What a base or
    a force does to one in space is not asked here.
    """
    joints = recording.joints
    if is_spatial(joints):
        return recording.base is None and not recording.forces
    return is_leg(joints) or all(above is None or joints[above].length is not None for above in parents(joints))


def _steps(recordings: Sequence[Recording], reading: ConventionHypothesis) -> str:
    """Steps per turn of encoders whose angles count on a motor's side."""
    said = {finding.check: finding.value for finding in recordings[0].findings if finding.value}
    every = []
    for k, joint in enumerate(recordings[0].joints):
        ratio, step = float(abs(reading.map.angle[k, k])), said.get(COUNTED.format(f"q{k + 1}"))
        geared = any(name.name.startswith(f"{joint.name}-motor") for name in reading.names)
        if step and geared and 0.0 < ratio != 1.0:
            every.append(f"q{k + 1} about {2 * np.pi / (abs(step) * ratio):.0f} instead of {2 * np.pi / abs(step):.4g}")
    return f"; or its encoders have other steps a turn than --units says ({', '.join(every)})" if every else ""


def _finding(recordings: Sequence[Recording], found: Better, each: bool) -> Finding:
    """The warning that another reading fits; its option is that of `each` file where others are right as they stand."""
    option, *same = (",".join(name.name for name in reading.names) for reading in (found.reading, *found.same))
    joints = recordings[0].joints
    what = f"it looks as if {', or '.join(reading.what for reading in (found.reading, *found.rivals))}"
    what += f": a {machine_word(joints)} so read leaves {found.then / len(joints):.1%} of the torques' variance "
    what += f"unexplained, as it stands {found.now / len(joints):.0%}"
    files = [f"{Path(item.source.path).name or item.name}=" for item in recordings] if each else [""]
    give = " ".join(f"--convention {file}{option}" for file in files)
    remedy = f"if so, give {give}" if option else "if so, leave --convention away"
    remedy += f"; no motion distinguishes it from {' or '.join(same)}: look at the machine" if same else ""
    remedy += _steps(recordings, found.reading)
    sides = all(name.order in (0, 2) for name in found.reading.names)  # signs and exchanges of channels alone
    return Finding(
        SIGN if sides and len(recordings) == 1 else CHECK, "warning", what, place_of_all(recordings), found.now, LEAST,
        remedy, "every parameter is wrong", "possible" if found.rivals or found.then > GAIN else "likely",
        "" if each else option,
    )  # fmt: skip


def better_reading(
    recordings: Sequence[Recording],
    weighs: float | Vector = True,
    forces: tuple[Force, ...] | None = None,
    likely: Sequence[str] = (),
) -> Better | None:
    """Return the reading that explains all `recordings` far better than they stand, None for none."""
    sets = smoothed_groups(recordings, weighs, forces)
    if not sets:
        return None
    joints, now = recordings[0].joints, _stands(sets)
    if now < LEAST:
        return None
    sets = _as_in_the_files(recordings, sets)
    doubts = GAINS if is_leg(joints) else ((SLIGHT_GAIN, TIMES),)
    enough = min(GOOD, now / min(times for least, times in doubts if now >= least))
    # Beyond, it would be doubted itself. In space one name of two may leave so little, and both far less.
    settled = min(enough, SLIGHT_GAIN) / (TIMES if is_spatial(joints) else 1.0)
    if likely:
        known = [hypothesis(option.split(","), joints) for option in likely]
        shares = power_left(sets, known)
        first = index_of_least(shares, 1.0)
        if shares[first] <= enough:
            return Better(known[first], now, float(shares[first]), ())
    kinds: list[ConventionHypothesis] = []
    left, quiet = np.zeros(0), quiet_torques(sets)
    still = not is_spatial(joints) and all(motion.base is None for group in sets for motion in group)
    for stage in stages(now, turning_joints(sets), joints, still, several=len(recordings) > 1):
        more = [item for item in stage([kinds[k] for k in order_of(left, 1.0)]) if not _another(item, quiet)]
        kinds = [*kinds, *more]
        left = np.concatenate([left, power_left(sets, more, AS_GOOD * enough)])
        if left.min(initial=np.inf) <= settled:
            break
    best = float(left.min())
    if best > enough:
        return None
    as_good = [k for k in range(len(kinds)) if left[k] <= AS_GOOD * best]
    # How many steps a turn has is easily said wrongly, and a sensor of torque stands behind the gear.
    counted = {f"{joints[k].name}-motor" for k in counted_joints(recordings)}
    cost = {k: kinds[k].cost + any(c.name.partition("=")[0] in counted for c in kinds[k].names) for k in as_good}
    chosen = ascending((k for k in as_good if cost[k] == min(cost.values())), lambda k: left[k], 1.0)
    first, *others = chosen[:4]
    if any("-motor" in name.name for name in kinds[first].names):
        return Better(_refined(sets, kinds[first]), now, float(left[first]), ())
    same = tuple(kinds[k] for k in others if tied([left[first], left[k]], 1.0).all())
    return Better(kinds[first], now, float(left[first]), tuple(kinds[k] for k in others), same)


def _another(reading: ConventionHypothesis, quiet: NDArray[np.bool_]) -> bool:
    """True if `reading` exchanges the columns of a joint whose torque is `quiet`: beside a joint that only swings along
    any torque fits, so none says that it is another's.
    """
    turned = (part for name in reading.names for part in (name.angle, name.torque) if part)
    return any(quiet[k] and row[k] == 0.0 for part in turned for k, row in enumerate(part))


def _stands(sets: Sequence[Sequence[Smooth]]) -> float:
    """Return the share that is left of the torques' power as the recordings stand; infinite where none moves."""
    return float(power_left(sets, [hypothesis((), sets[0][0].joints)])[0]) if sets else np.inf


def _refined(sets: Sequence[Sequence[Smooth]], found: ConventionHypothesis) -> ConventionHypothesis:
    """Return a reading with its gear ratios as near as they are known: of two digits where these fit as well."""
    step = float(np.log(RATIOS[-1] / RATIOS[-2]))
    grid = np.linspace(-step, step, 41)

    def geared(reading: ConventionHypothesis, change: Callable[[float], float]) -> ConventionHypothesis:
        names = []
        for item in reading.names:
            stem, _, ratio = item.name.partition("=")
            motor = "-motor" in stem and ratio
            names.append(f"{stem}={change(float(ratio)):.4f}".rstrip("0").rstrip(".") if motor else item.name)
        return hypothesis(names, sets[0][0].joints)

    def share(x: float) -> float:
        return float(power_left(sets, [geared(found, lambda ratio: ratio * np.exp(x))])[0])

    near, wide = float(grid[index_of_least([share(float(x)) for x in grid], 1.0)]), float(grid[1] - grid[0])
    change, least = minimum(share, near - wide, near + wide, 1e-5)
    best = geared(found, lambda ratio: ratio * np.exp(change))
    rounded = geared(best, lambda ratio: float(f"{ratio:.2g}" if ratio > 10 else round(ratio)))
    return rounded if power_left(sets, [rounded])[0] <= AS_GOOD * least else best
