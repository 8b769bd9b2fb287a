"""Columns of a tree of links in space in CasADi: Newton and Euler's recursion, confirmed by Lagrange."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.symbolic.codegen.tree_columns import CONFIRMED, SEED, STATES, DerivationError
from exoid.symbolic.joints import Joint, Vector
from exoid.symbolic.mechanics.base_parameters import BaseParameter, base_parameters, pull_of
from exoid.symbolic.mechanics.spatial import KINDS, joint_torques, link_columns
from exoid.symbolic.mechanics.spatial_energy import lagrange_torques

if TYPE_CHECKING:
    from exoid.symbolic.model_structure import ModelStructure


def spatial_columns(
    model: ModelStructure,
    q: Sequence[Any],
    dq: Sequence[Any],
    ddq: Sequence[Any],
    linear: Any,
    base: Sequence[Any] = (),
) -> tuple[list[list[Any]], list[Any]]:
    """Return the torque at every joint (J,) per unit of each base parameter (P,), for CasADi expressions of the motion,
    and the torque (J,) of them all with the numbers `linear`, a shorter form than the sum of the columns; `base` (12,)
    is how one moves.

    DerivationError where Lagrange's equation gives another torque at random states.
    """
    import casadi

    joints, pull = model.chain, pull_of(model.pull)
    found = base_parameters(joints, model.pull, model.moving_base)
    _confirm(joints, pull, found, model.moving_base)
    columns = link_columns(joints, pull, q, dq, ddq, casadi, [(p.link, p.kind) for p in found], base)
    whole = [[casadi.SX(entry) for entry in column] for column in columns]
    inertial: list[dict[str, Any]] = [{} for _ in joints]
    for p, parameter in enumerate(found):
        inertial[parameter.link][parameter.kind] = linear[p]
    return whole, [casadi.SX(entry) for entry in joint_torques(joints, pull, q, dq, ddq, casadi, inertial, base)]


def _confirm(joints: tuple[Joint, ...], pull: Vector, found: Sequence[BaseParameter], moving: bool) -> None:
    """Compare the base parameters' torque with Lagrange's of links with ten random parameters each."""
    import casadi

    rng, count = np.random.default_rng(SEED), len(joints)
    links = [dict(zip(KINDS, rng.normal(size=len(KINDS)), strict=True)) for _ in joints]
    q, dq, ddq = (casadi.SX.sym(name, count) for name in ("q", "dq", "ddq"))
    base = casadi.SX.sym("base", 12 * moving)
    torque = lagrange_torques(joints, pull, q, dq, ddq, links, base if moving else None)
    derived = casadi.Function("derived", [q, dq, ddq, base], [torque])
    states = rng.normal(size=(3, count, STATES))
    swaying = rng.normal(size=(12 * moving, STATES))
    wanted = np.asarray(derived(*states, swaying))
    numbers = [
        links[p.link][p.kind] + sum(factor * links[link][kind] for link, kind, factor in p.parts) for p in found
    ]
    turned, rates, turning = ([*rows] for rows in states)
    places = [(p.link, p.kind) for p in found]
    columns = link_columns(joints, pull, turned, rates, turning, np, places, [*swaying])
    torques = np.zeros((count, STATES))
    for number, column in zip(numbers, columns, strict=True):
        torques += number * np.array([entry + np.zeros(STATES) for entry in column])
    if np.max(np.abs(torques - wanted)) > CONFIRMED * np.max(np.abs(wanted), initial=1.0):
        names = ", ".join(joint.name for joint in joints)
        raise DerivationError(f"Newton and Euler and Lagrange disagree on the machine with joints {names}")
