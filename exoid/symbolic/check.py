"""Proofs and spot checks of a derivation: what `exoid generate --check` says about the equations themselves.

Identities are proved symbolically: both sides are written as sums of harmonics, where equal functions are equal
expressions. Positive definiteness is proved through the determinant where it is a sum of positive terms, and tried on
random physical legs in any case.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.symbolic.codegen.kernel import compiled
from exoid.symbolic.codegen.translate import casadi_from_sympy
from exoid.symbolic.codegen.tree_columns import CONFIRMED
from exoid.symbolic.mechanics.base_parameters import base_parameters, pull_of
from exoid.symbolic.mechanics.lagrange import Dynamics, energies, harmonic, mechanics
from exoid.symbolic.mechanics.mechanism import leg
from exoid.symbolic.mechanics.newton_euler import STILL, BaseMotion, link_torques
from exoid.symbolic.mechanics.pushed import placed_joints, pushed_torques
from exoid.symbolic.mechanics.regressor import compare_with_printed, derive_regressor
from exoid.symbolic.mechanics.spatial import about_joint, joint_torques
from exoid.symbolic.motion import Float, Motion

if TYPE_CHECKING:
    from sympy import Expr, Matrix

    from exoid.symbolic.mechanics.mechanism import Mechanism
    from exoid.symbolic.model_structure import ModelStructure

SEED = 20260
STATES = 200
AGREEMENT = 1e-12
"""Relative difference allowed between compiled C and CasADi's virtual machine; both are IEEE double arithmetic."""


@dataclass(frozen=True)
class Check:
    """One property: its `name`, whether it `holds`, how that was found (`how`: "proved", "tried"), and the `detail`."""

    name: str
    holds: bool
    how: str
    detail: str

    def __str__(self) -> str:
        return f"{'yes' if self.holds else 'NO '}  {self.name} ({self.how}): {self.detail}"


def check_equations(model: ModelStructure) -> tuple[Check, ...]:
    """Return every check of the model's equations; all of them should hold."""
    from sympy import Matrix

    if model.chain:
        return _tree_checks(model)
    mechanism = model.mechanism
    motion = mechanics(mechanism)
    assembled = motion.M * Matrix(mechanism.acceleration) + motion.C * Matrix(mechanism.velocity) + motion.G
    found = [
        _zero("M is symmetric", motion.M - motion.M.T, "M - Mᵀ = 0"),
        *positive_definite(mechanism, motion),
        _skew(mechanism, motion),
        _zero("equation of motion", assembled - motion.torque, "M θ'' + C θ' + G is Lagrange's torque"),
        _energy(mechanism, motion),
        _regressor(mechanism, motion),
        *paper_checks(),
        *_force_checks(model),
        agreement(model),
    ]
    return tuple(found)


def _tree_checks(model: ModelStructure) -> tuple[Check, ...]:
    """Return the checks of a machine that is not the leg, at random states of random links that could exist."""
    rng, joints = np.random.default_rng(SEED), model.chain
    bare, count = compiled(model.base().unpushed), len(model.chain)
    at_rest = Motion(np.arange(float(STATES)), *(rng.normal(size=(STATES, count)) for _ in range(3)))
    base = rng.normal(size=(STATES, len(model.base_state))) if model.moving_base else None
    motion = replace(at_rest, base=base)
    links = _random_links(rng, count, model.spatial)
    phi = [
        links[p.kind][p.link] + sum(factor * links[kind][link] for link, kind, factor in p.parts)
        for p in base_parameters(joints, model.pull, model.moving_base)
    ]
    linear = np.array([*phi, *([0.0] * 2 * count)])
    swaying = STILL if base is None or model.spatial else BaseMotion(*base.T)
    wanted = _newton_euler(model, motion, links, swaying)
    found = bare.inverse_dynamics(motion, linear)
    m, c = bare.mass_matrix(motion, linear), bare.coriolis(motion, linear)
    apart = bare.gravity(at_rest, linear) - bare.inverse_dynamics(at_rest, linear)
    assembled = np.einsum("nij,nj->ni", m, motion.ddq) + np.einsum("nij,nj->ni", c, motion.dq)
    eigenvalues = np.linalg.eigvalsh(m)
    size = float(np.max(np.abs(wanted)))
    return (
        _close("Newton and Euler's torque", found - wanted, size, "the links' own masses give the same torque"),
        _close("M is symmetric", m - m.transpose(0, 2, 1), float(np.max(np.abs(m))), "M - Mᵀ"),
        Check(
            "M is positive definite", bool(eigenvalues.min() > 0.0), "tried",
            f"smallest eigenvalue {float(np.min(eigenvalues[:, 0] / eigenvalues[:, -1])):.3g} of its largest",
        ),
        _close("equation of motion", assembled + apart, size, "M θ'' + C θ' + G"),
        *_force_checks(model),
        agreement(model),
    )  # fmt: skip


