"""The rigid part of the regressor as a function of numbers: CasADi's virtual machine over all samples at
once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from symbolic.motion import Float, Motion
from symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from symbolic.model import Model


@dataclass(frozen=True, eq=False)
class RigidColumns:
    """Columns of the parameters `names` (n,), for values of `shapes` and reference values of `names`."""

    names: tuple[str, ...]
    shapes: tuple[str, ...]
    entries: tuple[tuple[int, int], ...]
    needs_reference: bool
    function: Any

    def evaluate(self, motion: Motion, shape: Float, reference: Float) -> Float:
        """Return the columns (J, N, n)."""
        out = np.zeros((len(JOINTS), len(motion), len(self.names)))
        if len(motion):
            state = np.column_stack([motion.t, motion.q, motion.dq, motion.ddq]).T
            values = np.asarray(self.function(state, shape, reference))
            for (joint, column), row in zip(self.entries, values, strict=True):
                out[joint, :, column] = row
        return out


_RECENT: dict[tuple[Any, ...], RigidColumns] = {}


def rigid_columns(model: Model) -> RigidColumns:
    """Return the rigid columns of `model`; built once per process, mechanism and geometry."""
    derived = model.derived
    key = (model.thigh_length, model.gravity, *(id(term.effect) for term in derived))
    if key not in _RECENT:
        while len(_RECENT) >= 64:
            _RECENT.pop(next(iter(_RECENT)))
        _RECENT[key] = _build(model)
    return _RECENT[key]


def _build(model: Model) -> RigidColumns:
    import casadi

    from symbolic.rigid import rigid
    from symbolic.translate import to_casadi

    form = rigid(model.derived)
    shapes = tuple(shape.name for term in model.derived for shape in term.shapes)
    state, shape = casadi.SX.sym("state", 7), casadi.SX.sym("shape", len(shapes))
    linear = casadi.SX.sym("linear", len(form.names))
    words = ("t", "theta1", "theta2", "dtheta1", "dtheta2", "ddtheta1", "ddtheta2")
    symbols = {word: state[k] for k, word in enumerate(words)}
    symbols |= {name: shape[k] for k, name in enumerate(shapes)}
    symbols |= {name: linear[k] for k, name in enumerate(form.names)}
    symbols |= {"a_th": casadi.SX(model.thigh_length), "g": casadi.SX(model.gravity)}
    entries = tuple(
        (j, k) for k in range(len(form.names)) for j in range(len(JOINTS)) if form.matrix[j, k] != 0
    )
    values = casadi.vertcat(*to_casadi([form.matrix[j, k] for j, k in entries], symbols))
    function = casadi.Function("columns", [state, shape, linear], [values], {"cse": True})
    return RigidColumns(form.names, shapes, entries, form.needs_reference, function)
