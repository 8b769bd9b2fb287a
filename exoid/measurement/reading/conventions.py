"""The usual ways of counting angles and torques, by name, and how each becomes exoid's own.

exoid's hip angle counts from the downward vertical, its knee angle is relative to the thigh with flexion negative,
and each torque is what the drive of that joint exerts. A convention is an affine map of the angles and a linear map of
the torques; a change of sign or of the side of a gear maps both so that power stays the same. They are made for any
machine from its joints' names; the leg's have words of their own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import RecordingError
from exoid.ground.suggest import did_you_mean
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import LEG, Joint, Rows, ancestors, is_leg, is_spatial, motors_of, names
from exoid.symbolic.motion import Float
from exoid.symbolic.units import DEGREE

QUARTER = 0.5 * math.pi
MOTORS = "motors"
"""Recordings of the motors' side of a model's couplings."""


@dataclass(frozen=True)
class Convention:
    """q = `angle` q_file + `zero` and tau = `torque` tau_file (rad, N·m; m, N where a joint slides), as the file has
    them where nothing is said; `order`: lower ones are applied first.

    `what` completes "it looks as if ...", `explains` says to a user what recordings of this convention hold. `unusual`
    counts, beside another reading with as many names, against it. Where joints' torques are `sums` of the recorded
    ones, the drives may stand elsewhere.
    """

    name: str
    order: int
    what: str
    explains: str
    angle: Rows | None = None
    torque: Rows | None = None
    zero: tuple[float, ...] = ()
    unusual: float = 0.0
    sums: bool = False


OF_THE_LEG: Mapping[str, tuple[str, str, str]] = {
    "swapped-angles-hip-knee": (
        "swapped-angles", "hip and knee angle are swapped", "q1 is the knee's, q2 the hip's"
    ),
    "swapped-torques-hip-knee": (
        "swapped-torques", "hip and knee torque are swapped", "tau1 is the knee's, tau2 the hip's"
    ),
    "swapped-joints-hip-knee": ("swapped-joints", "hip and knee are swapped", "both of these"),
    "degrees": ("degrees", "the angles are in degrees", "the same as --units q=deg"),
    "knee-negated": (
        "flexion-positive", "knee flexion is counted positive (angle and torque)",
        "knee angle and knee torque have the other sign, usual in biomechanics",
    ),
    "hip-negated": (
        "hip-extension-positive", "hip extension is counted positive (angle and torque)",
        "hip angle and hip torque have the other sign",
    ),
    "hip-angle-negated": ("hip-angle-negated", "the hip angle has the wrong sign", "only the hip angle has"),
    "knee-angle-negated": ("knee-angle-negated", "the knee angle has the wrong sign", "only the knee angle has"),
    "hip-torque-negated": ("hip-torque-negated", "the hip torque has the wrong sign", "only the hip torque has"),
    "knee-torque-negated": ("knee-torque-negated", "the knee torque has the wrong sign", "only the knee torque has"),
    "load-torque": (
        "load-torque", "both torques (or both angles) have the wrong sign",
        "torques are what the load exerts on the drives",
    ),
    "hip-from-upright": (
        "hip-from-upright", "the hip angle counts from upright", "q1 = 0 where the thigh points upwards"
    ),
    "hip-from-horizontal": (
        "hip-from-horizontal", "the hip angle counts from the horizontal",
        "q1 = 0 where the thigh points forwards, -90° where it hangs",
    ),
    "hip-from-horizontal-backwards": (
        "hip-from-horizontal-backwards", "the hip angle counts from the horizontal behind",
        "q1 = 0 where the thigh points backwards, +90° where it hangs",
    ),
    "included-knee-angle": (
        "included-knee-angle", "the knee angle is the one between thigh and shank",
        "q2 = 180° where the leg is straight, less where it is flexed",
    ),
    "knee-from-square": (
        "shank-from-horizontal", "the shank angle counts from the horizontal",
        "with absolute-shank: q2 = 0 where the shank points forwards",
    ),
    "knee-from-square-backwards": (
        "shank-from-horizontal-backwards", "the shank angle counts from the horizontal behind",
        "with absolute-shank: q2 = 0 where the shank points backwards",
    ),
    "absolute-knee": (
        "absolute-shank", "the second angle is that of the shank against the vertical, not against the thigh",
        "q2 = q1 + knee angle; the torques are those of the drives at hip and knee",
    ),
    "base-driven-knee": (
        "base-driven-shank", "the second torque acts between base and shank, not between thigh and shank",
        "a drive on the base pulls the shank by a belt or rod; with absolute-shank: generalised torques of the "
        "absolute angles",
    ),
}  # fmt: skip
"""What the conventions of any machine are called where it is the leg: name, what, explanation."""
UNUSUAL = {"hip-extension-positive": 0.2, "shank-from-horizontal-backwards": 0.0}
"""How unusual some of these are of a leg."""


@lru_cache(maxsize=64)
def conventions_of_machine(joints: tuple[Joint, ...] = LEG) -> Mapping[str, Convention]:
    """Return every convention with a name that recordings of a machine with these `joints` may keep, by name."""
    found = [*_swaps(joints), *_signs(joints), *_motors(joints)]
    if is_spatial(joints):
        turning = [k for k, joint in enumerate(joints) if joint.turns]
        found += [_zero(k, degrees, joints) for k in turning for degrees in ZEROS]
    else:  # angles against the vertical, and links in line with each other, are those of a plane
        found += [*_zeros(joints), *_absolute(joints)]
    if any(joint.turns for joint in joints):
        degrees = _rows(joints, {(k, k): DEGREE for k, joint in enumerate(joints) if joint.turns})
        found.append(
            Convention("degrees", 1, "the angles are in degrees", "the same as --units q=deg", degrees)
        )
    if is_leg(joints):
        words = ((item, *OF_THE_LEG[item.name]) for item in found)
        found = [
            replace(entry, name=name, what=what, explains=explains, unusual=UNUSUAL.get(name, entry.unusual))
            for entry, name, what, explains in words
        ]
    return {item.name: item for item in sorted(found, key=lambda item: item.order)}


def _rows(joints: Sequence[Joint], changed: Mapping[tuple[int, int], float]) -> Rows:
    """Return the identity (J, J) with the entries `changed`."""
    count = range(len(joints))
    return tuple(tuple(changed.get((k, m), float(k == m)) for m in count) for k in count)


def _swaps(joints: Sequence[Joint]) -> list[Convention]:
    """Return the conventions that exchange the channels of two joints of one kind."""
    found = []
    for a, b in combinations(range(len(joints)), 2):
        if joints[a].turns == joints[b].turns:
            other = _rows(joints, {(a, a): 0.0, (b, b): 0.0, (a, b): 1.0, (b, a): 1.0})
            pair = f"{joints[a].name} and {joints[b].name}"
            for part, angle, torque in (("angles", other, None), ("torques", None, other), ("joints", other, other)):
                name = f"swapped-{part}-{joints[a].name}-{joints[b].name}"
                what = f"{pair} are swapped" if part == "joints" else f"the {part} of {pair} are swapped"
                found.append(Convention(name, 0, what, "each is in the other's column", angle, torque))
    return found


def _signs(joints: Sequence[Joint]) -> list[Convention]:
    found = []
    for k, joint in enumerate(joints):
        angle, torque = ("angle", "torque") if joint.turns else ("position", "force")
        other = _rows(joints, {(k, k): -1.0})
        # A single joint whose angle is negated is the mirror image of one whose torque is.
        either = f" (or its {angle})" if len(joints) == 1 else ""
        for name, order, what, turned, forced in (
            ("torque-negated", 2, f"the {joint.name} {torque} has the wrong sign{either}", None, other),
            ("angle-negated", 2, f"the {joint.name} {angle} has the wrong sign", other, None),
            ("negated", 2, f"{angle} and {torque} of {joint.name} have the wrong sign", other, other),
        ):
            explains = f"{what.partition(' has ')[0].partition(' have ')[0]}: counted the other way"
            found.append(Convention(f"{joint.name}-{name}", order, what, explains, turned, forced))
    if len(joints) > 1:
        every = _rows(joints, {(k, k): -1.0 for k in range(len(joints))})
        what = "all torques (or all angles) have the wrong sign"
        explains = "torques are what the load exerts on the drives"
        found.append(Convention("load-torque", 2, what, explains, torque=every))
    return found


def _motors(joints: Sequence[Joint]) -> list[Convention]:
    """Return the conventions of recordings that hold what motors do, where the model says how these turn: their power
    is that of the joints.
    """
    if not any(joint.motor for joint in joints):
        return []
    turns = np.array(motors_of(joints))
    angle, torque = (tuple(tuple(map(float, row)) for row in rows) for rows in (np.linalg.inv(turns), turns.T))
    said = "the model's [[couplings]] say how motors turn"
    return [
        Convention(MOTORS, 1, "angles and torques are those of the motors", said, angle, torque),
        Convention(f"{MOTORS}-angles", 1, "the angles are those of the motors", said, angle),
        Convention(f"{MOTORS}-torques", 1, "the torques are those of the motors", said, torque=torque),
    ]


def _zeros(joints: Sequence[Joint]) -> list[Convention]:
    """Return the other zeros of angles: of a first link against the vertical, of a further one against its parent."""
    found = []
    for k, joint in enumerate(joints):
        if not joint.turns:
            continue
        name, hangs = joint.name, not any(joints[m].turns for m in ancestors(joints, k)[:-1])
        kinds: tuple[tuple[str, str, str, float], ...] = (
            (f"{name}-from-upright", "from upright", "zero where its link points upwards", math.pi),
            (f"{name}-from-horizontal", "from the horizontal", "zero where its link points forwards", QUARTER),
            (f"{name}-from-horizontal-backwards", "from the horizontal behind", "zero where its link points backwards",
             -QUARTER),
        ) if hangs else (
            (f"included-{name}-angle", "as the one between its link and the one before",
             "180° where the two are in line", -math.pi),
            (f"{name}-from-square", "from a right angle to the link before",
             f"zero where its link is square to the one before, turned forwards; with absolute-{name}: where it "
             "points forwards", QUARTER),
            (f"{name}-from-square-backwards", "from a right angle behind to the link before",
             f"zero where its link is square to the one before, turned backwards; with absolute-{name}: where it "
             "points backwards", -QUARTER),
        )  # fmt: skip
        for title, counts, explains, zero in kinds:
            shift = tuple(zero if m == k else 0.0 for m in range(len(joints)))
            what, unusual = f"the {name} angle counts {counts}", 0.1 * title.endswith("-backwards")
            found.append(Convention(title, 3, what, explains, zero=shift, unusual=unusual))
    return found


def _absolute(joints: Sequence[Joint]) -> list[Convention]:
    """Return the conventions of links whose angles, or whose drives, are against the base instead of the link before.

    From the base outwards: the angles of the links before are relative ones by then.
    """
    above = {k: [m for m in ancestors(joints, k)[:-1] if joints[m].turns] for k in range(len(joints))}
    further = [k for k, joint in enumerate(joints) if joint.turns and above[k]]
    found = []
    for k in further:
        name = joints[k].name
        what = f"the {name} angle is that of its link against the vertical, not against the link before"
        found.append(
            Convention(
                f"absolute-{name}", 4 + k, what, "the sum of the angles from the base to it",
                _rows(joints, {(k, m): -1.0 for m in above[k]}),
            )
        )  # fmt: skip
        what = f"the {name} torque acts between base and link, not between its link and the one before"
        found.append(
            Convention(
                f"base-driven-{name}", 4 + len(joints) + k, what,
                "a drive on the base moves it by a belt or rod",
                torque=_rows(joints, {(m, k): 1.0 for m in above[k]}), unusual=0.1,
            )
        )  # fmt: skip
    if len(further) > 1:
        # rel = A⁻¹ abs, where abs = A rel sums the angles from the base outwards
        sums = np.eye(len(joints))
        for k in further:
            sums[k, above[k]] = 1.0
        relative = tuple(tuple(float(x) for x in row) for row in np.round(np.linalg.inv(sums)))
        what = "every angle is that of its link against the vertical, not against the link before"
        found.append(Convention("absolute-angles", 4, what, "as motion capture gives them", relative))
    return found


ZEROS = (90.0, -90.0, 180.0)
"""Degrees at which the zero of an angle is looked for in space: there the usual ways of placing frames differ by right
angles."""


def _zero(joint: int, at: float, joints: Sequence[Joint]) -> Convention:
    """Return the convention of a joint whose zero lies `at` degrees of the model's angle, m where it slides."""
    shifted = joints[joint]
    shift = tuple((math.radians(at) if shifted.turns else at) if k == joint else 0.0 for k in range(len(joints)))
    channel, place = ("angle", f"{at:g}°") if shifted.turns else ("position", f"{at:g} m")
    what = f"the {shifted.name} {channel} is zero where the model's is {place}"
    return Convention(f"{shifted.name}-zero={at:.12g}", 3, what, "added after its sign was put right", zero=shift)