def _random_links(rng: np.random.Generator, count: int, spatial: bool) -> dict[str, Float]:
    """Return {kind: (J,)} of random links that could exist."""
    mass, along, own = rng.uniform(0.5, 3.0, count), rng.uniform(0.05, 0.3, count), rng.uniform(0.01, 0.2, count)
    if not spatial:
        return {"J": own + mass * along**2, "X": mass * along, "m": mass}
    centre = along[:, None] * rng.uniform(-1.0, 1.0, (count, 3))
    return about_joint(mass, centre.T, np.eye(3)[:, :, None] * own)


def _newton_euler(model: ModelStructure, motion: Motion, links: dict[str, Float], swaying: BaseMotion) -> Float:
    """Return the torque (N, J) of links with their own numbers."""
    q, dq, ddq = ([*rows.T] for rows in (motion.q, motion.dq, motion.ddq))
    still = np.zeros(len(motion))
    if model.spatial:
        own = [{kind: values[k] for kind, values in links.items()} for k in range(len(model.joints))]
        return np.column_stack([
            row + still for row in joint_torques(
                model.chain, pull_of(model.pull), q, dq, ddq, np, own, () if motion.base is None else [*motion.base.T]
            )
        ])
    wanted = np.zeros((len(motion), len(model.joints)))
    for k, torque in enumerate(link_torques(model.chain, model.gravity, q, dq, ddq, np, swaying)):
        for kind, rows in torque.items():
            wanted += links[kind][k] * np.column_stack([row + still for row in rows])
    return wanted


def _force_checks(model: ModelStructure) -> tuple[Check, ...]:
    """Checks that Newton and Euler ask the drives for the same as the virtual work of every measured force does."""
    if not model.forces:
        return ()
    rng, joints, count = np.random.default_rng(SEED), placed_joints(model), len(model.joints)
    q = rng.normal(size=(STATES, count))
    base = rng.normal(size=(STATES, len(model.base_state))) if model.moving_base else None
    still = np.zeros_like(q)
    swaying = STILL if base is None or model.spatial else BaseMotion(*base.T)
    found = []
    for force in model.forces:
        at = 0.3 if force.at is None and not force.in_space else force.at
        alone = model.base().with_forces(replace(force, at=at, gain=1.0, sign=1))
        pushed = rng.normal(size=(STATES, len(force.columns)))
        motion = Motion(np.arange(float(STATES)), q, still, still, still, base=base, force=pushed)
        torque = compiled(alone).pointwise(motion, np.zeros(len(alone.parameters)), np.zeros(0))[:, :, -1].T
        wanted = pushed_torques(joints, q, force, 0.0 if isinstance(at, tuple) else at or 0.0, pushed, swaying)
        size = float(np.max(np.abs(wanted), initial=0.0))
        detail = f"Newton and Euler ask the drives for the same as the virtual work of {force.name}"
        found.append(_close("measured forces", torque - wanted, size, detail))
    return tuple(found)


def _close(name: str, difference: Float, size: float, detail: str) -> Check:
    worst = float(np.max(np.abs(difference), initial=0.0)) / max(size, 1e-300)
    return Check(name, worst <= CONFIRMED, "tried", f"{detail}: to {worst:.1e} on {STATES} random states")


def _zero(name: str, matrix: Any, detail: str) -> Check:
    remainder = matrix.applyfunc(harmonic)
    holds = all(entry == 0 for entry in remainder)
    return Check(name, holds, "proved", detail if holds else f"remainder {list(remainder)}")


def _skew(mechanism: Mechanism, motion: Dynamics) -> Check:
    rate = sum((motion.M.diff(q) * dq for q, dq in _state(mechanism)), start=0 * motion.M)
    difference = rate - 2 * motion.C
    return _zero("M' - 2C is skew-symmetric", difference + difference.T, "C is the Christoffel form")


def _energy(mechanism: Mechanism, motion: Dynamics) -> Check:
    """Power at the joints is the rate of change of the energy (of a base that does not move)."""
    from sympy import Integer, Matrix

    still = replace(mechanism, base_acceleration=(Integer(0), Integer(0)))
    kinetic, potential = energies(still)
    total = kinetic + potential
    rate = sum(
        total.diff(q) * dq + total.diff(dq) * ddq
        for q, dq, ddq in zip(still.angle, still.velocity, still.acceleration, strict=True)
    )
    power = (Matrix(still.velocity).T * mechanics(still).torque)[0]
    return _zero("energy balance", Matrix([rate - power]), "d(T + V)/dt = θ'ᵀ τ")


def _regressor(mechanism: Mechanism, motion: Dynamics) -> Check:
    from sympy import Matrix, expand

    form = derive_regressor(mechanism)
    difference = (form.matrix * Matrix(form.parameters) + form.known - motion.torque).applyfunc(expand)
    return _zero("Y Φ is the torque", difference, f"{len(form.names)} base parameters: {', '.join(form.names)}")


