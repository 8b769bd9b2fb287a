"""The readings of recordings that are tried: combinations of conventions, a machine and its mirror image once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np

from exoid.ground.thresholds import threshold
from exoid.measurement.auditing.rough import Smooth
from exoid.measurement.reading.conventions import (
    MOTORS,
    Convention,
    Map,
    combined_map,
    conventions,
    conventions_of_machine,
    gear,
    torque_sums,
)
from exoid.symbolic.joints import LEG, Joint, is_leg, is_spatial

FEW, MOST = 2, 4
"""Readings of few names are tried first; those of more only where the recordings as they stand leave `WRONG`."""
FEW_JOINTS, BEAM = 2, 16
"""Joints up to which every combination is tried; beyond, how many readings get one name more."""
BEAM_IN_SPACE = 4
"""The same in space, where all pairs are tried before."""
WRONG = threshold(
    __name__, "WRONG", 0.4,
    "share of power left, from which readings of three and four names are tried: chance fits some",
)  # fmt: skip
TURNING = threshold(
    __name__, "TURNING", 2.5,
    "rad that a joint moves at least where its angle may be that of a motor: every small motion fits some gear",
)  # fmt: skip
SUMMED = (1, 0, -1, 2, -2)
"""How often a recorded torque counts in a joint's, the usual first."""
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
        return " and ".join(name.what for name in self.names) or "angles and torques need no --convention"

    @property
    def sums(self) -> bool:
        """True if joints' torques are sums of the recorded ones."""
        return any(name.sums for name in self.names)

    @property
    def sides(self) -> bool:
        """True if it only changes signs and exchanges channels."""
        return all(name.order in (0, 2) for name in self.names)


Stage = Callable[[Sequence[ConventionHypothesis]], Sequence[ConventionHypothesis]]
"""What is tried next, given the best readings so far."""


def stages(
    now: float, turning: Sequence[int], joints: tuple[Joint, ...] = LEG, still: bool = True, several: bool = False
) -> Iterator[Stage]:
    """Yield the readings to try, in stages: the simple ones and gears of the joints `turning`; where the recordings as
    they stand leave very much (`now`), degrees and all combinations too. Of many joints there are too many readings:
    the best of one name are given a second one, and so on, only then. On a base that is not `still` the machine
    mirrored is another one. Sums of torques are asked of `several` recordings only: some fit any single one.
    """
    if is_spatial(joints):
        yield from _stages_in_space(now, turning, joints)
        return
    all_tried = len(joints) <= FEW_JOINTS
    yield lambda best: readings(FEW if all_tried else 1, joints, still)
    if now > WRONG and not all_tried:
        yield lambda best: _extended(best, joints, still)
    yield lambda best: [*(_in_degrees(joints, still) if now > WRONG else ()), *_geared_readings(turning, joints)]
    if now > WRONG and all_tried:
        yield lambda best: [reading for reading in readings(MOST, joints, still) if len(reading.names) > FEW]
    if now > WRONG and not all_tried:
        for _ in range(MOST - FEW):
            yield lambda best: _extended(best, joints, still)
    if now > WRONG and several and len(joints) == FEW_JOINTS:
        yield lambda best: _of_two_drives(joints, still)


def _stages_in_space(now: float, turning: Sequence[int], joints: tuple[Joint, ...]) -> Iterator[Stage]:
    """Yield the same for a spatial machine: every pair of signs and zeros too, since of two wrong zeros one put right
    may look no better than none.
    """
    yield lambda best: readings(1, joints, False)
    # Links share their numbers with those that carry them, so that a torque of another size alone is seen.
    torques = [k for k, joint in enumerate(joints) if joint.turns]
    geared = [*_geared_readings(turning, joints), *_geared(torques, "torque", joints)]
    yield lambda best: [*(_in_degrees(joints, False) if now > WRONG else ()), *geared]
    own = [group for group in _groups_of_names(joints) if not group[0][0].startswith("swapped-")]
    pairs = (hypothesis(names, joints) for names in _chosen(own, FEW) if len(names) == FEW)
    yield lambda best: list(pairs)
    for _ in range(MOST - FEW):
        yield lambda best: _extended(best[:BEAM_IN_SPACE], joints, False)


def _extended(
    best: Sequence[ConventionHypothesis], joints: tuple[Joint, ...], still: bool
) -> Sequence[ConventionHypothesis]:
    """Return `best` with one name more each, mirrored ones once."""
    found: dict[tuple[float, ...], ConventionHypothesis] = {_key(entry.map, joints, still): entry for entry in best}
    known = set(found)
    for item, group in product(best, _groups_of_names(joints)):
        if not any(named.name in option for named in item.names for option in group):
            for option in group:
                longer = hypothesis((*(named.name for named in item.names), *option), joints)
                found.setdefault(_key(longer.map, joints, still), longer)
    return [element for key, element in found.items() if key not in known]


