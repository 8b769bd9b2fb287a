"""Lagrange for a planar tree of links, one column per base parameter: small, exact, and quick for many joints.

Kinetic and potential energy are linear in each link's inertia, first moment and mass, so each parameter has an energy
of its own and Lagrange's equation is applied to it alone:

    J:  T = ½ ω²           X:  T = v · ω n,  V = g z(e)           m:  T = ½ v · v,  V = g z(o)
                           Y:  T = -v · ω e,  V = g z(n)

with Y a mass beside the axis, v the velocity of the link's origin o = Σ c_j e_j, written through e_i · e_j =
cos(φ_i - φ_j) and the like, so that angles appear as differences only. Source: Spong, Hutchinson, Vidyasagar, Robot
Modeling and Control.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from exoid.ground.errors import EffectError
from exoid.symbolic.joints import Joint, ancestors
from exoid.symbolic.mechanics.base_parameters import BaseParameter, base_parameters
from exoid.symbolic.mechanics.mechanism import Mechanism, machine, real
from exoid.symbolic.mechanics.newton_euler import ACROSS

if TYPE_CHECKING:
    from sympy import Expr, Matrix


@dataclass(frozen=True, eq=False)
class TreeForm:
    """`matrix` (J, P) times the base `parameters` (P,) is the rigid-body torque of the tree.

    Further columns of the matrix belong to masses beside the axes of links.
    """

    parameters: tuple[BaseParameter, ...]
    matrix: Matrix


@lru_cache(maxsize=32)
def tree_form(
    joints: tuple[Joint, ...],
    gravity: float,
    across: tuple[int, ...] = (),
    moving: bool = False,
    turning: bool = False,
    lengths: tuple[int, ...] = (),
) -> TreeForm:
    """Derive the regressor of a tree whose lengths (m) and gravity (m/s²) are numbers.

    `across` are links with one more column, for a mass beside their axis. Where the base is `moving`, what pulls
    forwards and upwards is `g_x` and `g_z` (m/s², gravity included); where it is `turning`, its angle is `base`. The
    lengths of the links `lengths` are symbols, `length1` that of the first one.
    """
    from sympy import Matrix

    parameters = base_parameters(joints, gravity, turning)
    tree = _Tree(joints, gravity, moving, turning, lengths)
    columns = [Matrix(tree.column(parameter.link, parameter.kind)) for parameter in parameters]
    columns += [Matrix(tree.column(link, ACROSS)) for link in across]
    return TreeForm(parameters, Matrix.hstack(*columns) if columns else Matrix(len(joints), 0, []))


@dataclass(frozen=True)
class TreeChanges:
    """Changes of a machine by effects: the `offset` of its joints (J,), {link: mass times distance from its axis}
    and {link: another length}, and the `pull` forwards and downwards, gravity included.
    """

    offset: tuple[Expr, ...]
    moments: Mapping[int, Expr]
    lengths: Mapping[int, Expr]
    pull: tuple[Expr, Expr]


def tree_changes(mechanism: Mechanism) -> TreeChanges:
    """Changes of a machine by effects; EffectError for a change that base parameters do not know."""
    from sympy import cos, sin

    plain = machine(mechanism.joints)
    for link, before in zip(mechanism.links, plain.links, strict=True):
        if replace(link, across=before.across, length=before.length) != before:
            what = f"the inertia of link {link.name} cannot be changed where there are base parameters alone"
            remedy = "change length, across, joint_offset, tilt or base_acceleration, or return torques"
            raise EffectError(what, where="derive()", remedy=remedy)
    moments = {k: link.across * link.mass for k, link in enumerate(mechanism.links) if link.across != 0}
    pairs = enumerate(zip(mechanism.links, plain.links, strict=True))
    lengths = {k: link.length for k, (link, before) in pairs if link.length != before.length}
    forward, upward = mechanism.base_acceleration
    pull = mechanism.gravity * sin(mechanism.tilt) + forward, mechanism.gravity * cos(mechanism.tilt) + upward
    return TreeChanges(mechanism.joint_offset, moments, lengths, pull)


def offset_changes(mechanism: Mechanism) -> list[Expr]:
    """Return the offsets of the joints (J,) of a spatial machine that effects changed; EffectError for any other
    change.
    """
    plain = machine(mechanism.joints)
    if replace(mechanism, joint_offset=plain.joint_offset) != plain:
        what = "links, tilt and base acceleration are those of a machine in a plane, and this one is spatial"
        raise EffectError(what, where="derive()", remedy="change joint_offset, or return torques")
    return list(mechanism.joint_offset)


class _Tree:
    """Angles, rates and origins of the links, and energies per unit parameter."""

    def __init__(
        self, joints: Sequence[Joint], gravity: float, moving: bool, turning: bool, lengths: Sequence[int]
    ) -> None:
        from sympy import Float, Integer

        self.joints = joints
        self.length = [
            real(f"length{k + 1}") if k in lengths else Float(joint.length or 0.0) for k, joint in enumerate(joints)
        ]
        self.pull: tuple[Expr, Expr] = (Integer(0), Float(gravity) if gravity else Integer(0))
        if moving:
            self.pull = real("g_x"), real("g_z")
        self.base = (real("base"), real("dbase"), real("ddbase")) if turning else None
        count = range(1, len(joints) + 1)
        self.q = [real(f"theta{k}") for k in count]
        self.dq = [real(f"dtheta{k}") for k in count]
        self.ddq = [real(f"ddtheta{k}") for k in count]
        self.angle: list[Expr] = []
        self.rate: list[Expr] = []
        for k in range(len(joints)):
            path = [j for j in ancestors(joints, k) if joints[j].turns]
            leaning, swinging = self.base[:2] if self.base else (Integer(0), Integer(0))
            self.angle.append(sum((self.q[j] for j in path), leaning))
            self.rate.append(sum((self.dq[j] for j in path), swinging))

    def column(self, link: int, kind: str) -> list[Expr]:
        """Return the torque at every joint (J,) for one unit of a parameter."""
        from sympy import Integer, diff

        kinetic, potential = self._energies(link, kind)
        path = set(ancestors(self.joints, link))
        state = [(self.q[k], self.dq[k], self.ddq[k]) for k in sorted(path)] + ([self.base] if self.base else [])
        torques = []
        for k in range(len(self.joints)):
            if k not in path:
                torques.append(Integer(0))
                continue
            momentum = diff(kinetic, self.dq[k])
            rate = sum((diff(momentum, q) * dq + diff(momentum, dq) * ddq for q, dq, ddq in state), Integer(0))
            torques.append(rate - diff(kinetic, self.q[k]) + diff(potential, self.q[k]))
        return torques

    def _energies(self, link: int, kind: str) -> tuple[Expr, Expr]:
        from sympy import Integer, Rational, cos, pi, sin

        angle, rate = self.angle, self.rate
        if kind == "J":
            return Rational(1, 2) * rate[link] ** 2, Integer(0)
        moving = self._origin(link)
        if kind in ("X", ACROSS):  # what lies beside the axis lies along one that is turned by a right angle
            axis = angle[link] + (pi / 2 if kind == ACROSS else 0)
            parts = (
                rate[link] * (along * sin(angle[j] - axis) + across * cos(angle[j] - axis))
                for j, _, along, across in moving
            )
            return sum(parts, Integer(0)), self._lifted(axis)
        kinetic = Integer(0)
        for j, _, along_j, across_j in moving:
            for k, _, along_k, across_k in moving:
                apart = angle[j] - angle[k]
                kinetic += Rational(1, 2) * (along_j * along_k + across_j * across_k) * cos(apart)
                kinetic += Rational(1, 2) * (along_j * across_k - across_j * along_k) * sin(apart)
        return kinetic, sum((reach * self._lifted(angle[j]) for j, reach, _, _ in moving), Integer(0))

    def _lifted(self, angle: Expr) -> Expr:
        """Return the potential of one kg at one metre along a link."""
        from sympy import cos, sin

        return self.pull[0] * sin(angle) - self.pull[1] * cos(angle)

    def _origin(self, link: int) -> list[tuple[int, Any, Any, Any]]:
        """Return (link j, c_j, speed along e_j, speed along n_j) of the pieces of the way to a link's origin."""
        from sympy import Integer

        pieces = []
        path = ancestors(self.joints, link)
        for k in path:
            joint = self.joints[k]
            if not joint.turns:
                pieces.append((k, self.q[k], self.dq[k], self.q[k] * self.rate[k]))
            if k != link:
                pieces.append((k, self.length[k], Integer(0), self.length[k] * self.rate[k]))
        return pieces
