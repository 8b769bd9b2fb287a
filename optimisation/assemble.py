"""From a model and prepared recordings to the linear data of a fit.

The regressor is filtered exactly like the torque, so that filtering cannot bend the parameters. A model whose
effects act on a torque of the model itself (load friction) needs parameters to compute its columns; these are
found as a fixed point: columns from the last parameters, parameters from the columns, until nothing changes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from optimisation.loss import Bool
from optimisation.problem import LinearData
from symbolic.motion import Float, Motion

FIXED_POINT_ROUNDS = 60
FIXED_POINT_TOLERANCE = 1e-11


class Prepared(Protocol):
    """A recording ready to be fitted: `motion` (N samples), `tau` and `use` (K, J) of the K samples kept."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def motion(self) -> Motion: ...  # noqa: D102
    @property
    def tau(self) -> Float: ...  # noqa: D102
    @property
    def use(self) -> Bool: ...  # noqa: D102

    def smooth(self, x: Float) -> Float:
        """Filter `x` (N, ...) over time as the torque was filtered and return the kept samples (K, ...)."""


class FittableModel(Protocol):
    """The part of `symbolic.model.Model` that a fit needs."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def limits(self) -> Mapping[str, Any]: ...  # noqa: D102
    @property
    def parameters(self) -> Sequence[Any]: ...  # noqa: D102
    @property
    def shapes(self) -> Sequence[Any]: ...  # noqa: D102
    @property
    def needs_reference(self) -> bool: ...  # noqa: D102

    def columns(self, motion: Motion, shape: Float | None = None, reference: Float | None = None) -> Float:
        """Return the regressor (J, N, P)."""


def assemble(
    model: FittableModel,
    prepared: Sequence[Prepared],
    shape: Float | None = None,
    reference: Float | None = None,
) -> LinearData:
    """Return the linear data of all `prepared` recordings.

    `shape` (S,) are the shape values, `reference` (P,) the parameters a fed-back torque is computed from.
    """
    columns = []
    for one in prepared:
        raw = model.columns(one.motion, shape, reference)
        columns.append(np.moveaxis(one.smooth(np.moveaxis(raw, 0, 1)), 0, 1))
    return LinearData(
        columns=np.concatenate(columns, axis=1),
        tau=np.concatenate([one.tau for one in prepared]).T,
        groups=np.repeat(np.arange(len(prepared)), [len(one.tau) for one in prepared]),
        names=tuple(p.name for p in model.parameters),
        units=tuple(p.unit for p in model.parameters),
        use=np.concatenate([one.use for one in prepared]).T,
    )


@dataclass(frozen=True, eq=False)
class Settled:
    """Linear data, the parameters (P,) that solve it, and how many `rounds` the fixed point took."""

    data: LinearData
    linear: Float
    rounds: int
    converged: bool


def settle(
    model: FittableModel,
    prepared: Sequence[Prepared],
    shape: Float | None,
    solve: Callable[[LinearData], Float],
    reference: Float | None = None,
) -> Settled:
    """Solve the linear parameters; where the model needs reference parameters, iterate them to their fixed
    point.

    The first reference is `reference` (P,) or zero, which makes the dependent columns vanish in the first
    round.
    """
    if not model.needs_reference:
        data = assemble(model, prepared, shape)
        return Settled(data, solve(data), 1, True)
    last = np.zeros(len(model.parameters)) if reference is None else np.asarray(reference, dtype=float)
    for count in range(1, FIXED_POINT_ROUNDS + 1):
        data = assemble(model, prepared, shape, last)
        linear = solve(data)
        change = float(np.linalg.norm(data.factor.forward @ (linear - last)))
        size = float(np.linalg.norm(data.factor.forward @ linear))
        if change <= FIXED_POINT_TOLERANCE * max(size, np.finfo(float).tiny):
            return Settled(data, linear, count, True)
        last = linear
    return Settled(data, linear, FIXED_POINT_ROUNDS, False)
