"""Newton and Euler for a tree of links in space: torques per unit of each link's ten inertial parameters.

Every link's quantities are in the frame of its joint: that of the URDF's child link. Written for any library with `sin`
and `cos`, as the planar recursion is (`newton_euler.py`). Source: Luh, Walker, Paul, On-line computational scheme for
mechanical manipulators, ASME Journal of Dynamic Systems, Measurement, and Control 102(2), 1980; per parameter as in
Khalil, Dombre, Modeling, Identification and Control of Robots, 2002, chapter 12.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from exoid.symbolic.joints import HERE, Joint, Origin, Vector, parents

INERTIAS = ("XX", "XY", "XZ", "YY", "YZ", "ZZ")
MOMENTS = ("MX", "MY", "MZ")
KINDS = (*INERTIAS, *MOMENTS, "M")
"""Of each link, about the origin of its joint's frame: the inertia tensor kg·m² (off its diagonal the entries of the
tensor, as in a URDF), mass times the centre of mass kg·m, and mass kg."""
AT = {"XX": (0, 0), "XY": (0, 1), "XZ": (0, 2), "YY": (1, 1), "YZ": (1, 2), "ZZ": (2, 2)}
EXACT = 1e-15
"""Entry of a rotation below which it is zero: the cosine of a right angle is 6e-17."""

Triple = tuple[Any, Any, Any]
Rows = tuple[Triple, Triple, Triple]
AXES: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class _Body:
    """A link in motion, in its own frame: how that is turned and lies in the frame of its carrier, its rate and angular
    acceleration, and the acceleration of its origin, against gravity.
    """

    turned: Rows
    place: Triple
    rate: Triple
    turning: Triple
    acceleration: Triple


def about_joint(mass: Any, centre: Any, inertia: Any) -> dict[str, Any]:
    """Return the ten parameters of a link, in the order of `KINDS`, from its mass, its centre of mass (3,) and its
    inertia (3, 3) about that, all in the frame of its joint; numbers, or arrays of them.
    """
    square = sum(x * x for x in centre)
    found = {
        kind: inertia[i][j] + mass * ((square if i == j else 0.0) - centre[i] * centre[j])
        for kind, (i, j) in AT.items()
    }
    return found | {kind: mass * x for kind, x in zip(MOMENTS, centre, strict=True)} | {"M": mass}


def link_columns(
    joints: Sequence[Joint], pull: Vector, q: Sequence[Any], dq: Sequence[Any], ddq: Sequence[Any], lib: Any,
    wanted: Sequence[tuple[int, str]], base: Sequence[Any] = (),
) -> list[list[Any]]:  # fmt: skip
    """Return the torque at every joint (J,) for one unit of each `wanted` (link, kind); N·m, or N where a joint slides.

    `q`, `dq`, `ddq` (J,) hold numbers, arrays or expressions of the library `lib`; `pull` (3,) m/s² is gravity in the
    frame of the base, or of the world where the `base` (12,) moves: its angles about the fixed axes x, y, z in this
    order (rad), their rates, the rates of these, and the acceleration of its origin without gravity (m/s²).
    """
    bodies, above = _bodies(joints, pull, q, dq, ddq, lib, base), parents(joints)
    found = []
    for link, kind in wanted:
        force, moment = _wrench(bodies[link], {kind: 1.0})
        torques: list[Any] = [0.0] * len(joints)
        k: int | None = link
        while k is not None:
            torques[k] = _dot(_axis(joints[k]), moment if joints[k].turns else force)
            force, moment = _carried(bodies[k], force, moment)
            k = above[k]
        found.append(torques)
    return found


def joint_torques(
    joints: Sequence[Joint], pull: Vector, q: Sequence[Any], dq: Sequence[Any], ddq: Sequence[Any], lib: Any,
    inertial: Sequence[Mapping[str, Any]], base: Sequence[Any] = (),
) -> list[Any]:  # fmt: skip
    """Return the torque at every joint (J,) of links with the `inertial` parameters (J,), {kind: number}, those left
    out being zero; other arguments as of `link_columns`.
    """
    bodies, above = _bodies(joints, pull, q, dq, ddq, lib, base), parents(joints)
    wrenches = [_wrench(body, own) for body, own in zip(bodies, inertial, strict=True)]
    torques: list[Any] = [0.0] * len(joints)
    for k in reversed(range(len(joints))):
        force, moment = wrenches[k]
        torques[k] = _dot(_axis(joints[k]), moment if joints[k].turns else force)
        if (carrier := above[k]) is not None:
            carried = _carried(bodies[k], force, moment)
            wrenches[carrier] = tuple(_add(a, b) for a, b in zip(wrenches[carrier], carried, strict=True))  # type: ignore[assignment]
    return torques


def wrench_torques(
    joints: Sequence[Joint], q: Sequence[Any], link: int, place: Vector, turned: Origin | None, wrench: Sequence[Any],
    lib: Any,
) -> list[Any]:  # fmt: skip
    """Return the torques (J,) that a force (3,), or a force and a moment (6,), on a `link` at `place` (3,) m in its
    frame asks of the drives, joint by joint down to the base.

    Its parts are along the axes of a sensor that is `turned` in the link's frame, None: along those of the base.
    """
    force: Triple = (wrench[0], wrench[1], wrench[2])
    moment: Triple = (wrench[3], wrench[4], wrench[5]) if len(wrench) == 6 else (0.0, 0.0, 0.0)
    if turned is None:
        rows = joint_frames(joints, q, lib)[link][0]
        force, moment = _back(rows, force), _back(rows, moment)
    else:
        force, moment = _times(rotation(turned), force), _times(rotation(turned), moment)
    moment = _add(moment, _cross(place, force))
    above, torques = parents(joints), [0.0 * q[0]] * len(joints)
    k: int | None = link
    while k is not None:
        torques[k] = -_dot(_axis(joints[k]), moment if joints[k].turns else force)
        rows, origin = _step(joints[k], q[k], lib)
        force, moment = _times(rows, force), _times(rows, moment)
        moment = _add(moment, _cross(origin, force))
        k = above[k]
    return torques


def joint_frames(joints: Sequence[Joint], q: Sequence[Any], lib: Any) -> list[tuple[Rows, Triple]]:
    """Rotation of every joint's frame, and its origin in m, in the frame of the base (J,)."""
    found: list[tuple[Rows, Triple]] = []
    for k, above in enumerate(parents(joints)):
        turned, place = _step(joints[k], q[k], lib)
        if above is not None:
            rows, origin = found[above]
            place = _add(origin, _times(rows, place))
            turned = _product(rows, turned)
        found.append((turned, place))
    return found


