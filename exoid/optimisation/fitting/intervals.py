"""The intervals of a fit: the covariance of linear and shape parameters, and each parameter with its bounds."""

from __future__ import annotations

import numpy as np

from exoid.optimisation.fitting.assemble import Assembly, Settled
from exoid.optimisation.fitting.shapes import slope_by_shape
from exoid.optimisation.linear.physical import Physics
from exoid.optimisation.linear.uncertainty import Covariance, covariance
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate


def spread_of(assembly: Assembly, found: Settled, shape: Float, delta: Float) -> Covariance:
    """Return the joint covariance of linear and shape parameters, through the Jacobian of the torque."""
    model, columns, linear = assembly.model, found.data.columns, found.linear
    if not shape.size and not model.needs_reference:
        residual = found.data.residual(linear)
        return covariance(columns, residual, delta, found.data.groups, factor=found.data.factor)

    def predicted(values: Float, at: Float) -> Float:
        return -assembly.data(at, values if model.needs_reference else None).residual(values)  # up to a constant

    slopes = []
    for index, entry in enumerate(model.shapes):
        # A value each recording has to itself is not one number with one interval.
        flat = bool(entry.shape.choices) or entry.shape.per_recording
        slopes.append(
            np.zeros_like(found.data.tau)
            if flat
            else slope_by_shape(lambda at: predicted(linear, at), shape, index, entry.shape, 1e-4)
        )
    total = columns
    if model.needs_reference:
        total = columns.copy()
        size = np.maximum(np.abs(linear), 1e-3 * max(1e-12, float(np.abs(linear).max())))
        for p in model.reference_places:
            step_p = np.zeros(linear.size)
            step_p[p] = 1e-5 * size[p]
            total[:, :, p] = (predicted(linear + step_p, shape) - predicted(linear - step_p, shape)) / (2.0 * step_p[p])
    extra = np.stack(slopes, axis=2) if slopes else np.zeros((*found.data.tau.shape, 0))
    jacobian = np.concatenate([total, extra], axis=2)
    jacobian = jacobian * found.data.use[:, :, None]
    instruments = np.concatenate([columns, extra], axis=2) if model.needs_reference else None
    return covariance(jacobian, found.data.residual(linear), delta, found.data.groups, instruments)


def estimates_of(
    model: Model, linear: Float, shape: Float, spread: Covariance, possible: Physics | None = None
) -> tuple[Estimate, ...]:
    """Return every parameter with its 95 % interval: linear ones, then shapes."""
    half = spread.half_widths()
    if model.wearer is not None:  # whoever differs from the table leaves the difference in the machine's numbers
        own = spread.critical * model.wearer.deviation(model)
        half[: own.size] = np.hypot(half[: own.size], own)
    middle_shape = middle(shape)
    named = [(p.name, p.unit) for p in model.parameters] + [(s.name, s.shape.unit) for s in model.shapes]
    values = np.concatenate([linear, middle_shape])
    low, high = values - half, values + half
    if possible is not None:  # an interval goes no further than a leg can
        count = linear.size
        low[:count] = np.clip(low[:count], possible.low, possible.high)
        high[:count] = np.clip(high[:count], possible.low, possible.high)
    for index, entry in enumerate(model.shapes):
        place = linear.size + index
        # A choice is not estimated by a derivative; what each recording has to itself spans a range.
        if entry.shape.choices:
            low[place] = high[place] = values[place]
        elif entry.shape.per_recording and shape.ndim == 2:
            low[place], high[place] = shape[:, index].min(), shape[:, index].max()
    return tuple(
        Estimate(name, float(v), unit, float(a), float(b))
        for (name, unit), v, a, b in zip(named, values, low, high, strict=True)
    )


def middle(shape: Float) -> Float:
    """Return one row (S,) that stands for shape values (S,) or (R, S)."""
    return shape if shape.ndim == 1 else np.asarray(np.median(shape, axis=0))
