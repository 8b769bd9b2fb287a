"""The least loss inside matrix inequalities and bounds, along the path of barriers (Nesterov, Nemirovskii, 1994).

    minimise  loss(BΦ) / size + μ [ Σ tr(P₀⁻¹ F) - log det F - ... - Σ log(distance to a bound) ],   μ → 0

The loss is convex and so is the rest: there is one minimum for every μ, and at the end the loss is within μ times the
number of conditions of the best. Where the data do not determine a direction the bracket alone does: of all numbers
with the same torque it takes those nearest to P₀, in the divergence of `links.py`. Newton's steps have the curvature of
primal and dual numbers together (Nesterov, Todd, SIAM Journal on Optimization 8(2), 1998), which long ways along a
condition need.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from exoid.optimisation.linear.inequality import Inequality
from exoid.optimisation.linear.loss import huber
from exoid.optimisation.linear.problem import LinearData
from exoid.symbolic.motion import Float

GAP = 1e-11
"""Relative to the least loss, what is left when it ends."""
PERFECT = 1e-12
"""Loss relative to that of no model at all, below which there is nothing to fit."""
STEPS = 1000
"""Steps of Newton's method in all; a hundred are usual, several where links all but vanish."""
ENDED, SHORTER, BARELY = 1e-10, 0.1, 0.5
"""What a step would gain, in units of μ, where it ends; how much shorter μ becomes, and how much where the step before
was less than half."""
BENT = 1e-2
"""μ, of that with which it begins, from which on the loss is Huber's; before, it is the sum of squares."""
APART = 1e-4
"""Least product of a distance and its multiplier, of that on the path: below, it is rounding."""
SHARE = 0.99
"""Of the way to the nearest condition, the farthest step."""


@dataclass(frozen=True, eq=False)
class Region:
    """Region in which a minimum is looked for: bounds `low` and `high` (Q,), `inequalities`, and the middle of it.

    `towards` (Q,) is the slope that draws numbers to those that are usual, `weak` (Q,) a curvature towards `start`
    (Q,), which fulfils all strictly.
    """

    low: Float
    high: Float
    inequalities: Sequence[Inequality]
    start: Float
    towards: Float
    weak: Float

    @cached_property
    def lines(self) -> tuple[Float, Float]:
        """Rows (C, Q) and constants (C,) of all conditions on one number: rows x + constants > 0."""
        eye = np.eye(self.low.size)
        below, above = np.isfinite(self.low), np.isfinite(self.high)
        limited = [inequality for inequality in self.inequalities if np.isfinite(inequality.most)]
        traces = [-np.einsum("iiq->q", limit.entries)[None] for limit in limited]
        ends = [-self.low[below], self.high[above], np.array([item.most for item in limited])]
        return np.concatenate([eye[below], -eye[above], *traces]), np.concatenate(ends)

    @property
    def count(self) -> int:
        """Number of conditions."""
        return len(self.lines[1]) + sum(inequality.size for inequality in self.inequalities)

    def slope(self, x: Float) -> Float:
        """Return the slope (Q,) of the bracket at `x`."""
        rows, ends = self.lines
        found = self.towards + self.weak * (x - self.start) - rows.T @ (1.0 / (rows @ x + ends))
        for inequality in self.inequalities:
            found = found - np.einsum("ij,ijq->q", np.linalg.inv(inequality.matrix(x)), inequality.entries)
        return np.asarray(found)

    def rates(self, x: Float, step: Float) -> Float:
        """Return by which share of itself each distance to a condition grows along `step` from `x`."""
        rows, ends = self.lines
        found: list[Float] = [rows @ step / (rows @ x + ends)]
        for inequality in self.inequalities:
            root = np.linalg.inv(np.linalg.cholesky(inequality.matrix(x)))
            found.append(np.asarray(np.linalg.eigvalsh(root @ (inequality.entries @ step) @ root.T)))
        return np.concatenate(found)


class _Duals:
    """The multipliers of a region's conditions, in units of μ, kept positive."""

    def __init__(self, region: Region) -> None:
        rows, ends = region.lines
        self.region = region
        self.lines = 1.0 / (rows @ region.start + ends)
        self.matrices = [np.linalg.inv(inequality.matrix(region.start)) for inequality in region.inequalities]

    def curvature(self, x: Float) -> Float:
        """Return rows (.., Q) whose products with each other are the curvature at `x`."""
        rows, ends = self.region.lines
        found = [np.diag(np.sqrt(self.region.weak)), np.sqrt(self.lines / (rows @ x + ends))[:, None] * rows]
        self._scalings = []
        for inequality, dual in zip(self.region.inequalities, self.matrices, strict=True):
            primal = np.linalg.cholesky(inequality.matrix(x))
            back = np.linalg.inv(primal)
            # Together they are near one, where each alone is too close to singular to be factorised.
            size, axes = np.linalg.eigh(primal.T @ dual @ primal)
            size = np.maximum(size, APART)
            root = np.sqrt(np.sqrt(size))[:, None] * (axes.T @ back)
            self._scalings.append((root.T @ root, primal @ axes / np.sqrt(size)))
            found.append(np.einsum("ai,ijq,bj->abq", root, inequality.entries, root).reshape(-1, x.size))
        return np.concatenate(found)

    def move(self, x: Float, step: Float) -> float:
        """Go with Newton's `step` from `x`, together with x as far as all stay positive; return how far."""
        rows, ends = self.region.lines
        room = rows @ x + ends
        lines = 1.0 / room - self.lines - self.lines / room * (rows @ step)
        length, changes = min(_most(self.region.rates(x, step)), _most(lines / self.lines)), []
        for item, dual, (scaling, root) in zip(self.region.inequalities, self.matrices, self._scalings, strict=True):
            changes.append(np.linalg.inv(item.matrix(x)) - dual - scaling @ (item.entries @ step) @ scaling)
            length = min(length, _most(np.linalg.eigvalsh(root.T @ changes[-1] @ root)))
        self.lines = self.lines + length * lines
        moved = [dual + length * change for dual, change in zip(self.matrices, changes, strict=True)]
        self.matrices = [0.5 * (entry + entry.T) for entry in moved]
        return length

    def product(self, x: Float) -> float:
        """Return the mean of distances to conditions times multipliers, which is 1 on the path."""
        rows, ends = self.region.lines
        total = float(self.lines @ (rows @ x + ends))
        for inequality, dual in zip(self.region.inequalities, self.matrices, strict=True):
            total += float(np.sum(dual * inequality.matrix(x)))
        return total / self.region.count

    def shorten(self, factor: float) -> None:
        """Take μ to be `factor` of what it was: the multipliers stay what they are."""
        self.lines = self.lines / factor
        self.matrices = [dual / factor for dual in self.matrices]


