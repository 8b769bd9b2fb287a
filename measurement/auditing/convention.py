"""Which convention do recordings keep? Judged by physics: a machine fits a pendulum one way round only.

Angles and torques are read in every usual way and combination; for each reading a rough pendulum (`rough.py`) with
inertias, weights and frictions that are not negative is fitted to all recordings at once. The whole machine mirrored
(angles and torques negated) is the same one, so such pairs of readings count as one. A reading is only named where the
recordings as they stand contradict the pendulum and the other reading fits far better.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ground.minimum import minimum
from ground.thresholds import Threshold
from measurement.auditing.channels import place
from measurement.auditing.non_negative import non_negative
from measurement.auditing.rough import Smooth, machine_columns, smooth
from measurement.finding import Finding
from measurement.reading.conventions import Convention, Map, combined_map, conventions, conventions_of_machine, gear
from measurement.recording import Recording
from symbolic.joints import LEG, Joint, is_leg, parents
from symbolic.motion import Float

CHECK = "convention"
GOOD = Threshold(
    0.4,
    "share of the torques' power that a reading leaves at most: one that fits nothing would be named",
)
DOUBT = Threshold(0.08, "share of power left as recorded, from which another reading is looked for: friction left out")
TIMES = Threshold(4.0, "times more than the other reading leaves: two readings that fit alike")
SLIGHT_DOUBT = Threshold(0.03, "the same share where the other reading is far better: a light payload or a small tilt")
SLIGHT_TIMES = Threshold(15.0, "times more that is far better: a reading that absorbs what the rough leg leaves out")
DOUBTS = ((DOUBT, TIMES), (SLIGHT_DOUBT, SLIGHT_TIMES))
LEAST = float(min(least for least, _ in DOUBTS))
QUIET = Threshold(
    0.1,
    "variation of a torque, of its neighbour's, below which it counts as so much: noise of a light joint would "
    "choose the reading",
)
PASSIVE = Threshold(
    0.02,
    "the same below which a joint is passive: what is left there would be compared with a torque that is none",
)
STANDS = Threshold(
    0.01,
    "rad, standard deviation below which a joint stands: a lock carries its torque, which speaks for no reading",
)
AS_GOOD = Threshold(
    1.5,
    "times what the best reading leaves, within which the one with the fewest names is named: three errors for one",
)
FEW, MOST = 2, 4
"""Readings of few names are tried first; those of more only where the recordings as they stand leave `WRONG`."""
FEW_JOINTS, BEAM = 2, 16
"""Joints up to which every combination is tried; beyond, how many readings get one name more."""
WRONG = Threshold(0.4, "share of power left, from which readings of three and four names are tried: chance fits some")
ROUNDING = 1e-13
"""Power of a column, relative to the largest, below which it is rounding."""
STOP = (0.1, 0.9)
"""Quantiles of an angle beyond which something may push back."""
TURNING = Threshold(
    2.5,
    "rad that a joint moves at least where its angle may be that of a motor: every small motion fits some gear",
)
ROWS = 600
"""Samples of all recordings together."""
RATIOS = np.concatenate([np.arange(2.0, 13.0), np.geomspace(14.0, 200.0, 35)])
"""Gear ratios tried."""


@dataclass(frozen=True, eq=False)
class ConventionHypothesis:
    """A way to read recordings: the `names` of the conventions that they would then keep, and their `map`."""

    names: tuple[Convention, ...]
    map: Map

    @property
    def what(self) -> str:
        """The reading in words."""
        return " and ".join(one.what for one in self.names) or "angles and torques need no --convention"

    @property
    def sides(self) -> bool:
        """Whether it only changes signs and exchanges channels."""
        return all(one.order in (0, 2) for one in self.names)


@dataclass(frozen=True, eq=False)
class Better:
    """A reading that fits far better: shares of the torques' power (of 2.0) left `now` and `then`; what fits alike."""

    reading: ConventionHypothesis
    now: float
    then: float
    rivals: tuple[ConventionHypothesis, ...]


