"""The readings of recordings that are tried: combinations of conventions, a machine and its mirror image once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.rough import Smooth
from exoid.measurement.reading.conventions import (
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
WRONG: Threshold = 0.4
"""share of power left, from which readings of three and four names are tried: chance fits some"""
TURNING: Threshold = 2.5
"""rad that a joint moves at least where its angle may be that of a motor: every small motion fits some gear"""
LOAD = "load-torque"
"""The convention of which all torques have the other sign."""
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
    def option(self) -> str:
        """The reading as `--convention` takes it."""
        return ",".join(name.name for name in self.names)

    @property
    def cost(self) -> float:
        """Number of changes that it needs; among equals the usual ones cost a little less."""
        return round(len(self.names) + sum(name.unusual for name in self.names), 6)

    @property
    def sums(self) -> bool:
        """True if joints' torques are sums of the recorded ones."""
        return any(name.sums for name in self.names)


def stages(
    now: float, turning: Sequence[int], joints: tuple[Joint, ...] = LEG, still: bool = True, several: bool = False
) -> Iterator[Callable[[Sequence[ConventionHypothesis]], Sequence[ConventionHypothesis]]]:
    """Yield the readings to try, in stages that are given the best so far: the simple ones and gears of the joints
    `turning`; where the recordings as they stand leave very much (`now`), degrees and all combinations too. Of many
    joints there are too many readings: the best of one name are given a second one, and so on, only then. On a base
    that is not `still` the machine mirrored is another one. Sums of torques are asked of `several` recordings only:
    some fit any single one. In space every pair of signs and zeros is tried: of two wrong zeros one put right may look
    no better than none.
    """
    spatial, very = is_spatial(joints), now > WRONG
    all_tried = len(joints) <= FEW_JOINTS and not spatial

    def longer(best: Sequence[ConventionHypothesis]) -> Sequence[ConventionHypothesis]:
        """Return the `best` with one name more each, mirrored ones once."""
        items = (
            hypothesis((*(named.name for named in item.names), name), joints)
            for item, group in product(best[: BEAM_IN_SPACE if spatial else BEAM], _groups_of_names(joints))
            if not any(named.name in group for named in item.names)
            for name in group
        )
        return _distinct(items, joints, still, best)

    yield lambda best: readings(FEW if all_tried else 1, joints, still)
    if very and not (all_tried or spatial):
        yield longer
    turned = any(joint.turns for joint in joints)
    in_degrees = readings(FEW if len(joints) <= FEW_JOINTS else 1, joints, still) if very and turned else ()
    yield lambda best: [
        *(hypothesis(("degrees", *(name.name for name in item.names)), joints) for item in in_degrees),
        *_geared(turning, joints),
    ]
    if spatial:
        own = [group for group in _groups_of_names(joints) if not group[0].startswith("swapped-")]
        yield lambda best: [hypothesis(names, joints) for names in _chosen(own, FEW) if len(names) == FEW]
    if very and all_tried:
        yield lambda best: [reading for reading in readings(MOST, joints, still) if len(reading.names) > FEW]
    elif very or spatial:
        yield from (longer,) * (MOST - FEW)
    if very and several and len(joints) == FEW_JOINTS and not spatial and joints[0].turns == joints[1].turns:
        yield lambda best: _of_two_drives(joints, still)


def turning_joints(motions: Sequence[Smooth]) -> list[int]:
    """Return the joints that move so far that their angles may be those of motors."""
    reach = np.max([np.ptp(motion.q, axis=0) for motion in motions], axis=0)
    return [k for k, joint in enumerate(motions[0].joints) if joint.turns and reach[k] > TURNING]


def _groups_of_names(joints: tuple[Joint, ...]) -> list[list[str]]:
    """Return the names of a machine's conventions, in groups of which one reading has at most one each."""
    found: dict[object, list[str]] = {}
    for name, convention in conventions_of_machine(joints).items():
        if name != "degrees":
            found.setdefault(_group(convention, len(joints)), []).append(name)
    if not is_leg(joints):
        return list(found.values())
    # Of readings with several sets of names the first is told, and a leg's has the usual ones in this order.
    return sorted((names[::-1] for names in found.values()), key=lambda names: names[0] != LOAD)


def _group(item: Convention, joints: int) -> object:
    """Return a key that conventions share which exclude each other: all channels once, a joint's sign, its zero."""
    if item.order < 2 or item.name in (LOAD, "absolute-angles"):
        return item.order, item.name if item.order > 1 else ""
    rows = item.angle or item.torque
    changed = np.diag(item.zero) if rows is None else np.array(rows) - np.eye(joints)
    return min(item.order, 4), int(np.max(np.nonzero(changed))), item.order > 3 and item.angle is None


