"""Columns of a planar tree in CasADi: Lagrange's, confirmed by Newton and Euler; the latter's own where there are many
joints.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from exoid.symbolic.codegen.translate import casadi_from_sympy
from exoid.symbolic.joints import Joint
from exoid.symbolic.mechanics.base_parameters import base_parameters
from exoid.symbolic.mechanics.newton_euler import ACROSS, AS_GIVEN, STILL, BaseMotion, link_torques
from exoid.symbolic.mechanics.tree import tree_form

LONGEST_SYMBOLIC = 6
"""Joints up to which Lagrange's equations are the shorter form; Newton and Euler's recursion is used beyond."""
CONFIRMED = 1e-10
"""Largest difference allowed between the two, relative to the largest entry of the regressor."""
STATES, SEED = 20, 20263


class DerivationError(ArithmeticError):
    """Two derivations of the same machine disagree: an error in exoid."""


@dataclass(frozen=True)
class AlteredLinks:
    """Links with a mass beside their axis (`across`), and those of another length than their joints say, {link: m}."""

    across: tuple[int, ...] = ()
    lengths: Mapping[int, Any] = field(default_factory=lambda: AS_GIVEN)


AS_THEY_ARE = AlteredLinks()


def tree_columns(
    joints: tuple[Joint, ...],
    gravity: float,
    q: Sequence[Any],
    dq: Sequence[Any],
    ddq: Sequence[Any],
    base: BaseMotion = STILL,
    altered: AlteredLinks = AS_THEY_ARE,
    measured: bool = False,
    longest: int = LONGEST_SYMBOLIC,
) -> list[list[Any]]:
    """Return the torque at every joint (J,) per unit of each base parameter (P,), for CasADi symbols of the motion.

    `base` are CasADi expressions of the base's motion, `measured` where they are those of recordings. A column for
    the mass beside the axis of each link that is `altered` so follows. Up to `longest` joints they are Lagrange's.
    DerivationError where Lagrange and Newton-Euler differ at random states.
    """
    import casadi

    across, lengths = altered.across, altered.lengths
    parameters = base_parameters(joints, gravity, measured)
    links = link_torques(joints, gravity, q, dq, ddq, casadi, base, across, lengths)
    wanted_of = [(p.link, p.kind) for p in parameters] + [(link, ACROSS) for link in across]
    recursive = [[casadi.SX(entry) for entry in links[link][kind]] for link, kind in wanted_of]
    if len(joints) > longest:
        return recursive
    moving = base is not STILL
    form = tree_form(joints, gravity, across, moving, measured, tuple(lengths))
    symbols: dict[str, Any] = {
        f"{stem}{k + 1}": symbol
        for stem, row in zip(("theta", "dtheta", "ddtheta"), (q, dq, ddq), strict=True)
        for k, symbol in enumerate(row)
    }
    symbols |= {"g_x": casadi.SX(base.forward), "g_z": gravity + casadi.SX(base.upward)}
    symbols |= {f"length{k + 1}": length for k, length in lengths.items()}
    symbols |= {"base": base.angle, "dbase": base.rate, "ddbase": base.turning}
    columns = [casadi_from_sympy(list(form.matrix[:, k]), symbols) for k in range(len(wanted_of))]
    both = [casadi.vertcat(*(entry for column in found for entry in column)) for found in (columns, recursive)]
    inputs = casadi.symvar(casadi.vertcat(*both))
    function = casadi.Function("both", [casadi.vertcat(casadi.SX(0, 1), *inputs)], both)
    states = np.random.default_rng(SEED).normal(size=(len(inputs), STATES))
    derived, wanted = (np.asarray(values) for values in function(states))
    if np.max(np.abs(derived - wanted), initial=0.0) > CONFIRMED * np.max(np.abs(wanted), initial=1.0):
        names = ", ".join(joint.name for joint in joints)
        raise DerivationError(f"Lagrange and Newton-Euler disagree on the machine with joints {names}")
    return columns