def check_conventions(recordings: Sequence[Recording], weighs: bool = True) -> tuple[Finding, ...]:
    """Return a warning that names the option to give where another reading of `recordings` fits far better.

    All are looked at together; where no reading fits them all, each alone: they may keep different conventions.
    `weighs` says whether the machine moves under gravity.
    """
    if not all(_known(one.joints) for one in recordings):
        return ()
    sets = _groups(recordings, weighs)
    if not sets or _stands(sets) < LEAST:
        return ()
    found = better_reading(recordings, weighs)
    if found is None and len(recordings) > 1:
        alone = ((one, better_reading([one], weighs)) for one in recordings)
        return tuple(_finding([one], better, f"{_file(one)}=") for one, better in alone if better is not None)
    return () if found is None else (_finding(recordings, found),)


def _known(joints: Sequence[Joint]) -> bool:
    """Whether the lengths of a machine are known, or need not be: joints that nobody named have none."""
    return is_leg(joints) or all(above is None or joints[above].length is not None for above in parents(joints))


def _file(recording: Recording) -> str:
    return Path(recording.source.path).name if recording.source.path else recording.name


def _finding(recordings: Sequence[Recording], found: Better, file: str = "") -> Finding:
    option = ",".join(one.name for one in found.reading.names)
    joints = recordings[0].joints
    machine = "leg" if is_leg(joints) else "machine"
    text = f"it looks as if {found.reading.what}" + "".join(f", or {rival.what}" for rival in found.rivals)
    return Finding(
        "sign" if found.reading.sides and len(recordings) == 1 else CHECK,
        "warning",
        f"{text}: a {machine} so read leaves {found.then / len(joints):.1%} of the torques' variance unexplained, "
        f"as it stands {found.now / len(joints):.0%}",
        place(recordings[0]) if len(recordings) == 1 else f"{len(recordings)} recordings together",
        found.now,
        LEAST,
        f"if so, give --convention {file}{option}" if option else "if so, leave --convention away",
        consequence="every parameter is wrong",
        confidence="possible" if found.rivals or found.then > DOUBT else "likely",
    )


def better_reading(recordings: Sequence[Recording], weighs: bool = True) -> Better | None:
    """Return the reading that explains all `recordings` far better than they stand; None where none does."""
    sets = _groups(recordings, weighs)
    if not sets:
        return None
    joints = recordings[0].joints
    now = _stands(sets)
    if now < LEAST:
        return None
    kept = {one.conventions for one in recordings}
    if len(kept) == 1:  # the option to give is looked for from what the files hold
        sets = [[_undone(motion, *kept) for motion in group] for group in sets]
    doubts = DOUBTS if is_leg(joints) else ((SLIGHT_DOUBT, TIMES),)
    enough = min(GOOD, now / min(times for least, times in doubts if now >= least))
    kinds: list[ConventionHypothesis] = []
    left = np.zeros(0)
    still = all(motion.base is None for group in sets for motion in group)
    for stage in _stages(now, _turning(sets), joints, still):
        more = stage([kinds[k] for k in np.argsort(left, kind="stable")[:BEAM]])
        kinds = [*kinds, *more]
        left = np.concatenate([left, _left(sets, more, AS_GOOD * enough)])
        if left.min(initial=np.inf) <= min(enough, SLIGHT_DOUBT):  # beyond, it would be doubted itself
            break
    best = float(left.min())
    if best > enough:
        return None
    as_good = [k for k in range(len(kinds)) if left[k] <= AS_GOOD * best]
    few = min(_cost(kinds[k]) for k in as_good)
    chosen = sorted((k for k in as_good if _cost(kinds[k]) == few), key=lambda k: float(left[k]))
    others = tuple(kinds[k] for k in chosen[1:4])
    if any(one.name.count("-motor") for one in kinds[chosen[0]].names):
        return Better(_refined(sets, kinds[chosen[0]]), now, float(left[chosen[0]]), ())
    return Better(kinds[chosen[0]], now, float(left[chosen[0]]), others)


def _stands(sets: Sequence[Sequence[Smooth]]) -> float:
    """Return the share that is left of the torques' power as the recordings stand."""
    return float(_left(sets, [_reading((), sets[0][0].joints)])[0])


Stage = Callable[[Sequence[ConventionHypothesis]], Sequence[ConventionHypothesis]]
"""What is tried next, given the best readings so far."""


