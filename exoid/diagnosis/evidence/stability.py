"""Is it the same answer on other recordings? The decision repeated over splits of the recordings.

Each split fits the model, with and without a term, to some of the recordings and evaluates both on the others;
verification recordings take turns with all the rest. Everything is algebra on the Gram blocks that the evidence keeps
of every recording; shape values are linearised about where the search found them. A split in which the term hardly
shows, in what is fitted or in what is held out, cannot tell and does not count.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from math import comb

import numpy as np

from exoid.diagnosis.evidence.agreement import Agreement
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model
from exoid.diagnosis.evidence.gain import Evidence, robust_weight
from exoid.diagnosis.evidence.gram import Fits, inverse_of
from exoid.diagnosis.evidence.score import Score, admissible
from exoid.diagnosis.rules import Rules
from exoid.ground.ties import order_of
from exoid.optimisation.fitting.identify import identify
from exoid.symbolic.motion import Float

MOST_AGAINST = 3
"""Splits whose recordings are named where they disagree."""


def splits_of(recordings: int, held_out: int, rules: Rules, seed: int = 0) -> tuple[tuple[int, ...], ...]:
    """Recordings that are held out in each split; () where there is only one recording.

    `held_out` of them at a time (a third where that is 0, never more than half): all combinations where there are few,
    otherwise `rules.most_splits` of them at random.
    """
    if recordings < 2:
        return ()
    held_out = min(held_out or max(1, recordings // 3), recordings // 2)
    if comb(recordings, held_out) <= rules.most_splits:
        return tuple(itertools.combinations(range(recordings), held_out))
    rng = np.random.default_rng(seed)
    drawn: set[tuple[int, ...]] = set()
    while len(drawn) < rules.most_splits:
        drawn.add(tuple(sorted(rng.choice(recordings, held_out, replace=False).tolist())))
    return tuple(sorted(drawn))


class Splits:
    """The model of `evidence` fitted in every split, ready to evaluate terms in each of them.

    As many recordings are held out as there are for verification.
    """

    def __init__(self, evidence: Evidence) -> None:
        self.held_out = splits_of(len(evidence.blocks), len(evidence.verify), evidence.rules)
        self.evidence, self.rules = evidence, evidence.rules
        held = np.array([np.isin(evidence.of, k) for k in self.held_out], dtype=bool).reshape(-1, len(evidence.units))
        self.fits, self.unseen = evidence.fits(~held), evidence.held_out(held)
        self.losses = self.unseen.loss(self.fits.step[:, :, None])[:, 0]

    @cached_property
    def _pooled(self) -> Fits:
        """The model fitted to everything."""
        return self.evidence.fits(np.ones((1, len(self.evidence.units))))

    def candidate(self, score: Score, columns: Sequence[Columns]) -> Agreement:
        """Return in how many splits the candidate of `score`, with its columns (one node), helps."""
        if not self.held_out:
            return self._agreement(np.zeros((0, 3)), {})
        grams = self.evidence.plain(columns)
        pooled = self._pooled.candidate(grams)[0][0, :, 0]
        own, step, _ = self.fits.candidate(grams)
        gain = self.losses - self.unseen.loss_beside(grams, own, step)[:, 0]
        right = admissible(score.candidate, own[:, :, 0], self.rules)
        # What the fitted ones show of it: its fall there, the model's own numbers fitted to the same.
        same = self.evidence.held_out(self.fits.units)
        seen, expected = (part.would_fall(self.fits, grams, pooled)[:, 0] for part in (same, self.unseen))
        rows = np.column_stack([np.where(right, gain, -np.inf), expected, seen])
        return self._agreement(rows, _ranges(tuple(score.candidate.term.effect.coefficients), own[:, :, 0]))

    def refitted(self, fitted: FittedModel, name: str) -> Agreement:
        """Return the same as `term` where the model is refitted in every split, its shape values too.

        Far from where they were found, shape values are not linear: a split without the slowest recording knows little
        of a width. What each model leaves is weighted as the gain that is expected is.
        """
        rivals, gains = (fitted.model, fitted.model.without(name)), []
        recordings = fitted.prepared.all
        sigma = self.evidence.sigma
        weights = [robust_weight(block, sigma, self.rules) / sigma[:, None] ** 2 for block in self.evidence.blocks]
        for held in self.held_out:
            kept, unseen = (tuple(p for k, p in enumerate(recordings) if (k in held) == out) for out in (False, True))
            split, losses = replace(fitted.prepared, train=kept, verify=unseen), []
            for model in rivals:
                own = [k for k, shape in enumerate(fitted.model.shapes) if shape.term in {t.name for t in model.terms}]
                fit = identify(model, kept, optimisers=(), start=fitted.shape[own] if own else None)
                left = fitted_model(fit, split).residuals[len(kept) :]
                losses.append(sum(float(np.sum(weights[k] * r**2)) for k, r in zip(held, left, strict=True)))
            gains.append(losses[1] - losses[0])
        return self.term(fitted, name, gains)

    def term(self, fitted: FittedModel, name: str, gains: Sequence[float] | Float | None = None) -> Agreement:
        """Return in how many splits the accepted term `name` of the model helps, and the ranges of its numbers; `gains`
        are those in every split, where they are known.
        """
        model = fitted.model
        entries = [(p.term, p.name) for p in model.parameters] + [(s.term, s.name) for s in model.shapes]
        now, mine = np.zeros(self.evidence.prior.size), np.zeros(self.evidence.prior.size, dtype=bool)
        now[: len(entries)] = np.concatenate([fitted.linear, fitted.shape])
        mine[: len(entries)] = [term == name for term, _ in entries]
        rest = ~mine
        # Without its coefficients a term is nothing; one without coefficients is nothing where its first number is 0.
        linear = mine & (np.arange(mine.size) < fitted.linear.size)
        gone = np.where(linear if linear.any() else mine & (np.cumsum(mine) == 1), -now, 0.0)
        grams, slopes, _ = self.evidence.pooled(self.fits.units)
        grams = grams + np.diag(self.evidence.prior)
        reduced, taken = inverse_of(grams[:, rest][:, :, rest]), grams[:, rest][:, :, mine] @ gone[mine]
        without, lean = (np.tile(start, (len(grams), 1)) for start in (gone, -gone))
        without[:, rest] = (reduced @ (slopes[:, rest] - taken)[:, :, None])[:, :, 0]
        lean[:, rest] = (reduced @ taken[:, :, None])[:, :, 0]
        if gains is None:
            gains = self.unseen.loss(without[:, :, None])[:, 0] - self.losses
        values = (now + self.fits.step)[:, mine]
        bounds = [
            (-np.inf if p.min is None else p.min, np.inf if p.max is None else p.max)
            for p in model.parameters
            if p.term == name
        ]
        low, high = np.array(bounds).reshape(-1, 2).T
        coefficients = values[:, : len(bounds)]
        right = np.all((coefficients >= low) & (coefficients <= high), axis=1)
        expected, seen = (np.einsum("sp,spq,sq->s", lean, gram, lean) for gram in (self.unseen.gram, grams))
        known = [entry.removeprefix(f"{name}.") for term, entry in entries if term == name]
        rows = np.column_stack([np.where(right, gains, -np.inf), expected, seen])
        return self._agreement(rows, _ranges(known, values))

    def _agreement(self, rows: Float, ranges: Mapping[str, tuple[float, float]]) -> Agreement:
        """Count rows of (gain on what is held out, gain expected there, how much the fitted ones show)."""
        if not rows.size:
            return Agreement(0, 0)
        gain, expected, seen = rows.T
        least = self.rules.little
        tells = (expected >= least * expected.mean()) & (seen >= least * seen.mean()) & (expected > 0.0)
        agrees = gain >= np.maximum(self.rules.little * expected, 0.0)
        order = order_of(gain)
        worst = [k for k in order[:MOST_AGAINST] if tells[k] and gain[k] < 0.0]
        against = tuple(dict.fromkeys(r for k in worst for r in self.held_out[k]))
        told, recordings = int(tells.sum()), len({r for held in self.held_out for r in held})
        fitted, count = len(self.evidence.train), len(self.evidence.blocks)
        mute = any(not tells[k] for k, held in enumerate(self.held_out) if held == tuple(range(fitted, count)))
        return Agreement(int((tells & agrees).sum()), told, ranges, against, len(gain), recordings, mute)


def _ranges(names: Sequence[str], values: Float) -> dict[str, tuple[float, float]]:
    """Return from where to where each number went over the splits; {} without splits."""
    if not len(values) or len(names) != len(values[0]):
        return {}
    low, high = np.min(values, axis=0), np.max(values, axis=0)
    return {name: (float(a), float(b)) for name, a, b in zip(names, low, high, strict=True)}
