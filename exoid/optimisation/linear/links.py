"""Masses, centres of mass and inertias of links that have given base parameters: one choice of the many, or none.

Base parameters do not fix the links. Wanted are those with positive pseudo-inertia (Wensing, Kim, Slotine, IEEE
Robotics and Automation Letters 3(1), 2018), here of a planar body, and among them those nearest to known ones P₀:

    minimise  Σ_k  tr(P₀ₖ⁻¹ Pₖ) - log det Pₖ      subject to  A (J, X, m) = Φ

the Bregman divergence of log det (Lee, Wensing, Park, IEEE Transactions on Robotics 36(1), 2020). It is convex, so
there is one answer, and none where no links have these numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

EXACT = 1e-10
"""Relative error of the base parameters that is allowed in the links found."""
STEPS = 200
"""Steps of Newton's method; a few tens are usual, hundreds mean that no links have the numbers."""
TINY = 1e-100
"""Least eigenvalue of a matrix that can be inverted."""
SETTLED = 1e-14
"""What a further step of it would gain at the optimum."""


Matrices = NDArray[np.complex128] | Float


@dataclass(frozen=True)
class LinkInertia:
    """A link: `inertia` about its joint kg·m², first moments `along` its axis and `across` it kg·m, `mass` kg."""

    inertia: float
    along: float
    across: float
    mass: float

    @property
    def centre(self) -> tuple[float, float]:
        """Its centre of mass along and across the axis, m."""
        return self.along / self.mass, self.across / self.mass

    @property
    def about_centre(self) -> float:
        """Its inertia about the centre of mass, kg·m²."""
        return self.inertia - (self.along**2 + self.across**2) / self.mass


def tree_of(model: Model) -> tuple[Joint, ...]:
    """Return the joints of a model, the leg's with the length of its thigh."""
    if model.chain:
        return model.chain
    hip, knee = model.joints
    return Joint(hip.name, length=model.thigh_length), knee


def usual_links(model: Model, phi: Float) -> tuple[LinkInertia, ...]:
    """Return rods as heavy as the base parameters `phi` (P,) suggest: what links are like where nobody knows better."""
    lengths = [joint.length or 0.3 for joint in tree_of(model)]
    mean = float(np.mean(lengths))
    power = {"kg": 0, "kg·m": 1, "kg·m²": 2}
    sizes = [abs(value) / mean ** power[p.unit] for value, p in zip(phi, model.inertial, strict=True)]
    mass = max(sizes, default=1.0) or 1.0
    return tuple(LinkInertia(mass * a**2 / 3.0, mass * a / 2.0, 0.0, mass) for a in lengths)


def nearest_links(
    model: Model, phi: Float, across: Float | None = None, near: Sequence[LinkInertia] | None = None
) -> tuple[LinkInertia, ...] | None:
    """Return links that have the base parameters `phi` (P,) and the moments `across` their axes (J,), nearest to `near`
    (default: usual ones); None where no links with positive masses have them.
    """
    count = len(model.joints)
    rows = model.mixture.reshape(-1, 3 * count)
    aside = np.zeros(count) if across is None else np.asarray(across, dtype=float)
    known = usual_links(model, phi) if near is None else tuple(near)
    # In units of the known links, first moments in those of sqrt(J m): then all numbers are near one.
    unit = np.array([[item.inertia, np.sqrt(item.inertia * item.mass), item.mass] for item in known])
    scaled = rows * unit.ravel()
    size = np.maximum(np.abs(scaled).max(axis=1), np.abs(phi))
    before = np.array(
        [_hermitian(1.0, entry.along / u[1], entry.across / u[1], 1.0) for entry, u in zip(known, unit, strict=True)]
    )
    weights = [
        [_hermitian(j, 0.5 * x, 0.0, m) for j, x, m in row] for row in (scaled / size[:, None]).reshape(-1, count, 3)
    ]
    beside = [[_hermitian(0.0, 0.0, 0.5 * float(k == i), 0.0) for i in range(count)] for k in range(count)]
    bodies = nearest_matrices(before, np.array([*weights, *beside]), np.append(phi / size, aside / unit[:, 1]))
    if bodies is None:
        return None
    found = (np.column_stack([bodies[:, 0, 0].real, bodies[:, 0, 1].real, bodies[:, 1, 1].real]) * unit).ravel()
    found = found - unit.ravel() * (np.linalg.pinv(scaled) @ (rows @ found - phi))
    links = tuple(
        LinkInertia(float(j), float(x), float(y), float(m))
        for (j, x, m), y in zip(found.reshape(count, 3), aside, strict=True)
    )
    wrong = np.abs(rows @ found - phi) > EXACT * np.maximum(np.abs(rows) @ np.abs(found), np.abs(phi))
    if wrong.any() or not all(link.mass > 0.0 and link.about_centre > 0.0 for link in links):
        return None
    return links


def _hermitian(inertia: float, along: float, across: float, mass: float) -> NDArray[np.complex128]:
    """Return [[J, X + iY], [X - iY, m]], which is positive definite just where such a link can be."""
    return np.array([[inertia, along + 1j * across], [along - 1j * across, mass]])


@np.errstate(over="ignore", invalid="ignore")
def nearest_matrices(
    before: Matrices, weights: Matrices, values: Float
) -> NDArray[np.complex128] | None:
    """Return the Hermitian matrices P (J, n, n) nearest to `before` for which Σ_k tr(W_pk P_k) are `values` (P,); None
    for none.

    Newton's method on the dual problem, max Σ log det S_k + ν·values with S = P₀⁻¹ - Σ_p ν_p W_p and P = S⁻¹. It has
    no conditions but that S is positive definite, which it is at ν = 0, and is unbounded where there is no P.
    """
    start, multipliers = np.linalg.inv(before), np.zeros(len(values))

    def worth(nu: Float) -> tuple[float, Matrices]:
        s = start - np.einsum("p,pkij->kij", nu, weights)
        if not np.isfinite(s).all():
            return -np.inf, s
        sizes = np.linalg.eigvalsh(s)
        if not sizes.min() > TINY:
            return -np.inf, s
        return float(np.log(sizes).sum() + nu @ values), s

    best, s = worth(multipliers)
    for _ in range(STEPS):
        try:
            bodies: NDArray[np.complex128] = np.asarray(np.linalg.inv(s), dtype=np.complex128)
        except np.linalg.LinAlgError:
            return None
        pushed = np.einsum("kab,pkbc->pkac", bodies, weights)
        slope = values - np.einsum("pkaa->p", pushed).real
        curvature = np.einsum("pkab,qkba->pq", pushed, pushed).real
        step = np.linalg.lstsq(curvature, slope, rcond=1e-14)[0]
        gain = float(slope @ step)
        if not np.isfinite(gain):  # the multipliers run away: there is no P
            return None
        if gain < SETTLED:
            return bodies
        length = 1.0
        while length > 1e-12:
            value, tried = worth(multipliers + length * step)
            if value >= best + 0.1 * length * gain:
                break
            length *= 0.5
        else:
            return bodies
        multipliers, best, s = multipliers + length * step, value, tried
    return None