_GEAR = re.compile(r"([A-Za-z][A-Za-z0-9_]*)-motor(|-angle|-torque)=(\d{1,4}(?:\.\d{1,4})?)")
_ZERO = re.compile(r"([A-Za-z][A-Za-z0-9_]*)-zero=(-?\d{1,4}(?:\.\d{1,9})?)")
_SUMS = re.compile(r"torque-sums=(-?\d(?::-?\d)*)")
NUMBERED = "JOINT-motor=N, JOINT-motor-angle=N, JOINT-motor-torque=N, JOINT-zero=N, torque-sums=N:N:..."
"""Conventions with a number: angle and torque, or only one of them, on the motor's side of a gear of ratio N; the zero
of a joint at N degrees (m where it slides) of the model's; joints' torques that are sums of the recorded ones, so many
times each, row by row."""


def gear(joint: int, part: str, ratio: float, joints: Sequence[Joint] = LEG) -> Convention:
    """Return the convention of a joint whose angle and torque (`part` "", "angle" or "torque") are the motor's."""
    of = joints[joint].name
    turn = _rows(joints, {(joint, joint): 1.0 / ratio})
    force = _rows(joints, {(joint, joint): ratio})
    kind = {"": "angle and torque are", "angle": "angle is", "torque": "torque is"}[part]
    what = f"the {of} {kind} on the motor's side of a gear of about {ratio:.4g}"
    what += ", or has other steps a turn than --units says" if part == "angle" else ""
    name = f"{of}-motor{part and f'-{part}'}={ratio:.4g}"
    return Convention(name, 1, what, "", None if part == "torque" else turn, None if part == "angle" else force)


