"""Where a point of the leg is, how it moves, and what a force on it asks of the joints: for cuffs and sensors.

The point is fixed to a link, `along` it from its upper joint and `across` it (m, positive to the front of a hanging
leg). Position and Jacobian J come from the mechanism of the model, so that offsets of encoders and whatever else its
effects change about the geometry are in them. A force F (to the front, upwards, N) on the point asks Jᵀ F of the
joints (paper, equation (4)).
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ground.errors import EffectError
from symbolic.codegen.translate import casadi_from_sympy
from symbolic.mechanics.mechanism import real
from symbolic.motion import Float, Motion

if TYPE_CHECKING:
    from symbolic.mechanics.mechanism import Mechanism
    from symbolic.model import Model


def position(
    model: Model, motion: Motion, link: str = "shank", along: float = 0.0, across: float = 0.0, shape: Any = None
) -> Float:
    """Return the position (N, 2) in m, to the front and upwards, of a point seen from the hip.

    `shape` (S,) are the model's shape values (default: typical). EffectError for a link that the leg does not have.
    """
    return _evaluate(model, motion, link, along, across, shape)[:, :2]


def jacobian(
    model: Model, motion: Motion, link: str = "shank", along: float = 0.0, across: float = 0.0, shape: Any = None
) -> Float:
    """Return J (N, 2, J) in m/rad: how fast the point moves to the front and upwards per joint velocity."""
    flat = _evaluate(model, motion, link, along, across, shape)[:, 2:]
    return np.ascontiguousarray(flat.reshape(len(motion), 2, -1))


def _evaluate(model: Model, motion: Motion, link: str, along: float, across: float, shape: Any) -> Float:
    names = [one.name for one in model.mechanism.links]
    if link not in names:
        raise EffectError(f"the leg has no link {link!r}", where="point", remedy=f"use {' or '.join(names)}")
    values = model.typical_shape if shape is None else np.asarray(shape, dtype=float)
    if values.shape != (len(model.shapes),):
        raise ValueError(f"shape has shape {values.shape}, the model has {len(model.shapes)} shapes")
    at = {s.name: float(v) for s, v in zip(model.shapes, values, strict=True)}
    function, needed = _function(model.mechanism, names.index(link))
    missing = [name for name in needed if name not in at]
    if missing:
        raise EffectError(
            f"where the point is depends on {', '.join(missing)}, which is not a shape of the model",
            where="point",
            remedy="ask without that effect",
        )
    given = [model.thigh_length, along, across, *(at[name] for name in needed)]
    return np.asarray(function(motion.q.T, np.array(given, dtype=float))).T


@lru_cache(maxsize=32)
def _function(mechanism: Mechanism, index: int) -> tuple[Any, tuple[str, ...]]:
    """Return a CasADi function of angles (J, N) and (a_th, along, across, shapes), and the names of those shapes."""
    import casadi as ca
    from sympy import Matrix

    along, across = real("along"), real("across")
    point = Matrix(mechanism.point(index, along, across))
    entries = [*point, *point.jacobian(list(mechanism.angle))]
    known = {"a_th", "along", "across", *(angle.name for angle in mechanism.angle)}
    needed = tuple(sorted({s.name for e in entries for s in e.free_symbols} - known))
    q, given = ca.SX.sym("q", len(mechanism.angle)), ca.SX.sym("given", 3 + len(needed))
    symbols = {angle.name: q[k] for k, angle in enumerate(mechanism.angle)}
    symbols |= {name: given[k] for k, name in enumerate(("a_th", "along", "across", *needed))}
    made = ca.Function("point", [q, given], [ca.vertcat(*casadi_from_sympy(entries, symbols))])

    def call(angles: Float, values: Float) -> Any:
        return made(angles, np.repeat(values[:, None], angles.shape[1], axis=1))

    return call, needed