def _most(rates: Float) -> float:
    """Longest step, 1 at most, after which values that change by these shares of themselves stay positive."""
    return min(1.0, SHARE / max(1e-9, float(-rates.min(initial=0.0))))


def least_loss(data: LinearData, delta: Float, lead: Float, region: Region) -> Float:
    """Return the numbers (Q,) in `region` of which the parameters `lead` (P, Q) times them have the least loss.

    `delta` (J,) are the thresholds of the Huber loss; infinite ones give SSE.
    """
    last = np.repeat(np.asarray(delta, dtype=float), data.tau.shape[1])
    basis, size = data.factor.basis, huber(data.tau, delta) or 1.0
    forward = data.factor.forward @ lead
    x, duals = region.start.copy(), _Duals(region)
    residual = data.vector - basis @ (forward @ x)
    mu = np.inf
    for _ in range(STEPS):
        share = max(huber(residual.reshape(data.tau.shape), delta) / size, PERFECT) / region.count
        end, mu = GAP * share, min(mu, share)
        # Far from the best fit few samples are within their thresholds, and say nothing about the others.
        limit = last if mu <= BENT * share else np.full(last.size, np.inf)
        try:
            pulled, curved = region.slope(x), duals.curvature(x)
        except np.linalg.LinAlgError:  # as near to a condition as rounding lets it come
            break
        slope = -2.0 / size * (basis.T @ np.clip(residual, -limit, limit))
        outer = basis[np.abs(residual) > limit]
        step = _newton(forward, slope, (2.0 / size) * (np.eye(basis.shape[1]) - outer.T @ outer), pulled, curved, mu)
        gain = -float(slope @ (forward @ step) + mu * (pulled @ step)) / mu
        if mu <= end and gain <= ENDED and limit is last:
            break
        length = duals.move(x, step)
        x, residual = x + length * step, residual - length * (basis @ (forward @ step))
        if mu > end:
            target = max(end, min(mu, mu * duals.product(x) * (SHORTER if length > 0.5 else BARELY)))
            duals.shorten(target / mu)
            mu = target
    return x


def _newton(forward: Float, slope: Float, curvature: Float, pulled: Float, curved: Float, mu: float) -> Float:
    """Return Newton's step (Q,) for a loss with `slope` (r,) and `curvature` (r, r) in what the data determine, and μ
    times a bracket with the slope `pulled` (Q,) and the curvature that products of the rows `curved` (.., Q) are.

    The two kinds of directions, that the data determine or not, are solved apart: their curvatures are as far from each
    other as 1 and μ.
    """
    root = np.linalg.inv(np.linalg.qr(curved, mode="r")).T
    left, scale, right = np.linalg.svd(forward @ root.T, full_matrices=True)
    seen = int(np.sum(scale > 1e-13 * scale.max(initial=0.0)))
    left, scale = left[:, :seen] * scale[:seen], scale[:seen]
    inner = right @ (root @ pulled)
    matrix = left.T @ curvature @ left + mu * np.eye(seen)
    step = -inner
    step[:seen] = -np.linalg.solve(matrix, left.T @ slope + mu * inner[:seen])
    return np.asarray(root.T @ (right.T @ step))


def nearest_inside(before: Float, weights: Float, values: Float) -> Float:
    """Return the symmetric matrices (J, n, n) nearest to `before` for which Σ_k tr(W_pk P_k) are `values` (P,), as
    `links.nearest_matrices` does, or as near to these values as can be where no positive ones have them.

    A step is dearer than there, and far fewer are needed where all such matrices are nearly singular.
    """
    count, size = before.shape[:2]
    above = np.triu_indices(size)
    basis = np.zeros((size, size, len(above[0])))
    basis[above[0], above[1], np.arange(len(above[0]))] = 1.0
    basis = np.maximum(basis, basis.transpose(1, 0, 2))
    conditions = []
    for k in range(count):
        entries = np.zeros((size, size, count, len(above[0])))
        entries[:, :, k] = basis
        flat = entries.reshape(size, size, -1)
        conditions.append(Inequality(f"{k}", flat, np.zeros(flat.shape[2]), 0.0))
    start = before[:, above[0], above[1]].ravel()
    free = np.full(start.size, np.inf)
    towards = np.einsum("kij,ijq->kq", np.linalg.inv(before), basis).ravel()
    lead = np.einsum("pkij,ijq->pkq", weights, basis).reshape(len(values), -1)
    names = tuple(map(str, range(len(values))))
    data = LinearData(np.eye(len(values))[None], values[None], np.zeros(len(values), dtype=int), names, names)
    found = least_loss(data, np.array([np.inf]), lead, Region(-free, free, conditions, start, towards, 0.0 * start))
    return np.array([condition.entries @ found for condition in conditions])