def turning_joints(sets: Sequence[Sequence[Smooth]]) -> list[int]:
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
    for name, convention in conventions_of_machine(joints).items():
        if name != "degrees":
            found.setdefault(_group(name, convention.order, joints), []).append((name,))
    return list(found.values())


def _group(name: str, order: int, joints: Sequence[Joint]) -> str:
    """Return a key that conventions share which exclude each other: all channels once, a joint's sign, its zero."""
    if order == 0 or name == "load-torque" or name.partition("-")[0] == MOTORS:
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
    possible = [hypothesis(names, joints) for names in _chosen(_groups_of_names(joints), most) if _makes_sense(names)]
    found: dict[tuple[float, ...], ConventionHypothesis] = {}
    for item in sorted(possible, key=cost_of):
        found.setdefault(_key(item.map, joints, still), item)
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
    """True if a shank angle that counts from the horizontal is an absolute one."""
    return "absolute-shank" in names or not any(name.startswith("shank-from") for name in names)


def hypothesis(names: Iterable[str], joints: tuple[Joint, ...] = LEG) -> ConventionHypothesis:
    """Return the reading of the conventions with these `names`."""
    chosen = conventions(tuple(names), joints)
    return ConventionHypothesis(chosen, combined_map(chosen, joints))


def cost_of(one: ConventionHypothesis) -> float:
    """Number of changes that a reading needs; among equals the usual ones cost a little less."""
    return round(len(one.names) + sum(c.unusual for c in one.names), 6)


def _key(to: Map, joints: Sequence[Joint], still: bool = True) -> tuple[float, ...]:
    """Return a key that two maps share of which one is the other's mirror image, where the base is `still`.

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
def _in_degrees(joints: tuple[Joint, ...], still: bool) -> tuple[ConventionHypothesis, ...]:
    if not any(joint.turns for joint in joints):
        return ()
    some = readings(FEW if len(joints) <= FEW_JOINTS else 1, joints, still)
    return tuple(hypothesis(("degrees", *(c.name for c in item.names)), joints) for item in some)


@cache
def _of_two_drives(joints: tuple[Joint, ...], still: bool) -> tuple[ConventionHypothesis, ...]:
    """Return the readings of two recorded torques of which the joints' are sums or differences, as of a differential
    or of a driver that maps them wrongly, with the angles as they stand or with one name.
    """
    if joints[0].turns != joints[1].turns:
        return ()
    known = {_key(item.map, joints, still) for item in readings(MOST, joints, still)}
    angles = [item.names for item in readings(1, joints, still) if all(name.torque is None for name in item.names)]
    found: dict[tuple[float, ...], ConventionHypothesis] = {}
    for names, times in product(angles, product(SUMMED, repeat=4)):
        if abs(times[0] * times[3] - times[1] * times[2]) in (1, 2):
            chosen = sorted((torque_sums((times[:2], times[2:]), joints), *names), key=lambda one: one.order)
            item = ConventionHypothesis(tuple(chosen), combined_map(chosen, joints))
            if (key := _key(item.map, joints, still)) not in known:
                found.setdefault(key, item)
    return tuple(found.values())


def _geared_readings(turning: Sequence[int], joints: tuple[Joint, ...]) -> list[ConventionHypothesis]:
    """Return readings on the motor's side of a gear, with the usual signs."""
    signs = ((), ("flexion-positive",)) if is_leg(joints) else ((),)
    out = [item for part in ("", "angle") for sign in signs for item in _geared(turning, part, joints, sign)]
    if len(turning) > 1:
        for ratio, part in product(RATIOS, ("", "angle")):
            names = tuple(gear(joint, part, float(ratio), joints) for joint in turning)
            out.append(ConventionHypothesis(names, combined_map(names, joints)))
    return out


def _geared(
    those: Sequence[int], part: str, joints: tuple[Joint, ...], sign: tuple[str, ...] = ()
) -> list[ConventionHypothesis]:
    """Return the readings of which one of `those` joints has its `part` on the motor's side of a gear."""
    chosen = (
        (gear(joint, part, float(ratio), joints), *conventions(sign, joints))
        for ratio, joint in product(RATIOS, those)
    )
    return [ConventionHypothesis(names, combined_map(names, joints)) for names in chosen]


def geared(stem: str, ratio: float, joints: tuple[Joint, ...]) -> Convention:
    """Return the convention `stem` (hip-motor) with this gear ratio."""
    return conventions(f"{stem}={ratio:.4f}".rstrip("0").rstrip("."), joints)[0]