def torque_sums(times: Sequence[Sequence[int]], joints: Sequence[Joint] = LEG) -> Convention:
    """Return the convention of recordings of whose torques those of `joints` are sums, `times` (J, J) each."""
    said = " and ".join(f"{joint.name} {_sum_in_words(row)}" for joint, row in zip(joints, times, strict=True))
    name = "torque-sums=" + ":".join(str(int(factor)) for row in times for factor in row)
    what = f"the joints' torques are sums of the recorded ones ({said})"
    return Convention(name, 2, what, "", torque=tuple(tuple(map(float, row)) for row in times), sums=True)


def _sum_in_words(row: Sequence[int]) -> str:
    """Return "2 tau1 - tau2" for (2, -1)."""
    parts = [f"{'+-'[n < 0]} {f'{abs(n)} ' if abs(n) > 1 else ''}tau{k + 1}" for k, n in enumerate(row) if n]
    return " ".join(parts).removeprefix("+ ")


def conventions(called: str | Iterable[str], joints: tuple[Joint, ...] = LEG) -> tuple[Convention, ...]:
    """Return the conventions `called` so ("a,b" or ["a", "b"]) of a machine with `joints`, in the order of application.

    Raises RecordingError for a name that does not exist and for one given twice.
    """
    given = [n.strip() for text in ([called] if isinstance(called, str) else called) for n in text.split(",")]
    found = [_named(name, joints) for name in given if name]
    twice = [name for name in given if name and given.count(name) > 1]
    if twice:
        raise RecordingError(f"the convention {twice[0]} is given twice", remedy="name it once")
    return tuple(sorted(found, key=lambda one: one.order))


