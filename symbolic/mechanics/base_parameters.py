"""Base parameters of a planar tree, by rank: which inertial quantities a motion shows, and what hides in which.

The torque is linear in every link's inertia J about its joint, first moment X and mass m. At random states the columns
are taken one by one; one that depends on earlier ones is no parameter of its own, and its combination says what the
others contain of it. Source: Gautier, Numerical calculation of the base inertial parameters of robots, Journal of
Robotic Systems 8(4), 1991.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from exoid.symbolic.joints import Joint
from exoid.symbolic.mechanics.newton_euler import PARAMETERS, STILL, BaseMotion, link_torques
from exoid.symbolic.motion import Float

SEED = 20262
STATES = 40
RANK = 1e-9
"""Relative remainder below which a column depends on others; true dependences leave 1e-15."""
UNITS = {"J": "kg·m²", "X": "kg·m", "m": "kg"}


@dataclass(frozen=True)
class BaseParameter:
    """What a motion shows of quantity `kind` of link `link`: itself and `parts`, {(link, kind): factor}."""

    link: int
    kind: str
    parts: tuple[tuple[int, str, float], ...]

    @property
    def unit(self) -> str:
        """Its unit."""
        return UNITS[self.kind]

    @property
    def positive(self) -> bool:
        """Whether it is a sum of masses and inertias with positive factors."""
        return self.kind != "X" and all(kind != "X" and factor > 0.0 for _, kind, factor in self.parts)

    def formula(self, joints: Sequence[Joint]) -> str:
        """Return it in words of the links: "J_hip + 0.1764 m_knee"."""
        text = f"{self.kind}_{joints[self.link].name}"
        for link, kind, factor in self.parts:
            size = "" if abs(factor) == 1.0 else f"{abs(factor):.6g} "
            text += f" {'-' if factor < 0 else '+'} {size}{kind}_{joints[link].name}"
        return text


@lru_cache(maxsize=64)
def base_parameters(joints: tuple[Joint, ...], gravity: float, moving: bool = False) -> tuple[BaseParameter, ...]:
    """Return the base parameters (P,) of a machine: link by link, inertia before first moment before mass.

    A base that is `moving` turns and is accelerated, and may show more of them.
    """
    columns = _columns(joints, gravity, moving)
    order = [(link, kind) for kind in PARAMETERS for link in range(len(joints))]
    chosen: list[tuple[int, str]] = []
    parts: dict[tuple[int, str], list[tuple[int, str, float]]] = {}
    for link, kind in order:
        column = columns[link][kind]
        size = float(np.linalg.norm(column))
        if size <= RANK:
            continue
        known = np.column_stack([columns[a][b] for a, b in chosen]) if chosen else np.zeros((len(column), 0))
        solution = np.linalg.lstsq(known, column, rcond=None)[0] if chosen else np.zeros(0)
        if np.linalg.norm(known @ solution - column) > RANK * size:
            chosen.append((link, kind))
            parts[link, kind] = []
            continue
        for place, factor in zip(chosen, solution, strict=True):
            if abs(factor) > 1e-9:
                parts[place].append((link, kind, round(float(factor), 12)))
    ordered = sorted(chosen, key=lambda place: (place[0], PARAMETERS.index(place[1])))
    return tuple(BaseParameter(link, kind, tuple(parts[link, kind])) for link, kind in ordered)


def tree_mixture(joints: tuple[Joint, ...], gravity: float, moving: bool = False) -> Float:
    """Return A (P, J, 3): base parameters from (J, X, m) of every link, about its upper joint."""
    found = base_parameters(joints, gravity, moving)
    rows = np.zeros((len(found), len(joints), len(PARAMETERS)))
    for row, parameter in zip(rows, found, strict=True):
        for link, kind, factor in ((parameter.link, parameter.kind, 1.0), *parameter.parts):
            row[link, PARAMETERS.index(kind)] += factor
    return rows


def leg_mixture(thigh: float) -> Float:
    """Return the same (4, 2, 3) for Φ1..Φ4 of a leg whose thigh is `thigh` m long, as `regressor.py` derives them."""
    return np.array([
        [[1.0, 0.0, 0.0], [1.0, 0.0, thigh**2]],
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        [[0.0, 0.0, 0.0], [0.0, thigh, 0.0]],
        [[-1.0, thigh, 0.0], [0.0, 0.0, 0.0]],
    ])


def _columns(joints: tuple[Joint, ...], gravity: float, moving: bool) -> list[dict[str, Any]]:
    rng = np.random.default_rng(SEED)
    q, dq, ddq = rng.normal(size=(3, len(joints), STATES))
    base = BaseMotion(*rng.normal(size=(5, STATES))) if moving else STILL
    found = link_torques(joints, gravity, q, dq, ddq, np, base)
    still = np.zeros(STATES)
    return [{kind: np.concatenate([still + torque for torque in row]) for kind, row in one.items()} for one in found]