def end_point(joints: Sequence[Joint], q: Sequence[Any], reach: Any, lib: Any) -> Triple:
    """Position, in m in the frame of the base, of the point that lies `reach` m from the origin of the last joint
    along its axis.
    """
    turned, place = joint_frames(joints, q, lib)[-1]
    return _add(place, _scale(reach, _times(turned, _axis(joints[-1]))))


@lru_cache(maxsize=256)
def rotation(origin: Origin) -> Rows:
    """Rotation of a frame at `origin` in that of its carrier: its axes are the columns."""
    rows = turned_by(*origin.rpy, math)
    exact = [[round(entry) + 0.0 if abs(entry - round(entry)) < EXACT else entry for entry in row] for row in rows]
    return tuple((a, b, c) for a, b, c in exact)  # type: ignore[return-value]


def _axis(joint: Joint) -> Vector:
    return joint.axis or AXES[2]


def _step(joint: Joint, q: Any, lib: Any) -> tuple[Rows, Triple]:
    """Rotation of a link's frame in that of its carrier, and its origin there."""
    origin, axis = joint.origin or HERE, _axis(joint)
    fixed = rotation(origin)
    if not joint.turns:
        return fixed, _add(origin.xyz, _scale(q, _times(fixed, axis)))
    s, c = lib.sin(q), lib.cos(q)
    x, y, z = axis
    cross: Rows = ((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0))
    own = tuple(  # Rodrigues: a aᵀ + cos q (1 - a aᵀ) + sin q [a]×
        tuple(
            axis[i] * axis[j] + c * (float(i == j) - axis[i] * axis[j]) + s * cross[i][j]
            for j in range(3)
        )
        for i in range(3)
    )
    return _product(fixed, own), origin.xyz  # type: ignore[arg-type]


def _bodies(
    joints: Sequence[Joint], pull: Vector, q: Sequence[Any], dq: Sequence[Any], ddq: Sequence[Any], lib: Any,
    base: Sequence[Any],
) -> list[_Body]:  # fmt: skip
    bodies: list[_Body] = []
    still: Triple = (0.0, 0.0, 0.0)
    against: Triple = (-pull[0], -pull[1], -pull[2])
    carried = _moved(base, against, lib) if base else (still, still, against)
    for k, (joint, parent) in enumerate(zip(joints, parents(joints), strict=True)):
        turned, place = _step(joint, q[k], lib)
        rate, turning, acceleration = carried
        if parent is not None:
            above = bodies[parent]
            rate, turning, acceleration = above.rate, above.turning, above.acceleration
        if parent is not None or base:
            swing = _add(_cross(turning, place), _cross(rate, _cross(rate, place)))
            acceleration = _add(acceleration, swing)
        rate, turning, acceleration = (_back(turned, item) for item in (rate, turning, acceleration))
        axis = _axis(joint)
        moved = _scale(dq[k], axis)
        if joint.turns:
            turning = _add(_add(turning, _scale(ddq[k], axis)), _cross(rate, moved))
            rate = _add(rate, moved)
        else:
            acceleration = _add(acceleration, _add(_scale(ddq[k], axis), _scale(2.0, _cross(rate, moved))))
        bodies.append(_Body(turned, place, rate, turning, acceleration))
    return bodies