def _stages(now: float, turning: Sequence[int], joints: tuple[Joint, ...] = LEG, still: bool = True) -> Iterator[Stage]:
    """Yield the readings to try, in stages: the simple ones and gears of the joints `turning`; where the recordings as
    they stand leave very much (`now`), degrees and all combinations too. Of many joints there are too many readings:
    the best of one name are given a second one, and so on, only then. On a base that is not `still` the machine
    mirrored is another one.
    """
    all_tried = len(joints) <= FEW_JOINTS
    yield lambda best: readings(FEW if all_tried else 1, joints, still)
    if now > WRONG and not all_tried:
        yield lambda best: _extended(best, joints, still)
    yield lambda best: [*(_in_degrees(joints) if now > WRONG else ()), *_geared_readings(turning, joints)]
    if now > WRONG and all_tried:
        yield lambda best: [one for one in readings(MOST, joints, still) if len(one.names) > FEW]
    if now > WRONG and not all_tried:
        for _ in range(MOST - FEW):
            yield lambda best: _extended(best, joints, still)


def _extended(
    best: Sequence[ConventionHypothesis], joints: tuple[Joint, ...], still: bool
) -> Sequence[ConventionHypothesis]:
    """Return `best` with one name more each, mirrored ones once."""
    found: dict[tuple[float, ...], ConventionHypothesis] = {_key(one.map, joints, still): one for one in best}
    known = set(found)
    for one, group in product(best, _groups_of_names(joints)):
        if not any(named.name in option for named in one.names for option in group):
            for option in group:
                longer = _reading((*(named.name for named in one.names), *option), joints)
                found.setdefault(_key(longer.map, joints, still), longer)
    return [one for key, one in found.items() if key not in known]


def _turning(sets: Sequence[Sequence[Smooth]]) -> list[int]:
    """Return the joints that move so far that their angles may be those of motors."""
    reach = np.max([np.ptp(motion.q, axis=0) for group in sets for motion in group], axis=0)
    return [k for k, joint in enumerate(sets[0][0].joints) if joint.turns and reach[k] > TURNING]


Options = list[tuple[str, ...]]
LEG_OPTIONS: tuple[Options, ...] = (
    [("swapped-joints",), ("swapped-torques",), ("swapped-angles",)],
    [("flexion-positive",), ("hip-extension-positive",)],
    [("hip-angle-negated",), ("knee-angle-negated",)],
    [("knee-torque-negated",), ("hip-torque-negated",), ("load-torque",)],
    [("hip-from-upright",), ("hip-from-horizontal",), ("hip-from-horizontal-backwards",)],
    [("included-knee-angle",), ("shank-from-horizontal",), ("shank-from-horizontal-backwards",)],
    [("absolute-shank",)],
    [("base-driven-shank",)],
)
"""Names of which one reading has at most one each."""


def _groups_of_names(joints: tuple[Joint, ...]) -> Sequence[Options]:
    """Return the names of a machine's conventions, in groups of which one reading has at most one each."""
    if is_leg(joints):
        return LEG_OPTIONS
    found: dict[str, Options] = {}
    for name, one in conventions_of_machine(joints).items():
        if name != "degrees":
            found.setdefault(_group(name, one.order, joints), []).append((name,))
    return list(found.values())


def _group(name: str, order: int, joints: Sequence[Joint]) -> str:
    """Return what is the same for conventions that exclude each other: all channels once, a joint's sign, its zero."""
    if order == 0 or name == "load-torque":
        return name.partition("-")[0]
    if name == "absolute-angles":
        return name
    own = next(joint.name for joint in joints if joint.name in name.split("-"))
    return f"{min(order, 4)} {own} {name.startswith('base-driven')}"


@cache
def readings(most: int = MOST, joints: tuple[Joint, ...] = LEG, still: bool = True) -> tuple[ConventionHypothesis, ...]:
    """Return every reading of signs, zeros, sides and partners with at most so many names, mirrored ones once where
    the base is `still`, the simplest name of each.
    """
    possible = [_reading(names, joints) for names in _chosen(_groups_of_names(joints), most) if _makes_sense(names)]
    found: dict[tuple[float, ...], ConventionHypothesis] = {}
    for one in sorted(possible, key=_cost):
        found.setdefault(_key(one.map, joints, still), one)
    return tuple(found.values())


