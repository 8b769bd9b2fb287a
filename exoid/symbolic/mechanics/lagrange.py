"""From mechanism to equations of motion: M(θ) θ'' + C(θ, θ') θ' + G(θ) = τ.

Kinetic and potential energy are written down from the positions of the centres of mass, Lagrange's equation
gives the torque, and C is the Christoffel form C_ij = Σ_k ½ (∂M_ij/∂θ_k + ∂M_ik/∂θ_j - ∂M_jk/∂θ_i) θ_k',
the one for which M' - 2C is skew-symmetric. Source: equation (4) of the paper; Spong, Hutchinson,
Vidyasagar, Robot Modeling and Control.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from exoid.symbolic.mechanics.mechanism import positive

if TYPE_CHECKING:
    from sympy import Expr, Matrix

    from exoid.symbolic.mechanics.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Dynamics:
    """M, C (J, J), G (J, 1) and `torque` (J, 1) = M θ'' + C θ' + G; J (2, J) of a point `reach` m down the
    last link.
    """

    M: Matrix
    C: Matrix
    G: Matrix
    J: Matrix
    torque: Matrix


def harmonic(expression: Expr) -> Expr:
    """Write products of sines and cosines as sums, so that equal functions of the angles are equal
    expressions.
    """
    from sympy import expand
    from sympy.simplify.fu import TR8

    return expand(TR8(expand(expression)))


def energies(mechanism: Mechanism) -> tuple[Expr, Expr]:
    """Return kinetic and potential energy in J.

    An accelerated hip is an added field of gravity against the acceleration (d'Alembert), so it enters the
    potential.
    """
    from sympy import Integer, Rational, cos, diff, sin

    kinetic = potential = Integer(0)
    pull_x = mechanism.gravity * sin(mechanism.tilt) + mechanism.base_acceleration[0]
    pull_z = mechanism.gravity * cos(mechanism.tilt) + mechanism.base_acceleration[1]
    state = list(zip(mechanism.angle, mechanism.velocity, strict=True))
    for index, link in enumerate(mechanism.links):
        x, z = mechanism.point(index, link.along, link.across)
        speed = [sum(diff(p, angle) * velocity for angle, velocity in state) for p in (x, z)]
        spin = sum(mechanism.velocity[: index + 1])
        kinetic += Rational(1, 2) * (link.mass * (speed[0] ** 2 + speed[1] ** 2) + link.inertia * spin**2)
        potential += link.mass * (pull_x * x + pull_z * z)
    return harmonic(kinetic), harmonic(potential)


def christoffel(slopes: Sequence[Any], velocity: Sequence[Any], half: Any) -> list[list[Any]]:
    """Return the Christoffel C (J, J) of a mass matrix with `slopes` (J, J) by every angle (J,), SymPy's or CasADi's as
    `half` is.
    """
    count = range(len(velocity))
    return [
        [
            sum(half * velocity[k] * (slopes[k][i, j] + slopes[j][i, k] - slopes[i][j, k]) for k in count)
            for j in count
        ]
        for i in count
    ]


@lru_cache(maxsize=32)
def mechanics(mechanism: Mechanism) -> Dynamics:
    """Derive the equations of motion of `mechanism` by Lagrange's method."""
    from sympy import Matrix, Rational, diff, expand, hessian

    kinetic, potential = energies(mechanism)
    angle, velocity = mechanism.angle, mechanism.velocity
    mass_matrix = hessian(kinetic, velocity).applyfunc(expand)
    coriolis = Matrix(christoffel([mass_matrix.diff(q) for q in angle], velocity, Rational(1, 2)))
    gravity = Matrix([expand(diff(potential, angle_i)) for angle_i in angle])
    torque = Matrix([expand(lagrange(kinetic, potential, mechanism, i)) for i in range(len(angle))])
    contact = Matrix(mechanism.point(len(angle) - 1, positive("reach")))
    return Dynamics(
        M=mass_matrix,
        C=coriolis,
        G=gravity,
        J=contact.jacobian(angle),
        torque=torque,
    )


def lagrange(kinetic: Expr, potential: Expr, mechanism: Mechanism, index: int) -> Expr:
    """Return d/dt ∂T/∂θ_i' - ∂T/∂θ_i + ∂V/∂θ_i, the torque in N·m at joint `index`."""
    from sympy import diff

    state = list(zip(mechanism.angle, mechanism.velocity, mechanism.acceleration, strict=True))
    momentum = diff(kinetic, mechanism.velocity[index])
    rate = sum(diff(momentum, q) * dq + diff(momentum, dq) * ddq for q, dq, ddq in state)
    return rate - diff(kinetic, mechanism.angle[index]) + diff(potential, mechanism.angle[index])