def positive_definite(mechanism: Mechanism, motion: Dynamics) -> list[Check]:
    """Return the proof by determinant, where it goes through, and the trial on random physical legs."""
    found = []
    determinant = positive_terms(mechanism, motion.M.det())
    if determinant is not None and motion.M.rows == 2:
        found.append(Check("M is positive definite", True, "proved", f"det M = {determinant}, every term positive"))
    smallest = _smallest_eigenvalue(motion.M)
    how = f"smallest eigenvalue {smallest:.3g} of its largest on {STATES} random physical legs"
    found.append(Check("M is positive definite", smallest > 0.0, "tried", how))
    return found


def positive_terms(mechanism: Mechanism, expression: Expr) -> Expr | None:
    """Return the expression as a sum of terms that cannot be negative, or None where that is not found."""
    from sympy import Add, cos, expand, sin

    squared = {cos(a) ** 2: 1 - sin(a) ** 2 for a in mechanism.angle}
    expanded = expand(expand(expression).subs(squared))
    terms = Add.make_args(expanded)
    return expanded if expanded.is_positive or all(term.is_nonnegative for term in terms) else None


def _smallest_eigenvalue(mass_matrix: Matrix) -> float:
    import casadi

    symbols = sorted(mass_matrix.free_symbols, key=str)
    inputs = casadi.SX.sym("inputs", len(symbols))
    values = casadi_from_sympy(list(mass_matrix), {s.name: inputs[k] for k, s in enumerate(symbols)})
    function = casadi.Function("M", [inputs], [casadi.vertcat(*values)])
    rng = np.random.default_rng(SEED)
    low = np.array([0.05 if symbol.is_positive else -0.3 for symbol in symbols])
    high = np.array([2.0 if symbol.is_positive else 0.3 for symbol in symbols])
    free = np.array([str(symbol).startswith("theta") for symbol in symbols], dtype=bool)
    draws = rng.uniform(np.where(free, -np.pi, low), np.where(free, np.pi, high), size=(STATES, len(symbols)))
    size = mass_matrix.rows
    matrices = np.asarray(function(draws.T)).T.reshape(-1, size, size)
    eigenvalues = np.linalg.eigvalsh(matrices)
    return float(np.min(eigenvalues[:, 0] / eigenvalues[:, -1]))


def paper_coriolis(mechanism: Mechanism) -> Matrix:
    """Return C as the paper prints it: m_sh a_th l_sh sin θ2 [[-2 θ2', -θ2'], [θ1', 0]]."""
    from sympy import Matrix, sin

    thigh, shank = mechanism.links
    v1, v2 = mechanism.velocity
    factor = shank.mass * thigh.length * shank.along * sin(mechanism.angle[1])
    return factor * Matrix([[-2 * v2, -v2], [v1, 0]])


def paper_checks() -> list[Check]:
    """Checks of the equations as the paper prints them."""
    from sympy import Matrix

    plain = leg()
    motion, printed = mechanics(plain), paper_coriolis(plain)
    velocity = Matrix(plain.velocity)
    same = _zero("the paper's C", (printed - motion.C) * velocity, "gives the same C θ' as the Christoffel form")
    rate = sum((motion.M.diff(q) * dq for q, dq in _state(plain)), start=0 * motion.M)
    lopsided = rate - 2 * printed
    remainder = (lopsided + lopsided.T).applyfunc(harmonic)
    other = Check(
        "the paper's C is not the Christoffel form",
        any(entry != 0 for entry in remainder),
        "proved",
        f"M' - 2C has the symmetric part {remainder[0, 0] / 2} at (1, 1)",
    )
    entries = compare_with_printed(plain)
    printing = Check(
        "the paper's Y differs in entry (1, 3) alone",
        [(entry.row, entry.column) for entry in entries] == [(1, 3)],
        "proved",
        "; ".join(str(entry) for entry in entries),
    )
    return [same, other, printing]


def agreement(model: ModelStructure) -> Check:
    """Check that compiled C and CasADi's virtual machine give the same regressor and torque."""
    rng = np.random.default_rng(SEED)
    motion = Motion(np.linspace(0.0, 2.0, STATES), *(rng.normal(size=(STATES, len(model.joints))) for _ in range(3)))
    motion = replace(motion, force=rng.normal(size=(STATES, len(model.channels))))
    linear = rng.normal(size=len(model.parameters))
    fast, slow = compiled(model), compiled(model, "vm")
    if fast.backend == "vm":
        return Check(
            "C and virtual machine agree", True, "tried", "no compiler here: there is only the virtual machine"
        )
    pairs = [(item.columns(motion, None, linear), item.inverse_dynamics(motion, linear)) for item in (fast, slow)]
    worst = max(float(np.max(np.abs(a - b)) / np.max(np.abs(b))) for a, b in zip(*pairs, strict=True))
    return Check("C and virtual machine agree", worst <= AGREEMENT, "tried", f"to {worst:.1e} of the largest value")


def _state(mechanism: Mechanism) -> list[tuple[Any, Any]]:
    return list(zip(mechanism.angle, mechanism.velocity, strict=True))