def _chosen(groups: Sequence[Options], most: int) -> Iterator[tuple[str, ...]]:
    """Yield every choice of at most one of each group, of at most so many in all."""
    if not groups:
        yield ()
        return
    for option in ((), *groups[0]):
        if len(option) <= most:
            for rest in _chosen(groups[1:], most - len(option)):
                yield option + rest


def _makes_sense(names: tuple[str, ...]) -> bool:
    """Whether a shank angle that counts from the horizontal is an absolute one."""
    return "absolute-shank" in names or not any(name.startswith("shank-from") for name in names)


def _reading(names: Iterable[str], joints: tuple[Joint, ...] = LEG) -> ConventionHypothesis:
    chosen = conventions(tuple(names), joints)
    return ConventionHypothesis(chosen, combined_map(chosen, joints))


def _cost(one: ConventionHypothesis) -> float:
    """Return how many changes a reading needs; among equals the usual ones cost a little less."""
    return round(len(one.names) + sum(c.unusual for c in one.names), 6)


def _key(to: Map, joints: Sequence[Joint], still: bool = True) -> tuple[float, ...]:
    """Return what is the same for two maps of which one is the other's mirror image, where the base is `still`.

    A mirror leaves what slides along a link alone; where all joints slide, it stands at the end of the way.
    """
    turns = np.array([float(joint.turns) for joint in joints])
    mirror = 1.0 - 2.0 * (turns if turns.any() else 1.0)
    keys = []
    for sign in (np.ones(len(joints)), mirror * np.ones(len(joints)))[: 2 if still else 1]:
        zero = np.round(np.mod(sign * to.zero, 2 * np.pi), 6) % round(2 * np.pi, 6)
        parts = [np.round(sign[:, None] * rows, 6).ravel() for rows in (to.angle, to.torque)]
        keys.append(tuple(float(x) for x in np.concatenate([parts[0], zero, parts[1]]) + 0.0))
    return max(keys)


@cache
def _in_degrees(joints: tuple[Joint, ...]) -> tuple[ConventionHypothesis, ...]:
    if not any(joint.turns for joint in joints):
        return ()
    some = readings(FEW if len(joints) <= FEW_JOINTS else 1, joints)
    return tuple(_reading(("degrees", *(c.name for c in one.names)), joints) for one in some)


def _geared_readings(turning: Sequence[int], joints: tuple[Joint, ...]) -> list[ConventionHypothesis]:
    """Return readings on the motor's side of a gear, with the usual signs."""
    signs = ((), ("flexion-positive",)) if is_leg(joints) else ((),)
    out = []
    for ratio, joint, part, sign in product(RATIOS, turning, ("", "angle"), signs):
        names = (gear(joint, part, float(ratio), joints), *conventions(sign, joints))
        out.append(ConventionHypothesis(names, combined_map(names, joints)))
    if len(turning) > 1:
        for ratio, part in product(RATIOS, ("", "angle")):
            names = tuple(gear(joint, part, float(ratio), joints) for joint in turning)
            out.append(ConventionHypothesis(names, combined_map(names, joints)))
    return out


def _refined(sets: Sequence[Sequence[Smooth]], one: ConventionHypothesis) -> ConventionHypothesis:
    """Return a reading with gears whose ratio is searched between its neighbours on the grid."""
    joints = sets[0][0].joints

    def at(change: float) -> ConventionHypothesis:
        names = []
        for old in one.names:
            stem, equals, ratio = old.name.partition("=")
            names.append(_geared(stem, float(ratio) * change, joints) if equals else old)
        return ConventionHypothesis(tuple(names), combined_map(names, joints))

    step = float(np.log(RATIOS[-1] / RATIOS[-2]))
    grid = np.linspace(-step, step, 41)

    def share(x: float) -> float:
        return float(_left(sets, [at(float(np.exp(x)))])[0])

    left = [share(float(x)) for x in grid]
    near, wide = float(grid[int(np.argmin(left))]), float(grid[1] - grid[0])
    change, least = minimum(share, near - wide, near + wide, 1e-5)
    best = at(float(np.exp(change)))
    rounded = _rounded(best, joints)
    return rounded if _left(sets, [rounded])[0] <= AS_GOOD * least else best


