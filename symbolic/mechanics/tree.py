"""Lagrange for a planar tree of links, one column per base parameter: small, exact, and quick for many joints.

Kinetic and potential energy are linear in each link's inertia, first moment and mass, so each parameter has an energy
of its own and Lagrange's equation is applied to it alone:

    J:  T = ½ ω²           X:  T = v · ω n,  V = g z(e)           m:  T = ½ v · v,  V = g z(o)

with v the velocity of the link's origin o = Σ c_j e_j, written through e_i · e_j = cos(φ_i - φ_j) and the like, so that
angles appear as differences only. Source: Spong, Hutchinson, Vidyasagar, Robot Modeling and Control.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from symbolic.joints import Joint, ancestors
from symbolic.mechanics.base_parameters import BaseParameter, base_parameters
from symbolic.mechanics.mechanism import real

if TYPE_CHECKING:
    from sympy import Expr, Matrix


@dataclass(frozen=True, eq=False)
class TreeForm:
    """`matrix` (J, P) times the base `parameters` (P,) is the rigid-body torque of the tree."""

    parameters: tuple[BaseParameter, ...]
    matrix: Matrix


@lru_cache(maxsize=32)
def tree_form(joints: tuple[Joint, ...], gravity: float) -> TreeForm:
    """Derive the regressor of a tree whose lengths (m) and gravity (m/s²) are numbers."""
    from sympy import Matrix

    parameters = base_parameters(joints, gravity)
    tree = _Tree(joints, gravity)
    columns = [Matrix(tree.column(parameter.link, parameter.kind)) for parameter in parameters]
    return TreeForm(parameters, Matrix.hstack(*columns) if columns else Matrix(len(joints), 0, []))


class _Tree:
    """Angles, rates and origins of the links, and energies per unit parameter."""

    def __init__(self, joints: Sequence[Joint], gravity: float) -> None:
        from sympy import Float, Integer

        self.joints = joints
        self.gravity = Float(gravity) if gravity else Integer(0)
        count = range(1, len(joints) + 1)
        self.q = [real(f"theta{k}") for k in count]
        self.dq = [real(f"dtheta{k}") for k in count]
        self.ddq = [real(f"ddtheta{k}") for k in count]
        self.angle: list[Expr] = []
        self.rate: list[Expr] = []
        for k in range(len(joints)):
            turning = [j for j in ancestors(joints, k) if joints[j].turns]
            self.angle.append(sum((self.q[j] for j in turning), Integer(0)))
            self.rate.append(sum((self.dq[j] for j in turning), Integer(0)))

    def column(self, link: int, kind: str) -> list[Expr]:
        """Return the torque at every joint (J,) for one unit of a parameter."""
        from sympy import Integer, diff

        kinetic, potential = self._energies(link, kind)
        path = set(ancestors(self.joints, link))
        state = [(self.q[k], self.dq[k], self.ddq[k]) for k in sorted(path)]
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
        from sympy import Integer, Rational, cos, sin

        angle, rate = self.angle, self.rate
        if kind == "J":
            return Rational(1, 2) * rate[link] ** 2, Integer(0)
        moving = self._origin(link)
        if kind == "X":
            kinetic = sum(
                (
                    rate[link] * (along * sin(angle[j] - angle[link]) + across * cos(angle[j] - angle[link]))
                    for j, _, along, across in moving
                ),
                Integer(0),
            )
            return kinetic, -self.gravity * cos(angle[link])
        kinetic = Integer(0)
        for j, _, along_j, across_j in moving:
            for k, _, along_k, across_k in moving:
                apart = angle[j] - angle[k]
                kinetic += Rational(1, 2) * (along_j * along_k + across_j * across_k) * cos(apart)
                kinetic += Rational(1, 2) * (along_j * across_k - across_j * along_k) * sin(apart)
        height = sum((-reach * cos(angle[j]) for j, reach, _, _ in moving), Integer(0))
        return kinetic, self.gravity * height

    def _origin(self, link: int) -> list[tuple[int, Any, Any, Any]]:
        """Return (link j, c_j, speed along e_j, speed along n_j) of the pieces of the way to a link's origin."""
        from sympy import Float, Integer

        pieces = []
        path = ancestors(self.joints, link)
        for k in path:
            joint = self.joints[k]
            if not joint.turns:
                pieces.append((k, self.q[k], self.dq[k], self.q[k] * self.rate[k]))
            if k != link:
                length = Float(joint.length)
                pieces.append((k, length, Integer(0), length * self.rate[k]))
        return pieces