def _named(name: str, joints: tuple[Joint, ...]) -> Convention:
    geared = _GEAR.fullmatch(name)
    if geared and geared[1] in names(joints) and float(geared[3]) > 0.0:
        return gear(names(joints).index(geared[1]), geared[2].removeprefix("-"), float(geared[3]), joints)
    placed = _ZERO.fullmatch(name)
    if placed and placed[1] in names(joints):
        return _zero(names(joints).index(placed[1]), float(placed[2]), joints)
    summed = _SUMS.fullmatch(name)
    if summed and len(times := [int(x) for x in summed[1].split(":")]) == len(joints) ** 2:
        rows = np.array(times).reshape(len(joints), -1)
        if round(float(np.linalg.det(rows))):
            return torque_sums(rows.tolist(), joints)
    known = conventions_of_machine(joints)
    if name not in known:
        whose = "" if is_leg(joints) else f" of a machine with {', '.join(names(joints))}"
        what = f"there is no convention called {name!r}{whose}"
        raise RecordingError(what, remedy=did_you_mean(name, list(known)) or f"known: {', '.join(known)}, {NUMBERED}")
    return known[name]


@dataclass(frozen=True, eq=False)
class Map:
    """q = `angle` (J, J) q_file + `zero` (J,), tau = `torque` (J, J) tau_file."""

    angle: Float
    zero: Float
    torque: Float

    def applied(self, q: Float, tau: Float) -> tuple[Float, Float]:
        """Return angles and torques (N, J) that a file has, read so."""
        return q @ self.angle.T + self.zero, tau @ self.torque.T

    def undone(self, q: Float, tau: Float) -> tuple[Float, Float]:
        """Return angles and torques (N, J) as the file had them."""
        return (q - self.zero) @ np.linalg.inv(self.angle).T, tau @ np.linalg.inv(self.torque).T


