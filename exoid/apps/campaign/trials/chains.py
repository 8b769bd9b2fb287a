"""Machines of blind trials that are not the leg, drawn at random: drives on a bench, and a leg with an ankle.

drive      one joint that turns, its link hanging from it
slide      one joint that slides in a horizontal plane
chain      hip, knee and ankle
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.model_structure import Limits


def _vary(rng: np.random.Generator, *values: float) -> tuple[float, ...]:
    return tuple(float(value) * float(rng.uniform(0.8, 1.2)) for value in values)


def _drive(rng: np.random.Generator) -> Model:
    reach, velocity, acceleration = _vary(rng, 1.0, 2.0, 6.0)
    limits = {"axis": Limits((-reach, reach), velocity, acceleration)}
    return Model("drive on a bench", limits=limits, joints=(Joint("axis"),))


def _slide(rng: np.random.Generator) -> Model:
    reach, velocity, acceleration = _vary(rng, 0.12, 0.25, 1.0)
    limits = {"axis": Limits((-reach, reach), velocity, acceleration)}
    return Model("sliding drive", gravity=0.0, limits=limits, joints=(Joint("axis", "prismatic"),))


def _chain(rng: np.random.Generator) -> Model:
    thigh, shank = _vary(rng, 0.42, 0.40)
    usual = {"hip": (-0.3, 1.2, 1.9, 5.0), "knee": (-1.6, -0.2, 1.7, 5.0), "ankle": (-0.5, 0.6, 2.5, 8.0)}
    limits = {
        name: Limits((low, high), *_vary(rng, velocity, acceleration))
        for name, (low, high, velocity, acceleration) in usual.items()
    }
    joints = (Joint("hip", length=round(thigh, 3)), Joint("knee", length=round(shank, 3)), Joint("ankle"))
    return Model("leg with ankle", limits=limits, joints=joints)


CHAINS: Mapping[str, Callable[[np.random.Generator], Model]] = MappingProxyType(
    {"drive": _drive, "slide": _slide, "chain": _chain}
)
"""Kind of trial -> how its machine is drawn."""