@cache
def readings(most: int = MOST, joints: tuple[Joint, ...] = LEG, still: bool = True) -> tuple[ConventionHypothesis, ...]:
    """Return every reading of signs, zeros, sides and partners with at most so many names, mirrored ones once where
    the base is `still`, the simplest name of each.
    """
    possible = [
        hypothesis(names, joints)
        for names in _chosen(_groups_of_names(joints), most)  # a shank against the horizontal is an absolute one
        if "absolute-shank" in names or not any(name.startswith("shank-from") for name in names)
    ]
    return _distinct(sorted(possible, key=lambda item: item.cost), joints, still)


def _chosen(groups: Sequence[Sequence[str]], most: int) -> Iterator[tuple[str, ...]]:
    """Yield every choice of at most one of each group, of at most so many in all."""
    if not groups or not most:
        yield ()
        return
    yield from _chosen(groups[1:], most)
    for name in groups[0]:
        yield from ((name, *rest) for rest in _chosen(groups[1:], most - 1))


def _distinct(
    items: Iterable[ConventionHypothesis],
    joints: tuple[Joint, ...],
    still: bool,
    known: Iterable[ConventionHypothesis] = (),
) -> tuple[ConventionHypothesis, ...]:
    """Return the first of all `items` that read alike, mirrored where the base is `still`, without those `known`."""
    seen = {_key(item.map, joints, still) for item in known}
    found: dict[tuple[float, ...], ConventionHypothesis] = {}
    for item in items:
        found.setdefault(_key(item.map, joints, still), item)
    return tuple(item for key, item in found.items() if key not in seen)


def hypothesis(names: Iterable[str], joints: tuple[Joint, ...] = LEG) -> ConventionHypothesis:
    """Return the reading of the conventions with these `names`."""
    return reading_of(conventions(tuple(names), joints), joints)


def reading_of(chosen: Iterable[Convention], joints: tuple[Joint, ...]) -> ConventionHypothesis:
    """Return the reading of the conventions `chosen`."""
    names = tuple(sorted(chosen, key=lambda item: item.order))  # as they are applied
    return ConventionHypothesis(names, combined_map(names, joints))


def _key(to: Map, joints: Sequence[Joint], still: bool) -> tuple[float, ...]:
    """Return a key that two maps share of which one is the other's mirror image, where the base is `still`: a mirror
    leaves what slides along a link alone, and where all joints slide, it stands at the end of the way.
    """
    turns = np.array([float(joint.turns) for joint in joints])
    mirror = 1.0 - 2.0 * (turns if turns.any() else 1.0)
    keys = []
    for sign in (np.ones(len(joints)), mirror * np.ones(len(joints)))[: 1 + still]:
        zero = np.round(np.mod(sign * to.zero, 2 * np.pi), 6) % round(2 * np.pi, 6)
        rows = np.round(sign[:, None] * np.column_stack([to.angle, to.torque]), 6).ravel()
        keys.append(tuple((np.concatenate([rows, zero]) + 0.0).tolist()))
    return max(keys)


@cache
def _of_two_drives(joints: tuple[Joint, ...], still: bool) -> tuple[ConventionHypothesis, ...]:
    """Return the readings of two recorded torques of which the joints' are sums or differences, as of a differential
    or of a driver that maps them wrongly, with the angles as they stand or with one name.
    """
    angles = [item.names for item in readings(1, joints, still) if all(name.torque is None for name in item.names)]
    items = (
        reading_of((torque_sums((times[:2], times[2:]), joints), *names), joints)
        for names, times in product(angles, product(SUMMED, repeat=4))
        if abs(times[0] * times[3] - times[1] * times[2]) in (1, 2)
    )
    return _distinct(items, joints, still, readings(MOST, joints, still))


def _geared(turning: Sequence[int], joints: tuple[Joint, ...]) -> list[ConventionHypothesis]:
    """Return readings on the motor's side of a gear, with the usual signs."""
    signs = [conventions(sign, joints) for sign in (("", "flexion-positive") if is_leg(joints) else ("",))]
    parts, ratios = ("", "angle"), RATIOS.tolist()
    chosen = [(gear(k, part, ratio, joints), *sign) for part, sign, ratio, k in product(parts, signs, ratios, turning)]
    if len(turning) > 1:
        chosen += [tuple(gear(k, part, ratio, joints) for k in turning) for ratio, part in product(ratios, parts)]
    if is_spatial(joints):  # links share their numbers with those that carry them: a torque of another size is seen
        turns = [k for k, joint in enumerate(joints) if joint.turns]
        chosen += [(gear(k, "torque", ratio, joints),) for ratio, k in product(ratios, turns)]
    return [reading_of(names, joints) for names in chosen]