def combined_map(chosen: Iterable[Convention], joints: Sequence[Joint] = LEG) -> Map:
    """Return the one map that applying `chosen` one after the other makes."""
    same = np.eye(len(joints))
    angle, zero, torque = same, np.zeros(len(joints)), same
    for item in chosen:
        step, force = (same if rows is None else np.array(rows) for rows in (item.angle, item.torque))
        angle, zero, torque = step @ angle, step @ zero + (item.zero or 0.0), force @ torque
    return Map(angle, zero, torque)


def read_as(recording: Recording, called: str | Iterable[str]) -> Recording:
    """Return `recording`, taken for one that keeps the conventions `called` so, in exoid's own.

    Whole turns that a new zero adds are taken off. Raises RecordingError for a name that does not exist.
    """
    chosen = conventions(called, recording.joints)
    if not chosen:
        return recording
    to = combined_map(chosen, recording.joints)
    q, tau = to.applied(recording.q, recording.tau)
    angle_valid, torque_valid = (
        _mapped(valid, matrix)
        for valid, matrix in ((recording.angle_valid, to.angle), (recording.torque_valid, to.torque))
    )
    valid = angle_valid.all(axis=1)
    if (np.any(to.zero) or np.any(to.angle - np.diag(np.diag(to.angle)))) and valid.any():
        turns = np.array([joint.turns for joint in recording.joints])
        q = q - 2 * np.pi * turns * np.round(np.median(q[valid], axis=0) / (2 * np.pi))
    return replace(
        recording,
        angle_valid=angle_valid,
        torque_valid=torque_valid,
        q=q,
        tau=tau,
        dq=None if recording.dq is None else recording.dq @ to.angle.T,
        ddq=None if recording.ddq is None else recording.ddq @ to.angle.T,
        conventions=(*recording.conventions, *(item.name for item in chosen)),
    )


def _mapped(valid: NDArray[np.bool_], matrix: Float) -> NDArray[np.bool_]:
    """Values (N, J) that are valid after `matrix` (J, J): those of which every part is."""
    return valid if valid.all() else np.asarray((~valid).astype(float) @ (matrix != 0.0).T == 0.0)
