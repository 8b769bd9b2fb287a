"""From mechanism to equations of motion: M(θ) θ'' + C(θ, θ') θ' + G(θ) = τ.

Kinetic and potential energy are written down from the positions of the centres of mass, Lagrange's equation
gives the torque, and C is the Christoffel form C_ij = Σ_k ½ (∂M_ij/∂θ_k + ∂M_ik/∂θ_j - ∂M_jk/∂θ_i) θ_k',
the one for which M' - 2C is skew-symmetric. Source: equation (4) of the paper; Spong, Hutchinson,
Vidyasagar, Robot Modeling and Control.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from symbolic.mechanics.mechanism import positive

if TYPE_CHECKING:
    from sympy import Expr, Matrix

    from symbolic.mechanics.mechanism import Mechanism


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


def christoffel(mass_matrix: Matrix, mechanism: Mechanism) -> Matrix:
    """Return the Christoffel C (J, J) of the mass matrix M (J, J)."""
    from sympy import Matrix, Rational, diff

    angle, velocity = mechanism.angle, mechanism.velocity
    size = len(angle)

    def entry(i: int, j: int) -> Expr:
        return sum(
            Rational(1, 2)
            * velocity[k]
            * (
                diff(mass_matrix[i, j], angle[k])
                + diff(mass_matrix[i, k], angle[j])
                - diff(mass_matrix[j, k], angle[i])
            )
            for k in range(size)
        )

    return Matrix(size, size, entry)


@lru_cache(maxsize=32)
def mechanics(mechanism: Mechanism) -> Dynamics:
    """Derive the equations of motion of `mechanism` by Lagrange's method."""
    from sympy import Matrix, diff, expand, hessian

    kinetic, potential = energies(mechanism)
    angle, velocity = mechanism.angle, mechanism.velocity
    mass_matrix = hessian(kinetic, velocity).applyfunc(expand)
    coriolis = christoffel(mass_matrix, mechanism)
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
