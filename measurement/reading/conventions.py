"""The usual ways of counting angles and torques, by name, and how each becomes exoid's own.

exoid's hip angle counts from the downward vertical, its knee angle is relative to the thigh with flexion negative,
and each torque is what the drive of that joint exerts. A convention is an affine map of both angles and a linear map of
both torques; a change of sign or of the side of a gear maps both so that power stays the same.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ground.errors import RecordingError
from ground.suggest import did_you_mean
from measurement.recording import Recording
from symbolic.joints import is_leg
from symbolic.motion import Float
from symbolic.quantity import JOINTS

Rows = tuple[tuple[float, float], tuple[float, float]]
SAME: Rows = ((1.0, 0.0), (0.0, 1.0))
OTHER: Rows = ((0.0, 1.0), (1.0, 0.0))
HIP: Rows = ((-1.0, 0.0), (0.0, 1.0))
KNEE: Rows = ((1.0, 0.0), (0.0, -1.0))
BOTH: Rows = ((-1.0, 0.0), (0.0, -1.0))
DEGREE = math.pi / 180.0
QUARTER = 0.5 * math.pi


@dataclass(frozen=True)
class Convention:
    """q = `angle` q_file + `zero` and tau = `torque` tau_file (rad, N·m); `order`: lower ones are applied first.

    `what` completes "it looks as if ...", `explains` says to a user what recordings of this convention hold.
    """

    name: str
    order: int
    what: str
    explains: str
    angle: Rows = SAME
    zero: tuple[float, float] = (0.0, 0.0)
    torque: Rows = SAME


CONVENTIONS: Mapping[str, Convention] = {
    one.name: one
    for one in (
        Convention("swapped-angles", 0, "hip and knee angle are swapped", "q1 is the knee's, q2 the hip's", OTHER),
        Convention(
            "swapped-torques", 0, "hip and knee torque are swapped", "tau1 is the knee's, tau2 the hip's", torque=OTHER
        ),
        Convention("swapped-joints", 0, "hip and knee are swapped", "both of these", OTHER, torque=OTHER),
        Convention(
            "degrees", 1, "the angles are in degrees", "the same as --units q=deg", ((DEGREE, 0.0), (0.0, DEGREE))
        ),
        Convention(
            "flexion-positive",
            2,
            "knee flexion is counted positive (angle and torque)",
            "knee angle and knee torque have the other sign, usual in biomechanics",
            KNEE,
            torque=KNEE,
        ),
        Convention(
            "hip-extension-positive",
            2,
            "hip extension is counted positive (angle and torque)",
            "hip angle and hip torque have the other sign",
            HIP,
            torque=HIP,
        ),
        Convention("hip-angle-negated", 2, "the hip angle has the wrong sign", "only the hip angle has", HIP),
        Convention("knee-angle-negated", 2, "the knee angle has the wrong sign", "only the knee angle has", KNEE),
        Convention("hip-torque-negated", 2, "the hip torque has the wrong sign", "only the hip torque has", torque=HIP),
        Convention(
            "knee-torque-negated", 2, "the knee torque has the wrong sign", "only the knee torque has", torque=KNEE
        ),
        Convention(
            "load-torque",
            2,
            "both torques (or both angles) have the wrong sign",
            "torques are what the load exerts on the drives",
            torque=BOTH,
        ),
        Convention(
            "hip-from-upright",
            3,
            "the hip angle counts from upright",
            "q1 = 0 where the thigh points upwards",
            zero=(math.pi, 0.0),
        ),
        Convention(
            "hip-from-horizontal",
            3,
            "the hip angle counts from the horizontal",
            "q1 = 0 where the thigh points forwards, -90° where it hangs",
            zero=(QUARTER, 0.0),
        ),
        Convention(
            "hip-from-horizontal-backwards",
            3,
            "the hip angle counts from the horizontal behind",
            "q1 = 0 where the thigh points backwards, +90° where it hangs",
            zero=(-QUARTER, 0.0),
        ),
        Convention(
            "included-knee-angle",
            3,
            "the knee angle is the one between thigh and shank",
            "q2 = 180° where the leg is straight, less where it is flexed",
            zero=(0.0, -math.pi),
        ),
        Convention(
            "shank-from-horizontal",
            3,
            "the shank angle counts from the horizontal",
            "with absolute-shank: q2 = 0 where the shank points forwards",
            zero=(0.0, QUARTER),
        ),
        Convention(
            "shank-from-horizontal-backwards",
            3,
            "the shank angle counts from the horizontal behind",
            "with absolute-shank: q2 = 0 where the shank points backwards",
            zero=(0.0, -QUARTER),
        ),
        Convention(
            "absolute-shank",
            4,
            "the second angle is that of the shank against the vertical, not against the thigh",
            "q2 = q1 + knee angle; the torques are those of the drives at hip and knee",
            ((1.0, 0.0), (-1.0, 1.0)),
        ),
        Convention(
            "base-driven-shank",
            5,
            "the second torque acts between base and shank, not between thigh and shank",
            "a drive on the base pulls the shank by a belt or rod; with absolute-shank: generalised torques of the "
            "absolute angles",
            torque=((1.0, 1.0), (0.0, 1.0)),
        ),
    )
}
"""Every convention that has a name, in the order in which it is applied."""

_GEAR = re.compile(rf"({'|'.join(JOINTS)})-motor(|-angle|-torque)=(\d{{1,4}}(?:\.\d{{1,4}})?)")
GEARS = "JOINT-motor=N, JOINT-motor-angle=N, JOINT-motor-torque=N"
"""Conventions with a number: angle and torque, or only one of them, on the motor's side of a gear of ratio N."""


