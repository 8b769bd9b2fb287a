"""Fits and losses from Gram blocks alone, sums over the samples of a recording, without touching a sample."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from exoid.symbolic.motion import Float

NOTHING = 1e-9
"""Length of a column that is rounding: in deviations of the residual per unit (a sway across a stage moves nothing), or
of the longest of its effect (a spring across a circle about the joint).
"""
ABSORBED = 1e-6
"""Share of a column that is new to the model, up to which the model's own parameters take it over."""
RIDGE = 1e-9
"""Relative ridge of a candidate, for columns that depend on each other: far below what one must have of its own."""
LEAST_SCALE = 0.3
"""Scale of a column for the ridge, of the largest, at least: one that is hardly seen would escape the ridge."""


@dataclass(frozen=True, eq=False)
class Gram:
    """`rows` (U, L + 1 + m, m, D): one below the other sums of products with L columns that span the model's at the
    candidate's joints, a (U, m, D) and h (U, m, m, D) of a candidate in every unit. D are nodes, or placebos, and come
    last: sums along them are what takes the time.

    `lift` (P, L) makes sums with the model's own columns of those with the L; None where they are these.
    """

    rows: Float
    lift: Float | None = None

    @property
    def few(self) -> Float:
        """Sums of products with the columns that span the model's (U, L, m, D)."""
        return self.rows[:, : -1 - self.rows.shape[2]]

    @property
    def g(self) -> Float:
        """Sums of products with the model's columns (U, P, m, D)."""
        if self.lift is None:
            return self.few
        few = self.few
        return (self.lift @ few.reshape(*few.shape[:2], -1)).reshape(len(few), len(self.lift), *few.shape[2:])

    @property
    def a(self) -> Float:
        """Sums of products with the residual (U, m, D)."""
        return self.rows[:, -1 - self.rows.shape[2]]

    @property
    def h(self) -> Float:
        """Sums of products with each other (U, m, m, D)."""
        return self.rows[:, -self.rows.shape[2] :]

    def of(self, units: Float) -> Gram:
        """Return the sums over units, (S, ...) for rows `units` (S, U) that are one where a unit counts."""
        total = units @ self.rows.reshape(len(self.rows), -1)
        return Gram(total.reshape(len(units), *self.rows.shape[1:]), self.lift)

    @classmethod
    def stacked(cls, nodes: Iterable[Gram], many: int) -> Gram:
        """Return the Gram blocks of so many nodes, each with entries (D,), as one with (V, D); one by one, since
        together they are large.
        """
        rows, lift = np.zeros(0), None
        for v, node in enumerate(nodes):
            lift = node.lift
            rows = rows if v else np.empty((*node.rows.shape[:-1], many, node.rows.shape[-1]))
            rows[..., v, :] = node.rows
        return cls(rows, lift)

    def entries(self, *which: Any) -> Gram:
        """Return those of some entries of D, one index for each axis that it has."""
        return Gram(self.rows[..., *which], self.lift)