def _rounded(one: ConventionHypothesis, joints: tuple[Joint, ...]) -> ConventionHypothesis:
    """Return a reading whose gear ratios are whole numbers, of two digits at most."""
    names = []
    for old in one.names:
        stem, equals, ratio = old.name.partition("=")
        names.append(
            _geared(stem, float(f"{float(ratio):.2g}") if float(ratio) > 10 else round(float(ratio)), joints)
            if equals
            else old
        )
    return ConventionHypothesis(tuple(names), combined_map(names, joints))


def _geared(stem: str, ratio: float, joints: tuple[Joint, ...]) -> Convention:
    return conventions(f"{stem}={ratio:.4f}".rstrip("0").rstrip("."), joints)[0]


def _groups(recordings: Sequence[Recording], weighs: bool = True) -> list[list[Smooth]]:
    """Return the smoothed recordings that move and carry torque, those with the same known masses together."""
    groups: dict[object, list[Smooth]] = {}
    for one in recordings:
        motion = smooth(one)
        reach = [joint.reach for joint in one.joints]
        if (
            motion is not None
            and np.any(motion.q.std(axis=0) > 0.02 * np.array(reach))
            and np.any(motion.tau.std(axis=0) > 0.0)
        ):
            groups.setdefault(one.payloads, []).append(motion if weighs else replace(motion, weighs=False))
    return list(groups.values())


def _undone(motion: Smooth, names: tuple[str, ...]) -> Smooth:
    """Return `motion` as it was before the conventions `names` were taken into account."""
    to = combined_map(conventions(names, motion.joints), motion.joints)
    back = np.linalg.inv(to.angle).T
    q, tau = (motion.q - to.zero) @ back, motion.tau @ np.linalg.inv(to.torque).T
    return replace(motion, q=q, dq=motion.dq @ back, ddq=motion.ddq @ back, tau=tau)


