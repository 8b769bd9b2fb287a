"""Bodies of a spatial machine that have given base parameters: one choice of the many, or none.

As of the links of a planar one (`links.py`), with the pseudo-inertia (4, 4) of every link about its joint

    P = [[½ tr(I) 1 - I, h], [hᵀ, m]]

of its inertia I, first moment h and mass m, which is positive definite where there can be such a body (Wensing, Kim,
Slotine, IEEE Robotics and Automation Letters 3(1), 2018).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exoid.optimisation.linear.interior import nearest_inside
from exoid.optimisation.linear.links import EXACT, nearest_matrices
from exoid.symbolic.joints import HERE
from exoid.symbolic.mechanics.spatial import AT, KINDS, MOMENTS, about_joint
from exoid.symbolic.mechanics.spatial_energy import pseudo_inertia
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

USUAL = 0.15
"""m that links measure where nothing says how long they are."""
SHARES = (1.0, 0.1, 10.0)
"""How heavy bodies are from which those at the edge of what is possible are looked for, of the known ones."""
THICK = 0.4
"""Radius of gyration of a usual body about each axis, of its length."""


@dataclass(frozen=True, eq=False)
class Body3D:
    """A rigid body in its joint's frame: `mass` kg, `centre` (3,) m of that, and `inertia` (3, 3) kg·m² about it."""

    mass: float
    centre: Float
    inertia: Float

    @property
    def numbers(self) -> Float:
        """Its ten parameters about the joint (10,), in the order of `spatial.KINDS`."""
        return np.array([*about_joint(self.mass, self.centre, self.inertia).values()])


def body_of(numbers: Float) -> Body3D:
    """Return the body with ten parameters about its joint (10,)."""
    at = dict(zip(KINDS, (float(value) for value in numbers), strict=True))
    tensor = np.zeros((3, 3))
    for kind, (i, j) in AT.items():
        tensor[i, j] = tensor[j, i] = at[kind]
    mass = at["M"]
    c = np.array([at[kind] for kind in MOMENTS]) / mass
    return Body3D(mass, c, tensor - mass * (c @ c * np.eye(3) - np.outer(c, c)))


def nearest_bodies(
    model: Model, phi: Float, near: Sequence[Body3D] | None = None, *, patient: bool = False
) -> tuple[Body3D, ...] | None:
    """Return bodies (J,) of a spatial `model` that have the base parameters `phi` (P,), nearest to `near` (default:
    usual ones); None where no bodies of positive mass have them.

    `patient` finds, within seconds, also those that have hardly any room, as at the edge of what is possible.
    """
    rows = model.mixture.reshape(len(model.inertial), -1)
    known = _usual(model, phi) if near is None else tuple(near)
    # In units of the known bodies all numbers are near one.
    before = np.array([pseudo_inertia(dict(zip(KINDS, item.numbers, strict=True))) for item in known])
    unit = np.sqrt(np.einsum("kii->ki", before))
    scale = unit[:, :, None] * unit[:, None, :]
    weights = np.einsum("pkn,nij->pkij", model.mixture, _WEIGHTS) * scale
    size = np.maximum(np.abs(weights).max(axis=(1, 2, 3)), np.abs(phi))
    start, weights, values = before / scale, weights / size[:, None, None, None], phi / size
    nearest = nearest_matrices(start, weights, values)
    found = None if nearest is None else _exactly(rows, nearest.real, scale, phi)
    for share in SHARES if patient and found is None else ():
        found = _exactly(rows, nearest_inside(share * start, weights, values), scale, phi)
        if found is not None:
            break
    return found


def _exactly(rows: Float, found: Float, scale: Float, phi: Float) -> tuple[Body3D, ...] | None:
    """Return bodies (J,) with the pseudo-inertias `found` times `scale` (J, 4, 4) and exactly the base parameters `phi`
    (P,), which are `rows` (P, 10 J) times their numbers; None where rounding left too much.
    """
    numbers = np.einsum("kij,nij->kn", found * scale, _WEIGHTS)
    units = np.maximum(np.abs(np.einsum("kij,nij->kn", scale, np.abs(_WEIGHTS))), 1e-300)
    wide = rows * units.ravel()
    numbers = numbers - (units.ravel() * (np.linalg.pinv(wide) @ (rows @ numbers.ravel() - phi))).reshape(-1, 10)
    flat = numbers.ravel()
    wrong = np.abs(rows @ flat - phi) > EXACT * np.maximum(np.abs(rows) @ np.abs(flat), np.abs(phi))
    possible = [np.linalg.eigvalsh(pseudo_inertia(dict(zip(KINDS, item, strict=True))))[0] > 0.0 for item in numbers]
    return None if wrong.any() or not all(possible) else tuple(body_of(number) for number in numbers)


def _usual(model: Model, phi: Float) -> tuple[Body3D, ...]:
    """Return round bodies as long as the way to the next joint, as heavy as the base parameters suggest."""
    power = {"kg": 0, "kg·m": 1, "kg·m²": 2}
    length = gyration(model) / THICK
    sizes = [abs(value) / length ** power[p.unit] for value, p in zip(phi, model.inertial, strict=True)]
    mass = max(sizes, default=1.0) or 1.0
    body = Body3D(mass, np.zeros(3), mass * gyration(model) ** 2 * np.eye(3))
    return (body,) * len(model.joints)


def gyration(model: Model) -> float:
    """Return the radius of gyration, m, of a usual link of a spatial machine about each of its axes."""
    long = [float(np.linalg.norm((joint.origin or HERE).xyz)) for joint in model.joints[1:]]
    return THICK * (max(USUAL, float(np.mean(long))) if long else USUAL)


def _weights() -> Float:
    """Return W (10, 4, 4): each parameter of a body is the sum of W times its pseudo-inertia, entry by entry."""
    found = np.zeros((len(KINDS), 4, 4))
    for row, kind in zip(found, KINDS, strict=True):
        if kind in AT and AT[kind][0] == AT[kind][1]:
            row[:3, :3] = np.diag([float(k != AT[kind][0]) for k in range(3)])
        elif kind in AT:
            i, j = AT[kind]
            row[i, j] = row[j, i] = -0.5
        elif kind in MOMENTS:
            k = MOMENTS.index(kind)
            row[k, 3] = row[3, k] = 0.5
        else:
            row[3, 3] = 1.0
    return found


_WEIGHTS = _weights()