def gear(joint: int, part: str, ratio: float) -> Convention:
    """Return the convention of a joint whose angle and torque (`part` "", "angle" or "torque") are the motor's."""
    size = [1.0, 1.0]
    size[joint] = ratio
    turn: Rows = ((1.0 / size[0], 0.0), (0.0, 1.0 / size[1]))
    force: Rows = ((size[0], 0.0), (0.0, size[1]))
    kind = {"": "angle and torque are", "angle": "angle is", "torque": "torque is"}[part]
    what = f"the {JOINTS[joint]} {kind} on the motor's side of a gear of about {ratio:.4g}"
    name = f"{JOINTS[joint]}-motor{part and f'-{part}'}={ratio:.4g}"
    return Convention(name, 1, what, "", SAME if part == "torque" else turn, torque=SAME if part == "angle" else force)


def conventions(names: str | Iterable[str]) -> tuple[Convention, ...]:
    """Return the conventions called `names` ("a,b" or ["a", "b"]), in the order of application.

    Raises RecordingError for a name that does not exist and for one given twice.
    """
    given = [n.strip() for text in ([names] if isinstance(names, str) else names) for n in text.split(",")]
    found = [_named(name) for name in given if name]
    twice = [name for name in given if name and given.count(name) > 1]
    if twice:
        raise RecordingError(f"the convention {twice[0]} is given twice", remedy="name it once")
    return tuple(sorted(found, key=lambda one: one.order))


def _named(name: str) -> Convention:
    geared = _GEAR.fullmatch(name)
    if geared and float(geared[3]) > 0.0:
        return gear(JOINTS.index(geared[1]), geared[2].removeprefix("-"), float(geared[3]))
    if name not in CONVENTIONS:
        raise RecordingError(
            f"there is no convention called {name!r}",
            remedy=did_you_mean(name, list(CONVENTIONS)) or f"known: {', '.join(CONVENTIONS)}, {GEARS}",
        )
    return CONVENTIONS[name]


@dataclass(frozen=True, eq=False)
class Map:
    """q = `angle` (J, J) q_file + `zero` (J,), tau = `torque` (J, J) tau_file."""

    angle: Float
    zero: Float
    torque: Float


def combined_map(chosen: Iterable[Convention]) -> Map:
    """Return the one map that applying `chosen` one after the other makes."""
    angle, zero, torque = np.eye(2), np.zeros(2), np.eye(2)
    for one in chosen:
        step = np.array(one.angle)
        angle, zero, torque = step @ angle, step @ zero + one.zero, np.array(one.torque) @ torque
    return Map(angle, zero, torque)


def read_as(recording: Recording, names: str | Iterable[str]) -> Recording:
    """Return `recording`, taken for one that keeps the conventions `names`, in exoid's own.

    Whole turns that a new zero adds are taken off. Raises RecordingError for a name that does not exist.
    """
    chosen = conventions(names)
    if not chosen:
        return recording
    if not is_leg(recording.joints):
        raise RecordingError(
            f"the convention {chosen[0].name} is one of legs; this machine has {', '.join(recording.joint_names)}",
            where=recording.source.path or recording.name,
            remedy="change signs with --units, as in q1=-rad or tau1=-Nm",
        )
    to = combined_map(chosen)
    q = recording.q @ to.angle.T + to.zero
    if np.any(to.zero) or np.any(to.angle - np.diag(np.diag(to.angle))):
        q = (
            q - 2 * np.pi * np.round(np.median(q[recording.valid], axis=0) / (2 * np.pi))
            if recording.valid.any()
            else q
        )
    return replace(
        recording,
        q=q,
        tau=recording.tau @ to.torque.T,
        dq=None if recording.dq is None else recording.dq @ to.angle.T,
        ddq=None if recording.ddq is None else recording.ddq @ to.angle.T,
        conventions=(*recording.conventions, *(one.name for one in chosen)),
    )