def _left(sets: Sequence[Sequence[Smooth]], kinds: Sequence[ConventionHypothesis], most: float = np.inf) -> Float:
    """Return for each reading the share of the torques' power, summed over the joints, that the pendulum leaves.

    Of readings that leave more than `most` a lower bound may be returned instead: that of free least squares.
    """
    samples = sum(len(range(m.q.shape[0])[m.keep]) for group in sets for m in group)
    thin = max(1, samples // ROWS)
    thinned = [[_rows(m, thin) for m in group] for group in sets]
    stands = STANDS * np.array([joint.reach for joint in sets[0][0].joints])
    moves = [[m.q[m.keep].std(axis=0) > stands for m in group] for group in sets]
    alike: dict[bytes, list[int]] = {}
    for k, kind in enumerate(kinds):
        alike.setdefault(np.concatenate([kind.map.angle.ravel(), kind.map.zero]).tobytes(), []).append(k)
    out = np.zeros(len(kinds))
    for places in alike.values():
        sums = [_sums(group, moving, kinds[places[0]].map) for group, moving in zip(thinned, moves, strict=True)]
        out[places] = _shares(sums, np.stack([kinds[k].map.torque for k in places]), most)
    return out


def _rows(motion: Smooth, thin: int) -> Smooth:
    keep = np.arange(motion.q.shape[0])[motion.keep][::thin]
    q, dq, ddq, tau = (rows[keep] for rows in (motion.q, motion.dq, motion.ddq, motion.tau))
    return replace(motion, q=q, dq=dq, ddq=ddq, tau=tau, base=None if motion.base is None else motion.base[keep])


@dataclass(frozen=True, eq=False)
class _Sums:
    """Sums over the samples of recordings in which the joint of torque k moves: `gram` (K, J, J, P, P) of two joints'
    columns, `slope` (J, K, P) of joint j's columns with torque k, `power` (K,) of the torques around their means.
    `near` (K, K) says which joints are neighbours (None: all).
    """

    gram: Float
    slope: Float
    power: Float
    near: NDArray[np.bool_] | None = None


def _sums(group: Sequence[Smooth], moves: Sequence[np.ndarray], to: Map) -> _Sums:
    tau = np.concatenate([motion.tau for motion in group])
    counts = np.concatenate([np.repeat(m[None], len(one.q), axis=0) for m, one in zip(moves, group, strict=True)])
    mean = np.sum(tau * counts, axis=0) / np.maximum(counts.sum(axis=0), 1)
    tau = (tau - mean) * counts  # constant offsets are nobody's sign
    q, dq, ddq = (np.concatenate(parts) for parts in zip(*((one.q, one.dq, one.ddq) for one in group), strict=True))
    known = [one.base for one in group if one.base is not None]
    base = np.concatenate(known) if len(known) == len(group) else None
    turn = to.angle.T
    whole = replace(group[0], q=q @ turn + to.zero, dq=dq @ turn, ddq=ddq @ turn, tau=tau, base=base)
    y = np.concatenate([machine_columns(whole), _stops(whole.q)], axis=2)
    flat = y.transpose(1, 0, 2).reshape(len(tau), -1)
    size, count = y.shape[2], tau.shape[1]
    grams = [
        (part.T @ part).reshape(count, size, count, size).transpose(0, 2, 1, 3)
        for part in (flat[counts[:, k]] for k in range(count))
    ]
    slope = (flat.T @ tau).reshape(count, size, count).transpose(0, 2, 1)
    near = np.eye(count, dtype=bool)
    for k, above in enumerate(parents(whole.joints)):
        if above is not None:
            near[k, above] = near[above, k] = True
    return _Sums(np.array(grams), slope, np.sum(tau**2, axis=0), near)


def _stops(q: Float) -> Float:
    """Return columns (J, K, 2 J) of what pushes back near the ends of each joint's range: stops, tendons, straps.

    Without them a machine that runs into its stop would look like one that is read wrongly.
    """
    joints = q.shape[1]
    out = np.zeros((joints, len(q), 2 * joints))
    for joint in range(joints):
        low, high = np.quantile(q[:, joint], STOP)
        out[joint, :, 2 * joint] = np.maximum(q[:, joint] - high, 0.0)
        out[joint, :, 2 * joint + 1] = np.minimum(q[:, joint] - low, 0.0)
    return out


def _factor(scaled: Float) -> Float:
    """Return the Cholesky factors of Gram matrices (M, P, P), which rounding may have left slightly indefinite."""
    try:
        return np.asarray(np.linalg.cholesky(scaled), dtype=float)
    except np.linalg.LinAlgError:
        least = np.linalg.eigvalsh(scaled)[:, :1, None]
        lifted = scaled + np.maximum(1e-10 - 2.0 * least, 0.0) * np.eye(scaled.shape[1])
        return np.asarray(np.linalg.cholesky(lifted), dtype=float)


def _shares(groups: Sequence[_Sums], torques: Float, most: float) -> Float:
    """Return for each torque map (M, J, J) the share of the power left, each group fitted on its own.

    What is left counts in the torques as they were recorded, so that no reading gains by mixing them.
    """
    power = np.sum([s.power for s in groups], axis=0)
    near = groups[0].near
    largest = np.full(power.shape, power.max()) if near is None else np.where(near, power, 0.0).max(axis=1)
    least = np.where(power < PASSIVE**2 * largest, 1.0, QUIET**2) * largest
    weight = 1.0 / np.maximum(np.maximum(power, least), 1e-24)
    back = np.linalg.inv(torques)
    squares = np.einsum("k,mkj,mkl->mkjl", weight, back, back)
    ready = []
    bound = np.zeros(len(torques))
    for s in groups:
        gram = np.tensordot(squares, s.gram, 3)
        slope = np.tensordot(back * weight[:, None], s.slope.transpose(1, 0, 2), 2)
        square = np.diagonal(gram, axis1=1, axis2=2)
        # Columns that cancel, or of a joint that stands, are zero but for rounding: they are left out.
        size = np.sqrt(np.where(square > ROUNDING * square.max(axis=1, keepdims=True), square, np.inf))
        scaled = gram / (size[:, :, None] * size[:, None, :]) + 1e-10 * np.eye(size.shape[1])
        lower = _factor(scaled)
        side = np.linalg.solve(lower, (slope / size)[:, :, None])[:, :, 0]
        total = float(weight @ s.power)
        ready.append((scaled, slope / size, lower, side))
        bound += np.maximum(total - np.sum(side**2, axis=1), 0.0)
    for m in np.flatnonzero(bound <= most):
        # |lowerᵀx - side|² falls short of the loss by what no x explains.
        for gram, slope, lower, side in ready:
            short = lower[m].T @ non_negative(gram[m], slope[m]) - side[m]
            bound[m] += float(short @ short)
    return bound
