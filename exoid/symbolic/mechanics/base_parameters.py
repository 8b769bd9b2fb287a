"""Base parameters of a tree of links, by rank: which inertial quantities a motion shows, and what hides in which.

The torque is linear in every link's inertia J about its joint, first moment X and mass m; in space in its ten inertial
parameters (`spatial.py`). At random states the columns are taken one by one; one that depends on earlier ones is no
parameter of its own, and its combination says what the others contain of it. In space an inertia about a joint's own
axis comes before those across it, and these before masses: what is left bears the names of Khalil and Gautier, "XX_2 -
YY_2". Source: Gautier, Numerical calculation of the base inertial parameters of robots, Journal of
Robotic Systems 8(4), 1991.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from exoid.symbolic.joints import Joint, Vector, is_spatial
from exoid.symbolic.mechanics.newton_euler import PARAMETERS, STILL, BaseMotion, link_torques
from exoid.symbolic.mechanics.spatial import AT, KINDS, MOMENTS, link_columns
from exoid.symbolic.motion import Float

Gravity = float | Vector
"""m/s² downwards of a planar machine, (3,) in the frame of the base of a spatial one, where a number pulls along -z."""

SEED = 20262
STATES = 40
RANK = 1e-9
"""Relative remainder below which a column depends on others; true dependences leave 1e-15."""
UNITS = {"J": "kg·m²", "X": "kg·m", "m": "kg", "M": "kg"} | dict.fromkeys(AT, "kg·m²") | dict.fromkeys(MOMENTS, "kg·m")
ALWAYS = frozenset(("J", "m", "M", "XX", "YY", "ZZ"))
"""Quantities that no body has below zero."""


@dataclass(frozen=True)
class BaseParameter:
    """The part of quantity `kind` of link `link` that a motion shows: itself and `parts`, {(link, kind): factor}."""

    link: int
    kind: str
    parts: tuple[tuple[int, str, float], ...]

    @property
    def unit(self) -> str:
        """Its unit."""
        return UNITS[self.kind]

    @property
    def positive(self) -> bool:
        """True if it is a sum of masses and inertias with positive factors."""
        return self.kind in ALWAYS and all(kind in ALWAYS and factor > 0.0 for _, kind, factor in self.parts)

    def formula(self, joints: Sequence[Joint]) -> str:
        """Return it in words of the links: "J_hip + 0.1764 m_knee"."""
        text = f"{self.kind}_{joints[self.link].name}"
        for link, kind, factor in self.parts:
            size = "" if abs(factor) == 1.0 else f"{abs(factor):.6g} "
            text += f" {'-' if factor < 0 else '+'} {size}{kind}_{joints[link].name}"
        return text


def kinds_of(joints: Sequence[Joint]) -> tuple[str, ...]:
    """Return the inertial quantities of every link of a machine: (J, X, m) in a plane, ten in space."""
    return KINDS if is_spatial(joints) else PARAMETERS


def pull_of(gravity: Gravity) -> Vector:
    """Return gravity as a vector (3,) in the frame of the base."""
    return gravity if isinstance(gravity, tuple) else (0.0, 0.0, -gravity if gravity else 0.0)


@lru_cache(maxsize=64)
def base_parameters(joints: tuple[Joint, ...], gravity: Gravity, moving: bool = False) -> tuple[BaseParameter, ...]:
    """Return the base parameters (P,) of a machine: link by link, inertia before first moment before mass.

    A base that is `moving` turns and is accelerated, and may show more of them.
    """
    kinds, columns = kinds_of(joints), _columns(joints, gravity, moving)
    chosen: list[tuple[int, str]] = []
    hidden: list[tuple[int, str]] = []
    basis = np.zeros((0, len(joints) * STATES))
    for place in _order(joints):
        column = columns[place]
        size = float(np.linalg.norm(column))
        if size <= RANK:
            continue
        rest = column / size
        for _ in range(2):  # once leaves rounding in what is nearly dependent
            rest = rest - basis.T @ (basis @ rest)
        remainder = float(np.linalg.norm(rest))
        if remainder <= RANK:
            hidden.append(place)
            continue
        chosen.append(place)
        basis = np.vstack([basis, rest / remainder])
    parts: dict[tuple[int, str], list[tuple[int, str, float]]] = {place: [] for place in chosen}
    if hidden:
        known, other = (np.column_stack([columns[place] for place in some]) for some in (chosen, hidden))
        for (link, kind), factors in zip(hidden, np.linalg.lstsq(known, other, rcond=None)[0].T, strict=True):
            for place, factor in zip(chosen, factors, strict=True):
                if abs(factor) > 1e-9:
                    parts[place].append((link, kind, round(float(factor), 12)))
    ordered = sorted(chosen, key=lambda place: (place[0], kinds.index(place[1])))
    return tuple(BaseParameter(link, kind, tuple(parts[link, kind])) for link, kind in ordered)


def tree_mixture(joints: tuple[Joint, ...], gravity: Gravity, moving: bool = False) -> Float:
    """Return A (P, J, K): base parameters from the quantities of every link (`kinds_of`), about its upper joint."""
    found, kinds = base_parameters(joints, gravity, moving), kinds_of(joints)
    rows = np.zeros((len(found), len(joints), len(kinds)))
    for row, parameter in zip(rows, found, strict=True):
        for link, kind, factor in ((parameter.link, parameter.kind, 1.0), *parameter.parts):
            row[link, kinds.index(kind)] += factor
    return rows


@lru_cache(maxsize=64)
def absorbed_rotors(joints: tuple[Joint, ...]) -> tuple[bool, ...]:
    """Return of which joints (J,) of a spatial machine the inertia of the drive is no number of its own: the links'
    base parameters contain it.
    """
    _, _, ddq = _states(joints)
    pull = pull_of(1.0)
    columns = _columns(joints, pull, False)
    known = [columns[p.link, p.kind] for p in base_parameters(joints, pull)]
    found = []
    for k in range(len(joints)):
        own = np.zeros(ddq.shape)
        own[k] = ddq[k]
        column = own.ravel()
        rest = column
        if known:
            matrix = np.column_stack(known)
            rest = column - matrix @ np.linalg.lstsq(matrix, column, rcond=None)[0]
        found.append(bool(np.linalg.norm(rest) <= RANK * np.linalg.norm(column)))
    return tuple(found)


def leg_mixture(thigh: float) -> Float:
    """Return the same (4, 2, 3) for Φ1..Φ4 of a leg whose thigh is `thigh` m long, as `regressor.py` derives them."""
    return np.array([
        [[1.0, 0.0, 0.0], [1.0, 0.0, thigh**2]],
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        [[0.0, 0.0, 0.0], [0.0, thigh, 0.0]],
        [[-1.0, thigh, 0.0], [0.0, 0.0, 0.0]],
    ])


def _order(joints: Sequence[Joint]) -> list[tuple[int, str]]:
    """Return all (link, kind) in the order in which they are taken."""
    if not is_spatial(joints):
        return [(link, kind) for kind in PARAMETERS for link in range(len(joints))]
    ranked = []
    for joint in joints:
        along = int(np.argmax(np.abs(joint.axis or (0.0, 0.0, 1.0))))
        inertias = [f"{letter}{letter}" for letter in "XYZ"]
        own, (first, last) = inertias.pop(along), inertias
        moments = [kind for k, kind in enumerate(MOMENTS) if k != along]
        mixed = [kind for kind in AT if kind not in (own, first, last)]
        ranked.append([own, first, *mixed, last, *moments, MOMENTS[along], "M"])
    return [(link, kinds[rank]) for rank in range(len(KINDS)) for link, kinds in enumerate(ranked)]


def _states(joints: Sequence[Joint]) -> Float:
    """Return random angles, velocities and accelerations (3, J, STATES)."""
    return np.asarray(np.random.default_rng(SEED).normal(size=(3, len(joints), STATES)))


def _columns(joints: tuple[Joint, ...], gravity: Gravity, moving: bool) -> dict[tuple[int, str], Float]:
    """Return the torques of all joints at random states, one behind the other, per unit of each (link, kind)."""
    still = np.zeros(STATES)
    if is_spatial(joints):
        wanted = [(link, kind) for link in range(len(joints)) for kind in KINDS]
        q, dq, ddq = _states(joints)
        swaying = [*np.random.default_rng(SEED + 1).normal(size=(12, STATES))] if moving else []
        rows = link_columns(joints, pull_of(gravity), [*q], [*dq], [*ddq], np, wanted, swaying)
        return {
            place: np.concatenate([still + torque for torque in row]) for place, row in zip(wanted, rows, strict=True)
        }
    rng = np.random.default_rng(SEED)
    q, dq, ddq = rng.normal(size=(3, len(joints), STATES))
    base = BaseMotion(*rng.normal(size=(5, STATES))) if moving else STILL
    found = link_torques(joints, float(gravity), q, dq, ddq, np, base)  # type: ignore[arg-type]
    return {
        (link, kind): np.concatenate([still + torque for torque in row])
        for link, item in enumerate(found)
        for kind, row in item.items()
    }