@dataclass(frozen=True, eq=False)
class Fits:
    """The present model fitted S times: to the `units` (S, U) that are one, with G⁻¹ (S, P, P), the prior included, and
    the step (S, P) of its own numbers.
    """

    units: Float
    inverse: Float
    step: Float

    def candidate(self, grams: Gram, ridge: float = RIDGE) -> tuple[Float, Float, Float]:
        """Return candidate coefficients (S, m, D), the step (S, P, D) refitted with them, and the gain (S, D) on what
        is fitted; `ridge` is relative to the candidate's own Gram matrix.
        """
        return self._candidate(grams.of(self.units), ridge)

    def gain(self, grams: Gram, prior: Float) -> tuple[Float, Float]:
        """Return candidate coefficients (S, m, D), and (S, D) the gain on what is fitted with what the `prior` (P,) on
        the model's own numbers then costs; in the few columns that span the model's, which `grams` have.
        """
        assert grams.lift is not None
        few, lifted = Gram(grams.of(self.units).rows), self.inverse @ grams.lift
        seen = Fits(self.units, grams.lift.T @ lifted, self.step @ grams.lift)
        coefficients, _, gain = seen._candidate(few, RIDGE)
        if (held := np.flatnonzero(prior)).size:
            own = np.einsum("slmd,smd->sld", few.g, coefficients)
            step = self.step[:, held, None] - lifted[:, held] @ own
            gain = gain + np.einsum("p,spd->sd", prior[held], step**2)
        return coefficients, gain

    def _candidate(self, fitted: Gram, ridge: float) -> tuple[Float, Float, Float]:
        g, h = fitted.g, fitted.h
        flat = g.reshape(*g.shape[:2], -1)
        lean = (self.inverse @ flat).reshape(g.shape)  # (S, P, m, D)
        schur = h - np.einsum("spmd,spnd->smnd", lean, g)
        length = np.sqrt(np.maximum(np.einsum("smmd->smd", h), 1e-300))
        longest = length.max(axis=1, keepdims=True)
        # The number of a column that is rounding, or that the model contains, would be of any sign.
        shown = (length > NOTHING * longest) & (np.einsum("smmd->smd", schur) > ABSORBED * length**2)
        # A column that the fitted units hardly show must not escape the ridge by being small.
        scale = np.where(shown, np.maximum(length, LEAST_SCALE * longest), np.inf)
        right = fitted.a - (self.step[:, None] @ flat).reshape(fitted.a.shape)
        normal = schur / (scale[:, :, None] * scale[:, None]) + ridge * np.eye(len(h[0]))[:, :, None]
        coefficients = _solved(normal, right / scale) / scale
        step = self.step[:, :, None] - np.einsum("spmd,smd->spd", lean, coefficients)
        return coefficients, step, np.einsum("smd,smd->sd", coefficients, right)


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Units that were not fitted, each of S times (one in `units`, (S, U)), with G (S, P, P), b (S, P) and c (S,)."""

    units: Float
    gram: Float
    slope: Float
    constant: Float

    def loss(self, step: Float) -> Float:
        """Return the loss (S, D) after steps (S, P, D) of the model's own numbers."""
        linear, square = np.einsum("sp,spd->sd", self.slope, step), np.einsum("spd,spd->sd", self.gram @ step, step)
        return np.asarray(self.constant[:, None] - 2.0 * linear + square)

    def loss_beside(self, grams: Gram, coefficients: Float, step: Float) -> Float:
        """Return the loss (S, D) with a candidate of these coefficients (S, m, D) beside it."""
        held = grams.of(self.units)
        lean = np.einsum("spmd,spd->smd", held.g, step) - held.a
        own = np.einsum("smnd,snd->smd", held.h, coefficients)
        return self.loss(step) + np.einsum("smd,smd->sd", coefficients, 2.0 * lean + own)

    def would_fall(self, fits: Fits, grams: Gram, coefficients: Float) -> Float:
        """Return by how much the loss (S, D) beside `fits` would fall with a candidate of these coefficients (m,) if it
        were there, and noise were not.
        """
        fitted, held = grams.of(fits.units), grams.of(self.units)
        step = np.einsum("spq,sqmd,m->spd", fits.inverse, fitted.g, coefficients)
        lean = np.einsum("spmd,m->spd", held.g, coefficients)
        own = np.einsum("smnd,m,n->sd", held.h, coefficients, coefficients)
        return np.asarray(own - 2.0 * np.sum(step * lean, axis=1) + np.sum(step * (self.gram @ step), axis=1))


@dataclass(frozen=True, eq=False)
class Gain:
    """Gain of a candidate: first entry of axis D is the candidate, the others are placebos.

    `folds` (F, D): fall of the weighted loss on each held-out unit; `unseen` (D,) the same on the verification
    recordings (zeros where there are none); `coefficients` (D, m) fitted on all training units.
    """

    folds: Float
    unseen: Float
    coefficients: Float

    @property
    def total(self) -> Float:
        """Sum over the held-out training units (D,)."""
        return self.folds.sum(axis=0)

    def entry(self, index: int) -> Gain:
        """Return one entry alone."""
        some = slice(index, index + 1)
        return Gain(self.folds[:, some], self.unseen[some], self.coefficients[some])


def _solved(matrices: Float, right: Float) -> Float:
    """Return x (S, m, D) of `matrices` (S, m, m, D) x = `right` (S, m, D), small ones without LAPACK's overhead."""
    if len(matrices[0]) == 1:
        return np.asarray(right / matrices[:, 0])
    if len(matrices[0]) == 2:
        (a, b, d), (x, y) = (matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 1]), np.swapaxes(right, 0, 1)
        return np.stack([d * x - b * y, a * y - b * x], axis=1) / (a * d - b * b)[:, None]
    last = np.moveaxis(right, -1, 1)[..., None]
    return np.asarray(np.moveaxis(np.linalg.solve(np.moveaxis(matrices, -1, 1), last)[..., 0], 1, -1))


def largest_eigenvalue(matrices: Float) -> Float:
    """Return the largest eigenvalue (D,) of symmetric matrices (m, m, D)."""
    if len(matrices) == 1:
        return np.asarray(matrices[0, 0])
    return np.asarray(np.linalg.eigvalsh(np.moveaxis(matrices, -1, 0))[:, -1])


def inverse_of(grams: Float) -> Float:
    """Return the inverses of Gram matrices (..., P, P), pseudo where columns depend on each other, 0 where they are no
    longer than `NOTHING`; scaled first.
    """
    length = np.sqrt(np.maximum(np.einsum("...pp->...p", grams), 0.0))
    scale = np.where(length > NOTHING, length, np.inf)
    norm = scale[..., :, None] * scale[..., None, :]
    values, vectors = np.linalg.eigh(grams / norm)
    known = values > 1e-11 * values[..., -1:]
    scaled = vectors * (known / np.where(known, values, 1.0))[..., None, :]
    return np.asarray(scaled @ np.swapaxes(vectors, -1, -2) / norm)


def numbers_of(grams: Float, products: Float) -> Float:
    """Return the numbers (..., P) that normal equations with Gram matrices (..., P, P) and `products` (..., P) have."""
    return np.asarray((inverse_of(grams) @ products[..., None])[..., 0])