def turned_by(roll: Any, pitch: Any, yaw: Any, lib: Any) -> Rows:
    """Return the rotation by these angles (rad) about the fixed axes x, y, z in this order."""
    (sr, sp, sy), (cr, cp, cy) = ([f(a) for a in (roll, pitch, yaw)] for f in (lib.sin, lib.cos))
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def _moved(base: Sequence[Any], against: Triple, lib: Any) -> tuple[Triple, Triple, Triple]:
    """Return rate, angular acceleration and acceleration against gravity of a moving base, in its own frame."""
    (r, p, _), (dr, dp, dy), (ar, ap, ay) = base[:3], base[3:6], base[6:9]
    sr, cr, sp, cp = lib.sin(r), lib.cos(r), lib.sin(p), lib.cos(p)
    rate = (dr - dy * sp, dp * cr + dy * cp * sr, dy * cp * cr - dp * sr)
    turning = (
        ar - ay * sp - dy * dp * cp,
        ap * cr - dp * dr * sr + ay * cp * sr + dy * (dr * cp * cr - dp * sp * sr),
        ay * cp * cr - ap * sr - dp * dr * cr - dy * (dp * sp * cr + dr * cp * sr),
    )
    rows = turned_by(base[0], base[1], base[2], lib)
    return rate, turning, _back(rows, _add((base[9], base[10], base[11]), against))


def _wrench(body: _Body, own: Mapping[str, Any]) -> tuple[Triple, Triple]:
    """Return force and moment about its origin that a link with `own` parameters takes."""
    force: Triple = (0.0, 0.0, 0.0)
    moment: Triple = (0.0, 0.0, 0.0)
    if "M" in own:
        force = _scale(own["M"], body.acceleration)
    first = _entries(own, MOMENTS)
    if first is not None:
        swing = _add(_cross(body.turning, first), _cross(body.rate, _cross(body.rate, first)))
        force, moment = _add(force, swing), _cross(first, body.acceleration)
    if any(kind in own for kind in INERTIAS):
        rows: list[list[Any]] = [[0.0] * 3 for _ in range(3)]
        for kind, (i, j) in AT.items():
            if kind in own:
                rows[i][j] = rows[j][i] = own[kind]
        tensor: Rows = tuple(tuple(row) for row in rows)  # type: ignore[assignment]
        moment = _add(moment, _add(_times(tensor, body.turning), _cross(body.rate, _times(tensor, body.rate))))
    return force, moment


def _entries(own: Mapping[str, Any], kinds: Sequence[str]) -> Triple | None:
    if not any(kind in own for kind in kinds):
        return None
    x, y, z = (own.get(kind, 0.0) for kind in kinds)
    return x, y, z


def _carried(body: _Body, force: Triple, moment: Triple) -> tuple[Triple, Triple]:
    """Return a force and a moment of a link about the origin of its carrier, in the carrier's frame."""
    force, moment = _times(body.turned, force), _times(body.turned, moment)
    return force, _add(moment, _cross(body.place, force))


def _add(a: Triple, b: Triple) -> Triple:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _scale(factor: Any, a: Triple) -> Triple:
    return factor * a[0], factor * a[1], factor * a[2]


def _dot(a: Triple, b: Triple) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Triple, b: Triple) -> Triple:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _times(rows: Rows, a: Triple) -> Triple:
    return _dot(rows[0], a), _dot(rows[1], a), _dot(rows[2], a)


def _back(rows: Rows, a: Triple) -> Triple:
    """Return a vector of the carrier in the frame that is turned so: the transpose times it."""
    x, y, z = (rows[0][k] * a[0] + rows[1][k] * a[1] + rows[2][k] * a[2] for k in range(3))
    return x, y, z


def _product(a: Rows, b: Rows) -> Rows:
    x, y, z = (_times(a, (b[0][k], b[1][k], b[2][k])) for k in range(3))
    return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])
