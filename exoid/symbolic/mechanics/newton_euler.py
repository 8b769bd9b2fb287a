"""Newton and Euler for a planar tree of links: torques per unit of each link's mass, first moment and inertia.

Written for any library with `sin` and `cos`: NumPy for whole motions, CasADi for expressions. It shares nothing with
the derivation through SymPy, and is what confirms it. Source: Featherstone, Rigid Body Dynamics Algorithms, 2008,
chapter 5; per parameter as in Khalil, Dombre, Modeling, Identification and Control of Robots, 2002, chapter 12.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from exoid.symbolic.joints import Joint, ancestors, parents

PARAMETERS = ("J", "X", "m")
"""Of each link: inertia about its joint kg·m², mass times the distance of its centre of mass along the link kg·m, mass
kg. The centre of mass lies on the link's axis."""
ACROSS = "Y"
"""Mass times the distance of the centre of mass from the link's axis, to the front of a hanging link, kg·m."""

Vector = tuple[Any, Any]


@dataclass(frozen=True)
class BaseMotion:
    """Motion of the base: its `angle` rad (added to the first links'), its derivatives, and its acceleration forwards
    and upwards in m/s².
    """

    angle: Any = 0.0
    rate: Any = 0.0
    turning: Any = 0.0
    forward: Any = 0.0
    upward: Any = 0.0


STILL = BaseMotion()
AS_GIVEN: Mapping[int, Any] = MappingProxyType({})
"""No link of another length than its joint says."""


@dataclass(frozen=True)
class _Frame:
    """A link in motion: axis `e` and normal `n`, turning rate and acceleration, and its origin."""

    e: Vector
    n: Vector
    rate: Any
    turning: Any
    origin: Vector
    acceleration: Vector


def link_torques(
    joints: Sequence[Joint], gravity: float, q: Sequence[Any], dq: Sequence[Any], ddq: Sequence[Any], lib: Any,
    base: BaseMotion = STILL, across: Sequence[int] = (), lengths: Mapping[int, Any] = AS_GIVEN,
) -> list[dict[str, list[Any]]]:
    """Return, per link, {parameter: torque at every joint (J,)} for one unit of that parameter; N·m, or N where a joint
    slides.

    `q`, `dq`, `ddq` (J,) hold numbers, arrays or expressions of the library `lib`. `gravity` m/s² pulls downwards. The
    links `across` have a centre of mass off their axis as a further parameter, those among `lengths` another length, m.
    """  # fmt: skip
    frames = _frames(joints, gravity, q, dq, ddq, lib, base, lengths)
    found = []
    for index, frame in enumerate(frames):
        swing = _add(_scale(frame.turning, frame.n), _scale(-frame.rate * frame.rate, frame.e))
        wrenches = {
            "J": ((0.0, 0.0), frame.turning),
            "X": (swing, _cross(frame.e, frame.acceleration)),
            "m": (frame.acceleration, 0.0),
        }
        if index in across:
            aside = _add(_scale(-frame.turning, frame.e), _scale(-frame.rate * frame.rate, frame.n))
            wrenches[ACROSS] = (aside, _cross(frame.n, frame.acceleration))
        found.append({name: _at_joints(joints, frames, index, *wrench) for name, wrench in wrenches.items()})
    return found


def point(
    joints: Sequence[Joint], q: Sequence[Any], index: int, along: Any, lib: Any, base: BaseMotion = STILL
) -> Vector:
    """Position of a point of link `index`, `along` it in m: to the front and upwards from the base, m."""
    still = [0.0 * angle for angle in q]
    frame = _frames(joints, 0.0, q, still, still, lib, base)[index]
    return _add(frame.origin, _scale(along, frame.e))


def push_torques(
    joints: Sequence[Joint], q: Sequence[Any], index: int, along: Any, force: Vector, lib: Any,
    base: BaseMotion = STILL, normal: bool = False,
) -> list[Any]:  # fmt: skip
    """Torques (J,) that the joints supply while a `force` N acts on link `index`, `along` it in m: against it.

    Its parts are forwards and upwards, or along the link and normal to it where it is `normal`.
    """
    still = [0.0 * angle for angle in q]
    frames = _frames(joints, 0.0, q, still, still, lib, base)
    own = frames[index]
    pushed = _add(_scale(force[0], own.e), _scale(force[1], own.n)) if normal else force
    against = _scale(-1.0, pushed)
    return _at_joints(joints, frames, index, against, along * _cross(own.e, against))


def _frames(
    joints: Sequence[Joint], gravity: float, q: Sequence[Any], dq: Sequence[Any], ddq: Sequence[Any], lib: Any,
    base: BaseMotion, lengths: Mapping[int, Any] = AS_GIVEN,
) -> list[_Frame]:  # fmt: skip
    frames: list[_Frame] = []
    angles: list[Any] = []
    for k, (joint, parent) in enumerate(zip(joints, parents(joints), strict=True)):
        if parent is None:
            zero = 0.0 * q[k]
            angle, rate, turning = base.angle + zero, base.rate + zero, base.turning + zero
            origin, acceleration = (zero, zero), (base.forward + zero, gravity + base.upward + zero)
        else:
            above, length = frames[parent], lengths.get(parent, float(joints[parent].length or 0.0))
            angle, rate, turning = angles[parent], above.rate, above.turning
            origin = _add(above.origin, _scale(length, above.e))
            swing = _add(_scale(turning, above.n), _scale(-rate * rate, above.e))
            acceleration = _add(above.acceleration, _scale(length, swing))
        if joint.turns:
            angle, rate, turning = angle + q[k], rate + dq[k], turning + ddq[k]
        e, n = (lib.sin(angle), -lib.cos(angle)), (lib.cos(angle), lib.sin(angle))
        if not joint.turns:
            swing = _add(_scale(turning, n), _scale(-rate * rate, e))
            slide = _add(_scale(ddq[k], e), _scale(2.0 * dq[k] * rate, n))
            origin = _add(origin, _scale(q[k], e))
            acceleration = _add(acceleration, _add(slide, _scale(q[k], swing)))
        angles.append(angle)
        frames.append(_Frame(e, n, rate, turning, origin, acceleration))
    return frames


def _at_joints(joints: Sequence[Joint], frames: Sequence[_Frame], index: int, force: Vector, moment: Any) -> list[Any]:
    """Torques of the joints for a force and a moment about the origin of link `index`."""
    torques: list[Any] = [0.0] * len(joints)
    for k in ancestors(joints, index):
        if joints[k].turns:
            arm = _add(frames[index].origin, _scale(-1.0, frames[k].origin))
            torques[k] = moment + _cross(arm, force)
        else:
            torques[k] = frames[k].e[0] * force[0] + frames[k].e[1] * force[1]
    return torques


def _add(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1]


def _scale(factor: Any, vector: Vector) -> Vector:
    return factor * vector[0], factor * vector[1]


def _cross(a: Vector, b: Vector) -> Any:
    return a[0] * b[1] - a[1] * b[0]
