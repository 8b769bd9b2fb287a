"""The numbers at which a model is evaluated beforehand: identified ones, else those of the bench's leg."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exoid.measurement.bench.simulation import bench_machine
from exoid.symbolic.model import Model
from exoid.symbolic.model_file import Numbers
from exoid.symbolic.motion import Float


@dataclass(frozen=True, eq=False)
class Nominal:
    """Values `linear` (P,) and `shape` (S,) of a model, and in words where they come from."""

    linear: Float
    shape: Float
    source: str


def nominal(model: Model, numbers: Numbers | None = None) -> Nominal:
    """Return the identified `numbers` of `model` where there are some, else the standard leg's and typical ones."""
    linear = {} if numbers is None else numbers.linear
    shape = {} if numbers is None else numbers.shape
    usual = dict(zip((p.name for p in model.parameters), bench_machine(model).base, strict=False))
    values = [linear.get(p.name, usual.get(p.name, p.typical or 0.0)) for p in model.parameters]
    shapes = [shape.get(s.name, s.typical) for s in model.shapes]
    wanted = {p.name for p in model.parameters} | {s.name for s in model.shapes}
    known = wanted & {*linear, *shape}
    if not known:
        source = f"the virtual bench's {'machine' if model.chain else 'standard leg'}, effects at their typical size"
    elif known == wanted:
        source = "the model file's identified parameters"
    else:
        source = "the model file's identified parameters, typical ones where it has none"
    return Nominal(np.array(values, dtype=float), np.array(shapes, dtype=float), source)


def sizes(model: Model, at: Nominal) -> Float:
    """Return the size (M,) that relative deviations are relative to: |value|, else the typical size, else 0."""
    linear = [abs(v) or abs(p.typical or 0.0) for v, p in zip(at.linear, model.parameters, strict=True)]
    shape = [abs(v) for v, s in zip(at.shape, model.shapes, strict=True) if not s.shape.choices]
    return np.array([*linear, *shape], dtype=float)
