"""Is it the same answer on other recordings? The decision repeated over splits of the recordings.

Each split fits the model, with and without a term, to some of the recordings and judges both on the others;
verification recordings take turns with all the rest. Everything is algebra on the Gram blocks that the evidence keeps
of every recording; shape values are linearised about where the search found them. A split in which the term hardly
shows, in what is fitted or in what is judged, cannot tell and does not count.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import comb

import numpy as np

from diagnosis.evidence.agreement import Agreement
from diagnosis.evidence.columns import Columns
from diagnosis.evidence.fitted import FittedModel
from diagnosis.evidence.gain import Evidence, Gram, fit_candidate, inverse_of
from diagnosis.evidence.score import Score, admissible
from diagnosis.rules import Rules
from symbolic.motion import Float

MOST_AGAINST = 3
"""Splits whose recordings are named where they disagree."""


def splits_of(recordings: int, aside: int, rules: Rules, seed: int = 0) -> tuple[tuple[int, ...], ...]:
    """Return which recordings are held out in each split; () where there is only one recording.

    `aside` of them at a time (a third where that is 0, never more than half): all combinations where there are few,
    otherwise `rules.most_splits` of them at random.
    """
    if recordings < 2:
        return ()
    aside = min(aside or max(1, recordings // 3), recordings // 2)
    if comb(recordings, aside) <= rules.most_splits:
        return tuple(itertools.combinations(range(recordings), aside))
    rng = np.random.default_rng(seed)
    drawn: set[tuple[int, ...]] = set()
    while len(drawn) < rules.most_splits:
        drawn.add(tuple(sorted(rng.choice(recordings, aside, replace=False).tolist())))
    return tuple(sorted(drawn))


@dataclass(frozen=True, eq=False)
class _Split:
    """Units that are fitted and judged; of the fitted ones G⁻¹, G, b and the step of the model's own numbers, of the
    judged ones (G, b, c).
    """

    aside: tuple[int, ...]
    fit: list[int]
    judged: list[int]
    inverse: Float
    step: Float
    normal: Float
    slope: Float
    held: tuple[Float, Float, float]

    def loss(self, step: Float) -> float:
        """Return the loss of the judged units after a step (P,) of the model's own numbers."""
        gram, slope, constant = self.held
        return float(constant - 2.0 * step @ slope + step @ gram @ step)


class Splits:
    """The model of `evidence` fitted in every split, ready to judge terms in each of them.

    As many recordings are held out as there are for verification.
    """

    def __init__(self, evidence: Evidence) -> None:
        aside = splits_of(len(evidence.blocks), len(evidence.verify), evidence.rules)
        self.evidence, self.rules = evidence, evidence.rules
        of = [evidence.unit(u)[0] for u in range(evidence.count)]
        self.parts = []
        for held in aside:
            fit = [u for u, recording in enumerate(of) if recording not in held]
            judged = [u for u, recording in enumerate(of) if recording in held]
            gram, slope, _ = evidence.summed(fit)
            normal = gram + np.diag(evidence.prior)
            inverse = inverse_of(normal)
            step = inverse @ slope
            self.parts.append(_Split(tuple(held), fit, judged, inverse, step, normal, slope, evidence.summed(judged)))

    def candidate(self, score: Score, columns: Sequence[Columns]) -> Agreement:
        """Return in how many splits the candidate of `score`, with its columns (one node), helps."""
        grams = self.evidence.plain(columns)
        everything = range(self.evidence.count)
        gram, slope, _ = self.evidence.summed(everything)
        inverse = inverse_of(gram + np.diag(self.evidence.prior))
        ridge = self.evidence.ridge()
        pooled = fit_candidate(inverse, inverse @ slope, grams, ridge)[0][0]
        rows, values = [], []
        for part in self.parts:
            fitted, held = [grams[u] for u in part.fit], _total([grams[u] for u in part.judged])
            own, base, _ = fit_candidate(part.inverse, part.step, fitted, ridge)
            g, h, _ = _total(fitted)
            lean = part.inverse @ g
            seen = h - g.T @ lean
            shown = held[1] - 2.0 * held[0].T @ lean + lean.T @ part.held[0] @ lean
            gain = part.loss(part.step) - part.loss(base[0]) - _extra(base[0], own[0], held)
            right = bool(admissible(score.candidate, own, self.rules)[0])
            rows.append((gain if right else -np.inf, pooled @ shown @ pooled, pooled @ seen @ pooled))
            values.append(own[0])
        return self._agreement(np.array(rows), _ranges(tuple(score.candidate.term.effect.coefficients), values))

    def term(self, fitted: FittedModel, name: str) -> Agreement:
        """Return in how many splits the accepted term `name` of the model helps, and the ranges of its numbers."""
        model = fitted.model
        names = [p.term for p in model.parameters] + [s.term for s in model.shapes]
        mine = np.array([n == name for n in names])
        now = np.concatenate([fitted.linear, fitted.shape])
        # Without its coefficients a term is nothing; one without coefficients is nothing where its first number is 0.
        linear = mine & (np.arange(mine.size) < fitted.linear.size)
        off = linear if linear.any() else mine & (np.cumsum(mine) == 1)
        rest = ~mine
        rows, values = [], []
        for part in self.parts:
            gone = np.where(off, -now, 0.0)
            without = gone.copy()
            right = part.slope[rest] - part.normal[np.ix_(rest, mine)] @ gone[mine]
            reduced = inverse_of(part.normal[np.ix_(rest, rest)])
            without[rest] = reduced @ right
            lean = np.zeros(now.size)
            lean[mine] = now[mine] * off[mine]
            lean[rest] = -reduced @ part.normal[np.ix_(rest, mine)] @ lean[mine]
            gain = part.loss(without) - part.loss(part.step)
            numbers = now + part.step
            admitted = self._possible(fitted, name, numbers)
            rows.append((gain if admitted else -np.inf, lean @ part.held[0] @ lean, lean @ part.normal @ lean))
            values.append(numbers)
        known = [p.name.removeprefix(f"{name}.") for p in model.parameters]
        known += [s.name.removeprefix(f"{name}.") for s in model.shapes]
        own = [v[mine] for v in values]
        return self._agreement(np.array(rows), _ranges([known[k] for k in np.flatnonzero(mine)], own))

    @staticmethod
    def _possible(fitted: FittedModel, name: str, numbers: Float) -> bool:
        """Whether the coefficients of a term lie within their physical bounds."""
        return all(
            (p.min is None or value >= p.min) and (p.max is None or value <= p.max)
            for p, value in zip(fitted.model.parameters, numbers, strict=False)
            if p.term == name
        )

    def _agreement(self, rows: Float, ranges: Mapping[str, tuple[float, float]]) -> Agreement:
        """Count rows of (gain on what is judged, gain expected there, how much the fitted ones show)."""
        if not rows.size:
            return Agreement(0, 0)
        gain, expected, seen = rows.T
        least = self.rules.split_shows
        tells = (expected >= least * expected.mean()) & (seen >= least * seen.mean()) & (expected > 0.0)
        agrees = gain >= np.maximum(self.rules.split_keeps * expected, 0.0)
        order = np.argsort(gain)
        worst = [k for k in order[:MOST_AGAINST] if tells[k] and gain[k] < 0.0]
        against = tuple(dict.fromkeys(r for k in worst for r in self.parts[k].aside))
        return Agreement(int((tells & agrees).sum()), int(tells.sum()), ranges, against)


def _ranges(names: Sequence[str], values: Sequence[Float]) -> dict[str, tuple[float, float]]:
    """Return from where to where each number went over the splits; {} without splits."""
    if not values or len(names) != len(values[0]):
        return {}
    low, high = np.min(values, axis=0), np.max(values, axis=0)
    return {name: (float(a), float(b)) for name, a, b in zip(names, low, high, strict=True)}


def _total(grams: Sequence[Gram]) -> tuple[Float, Float, Float]:
    return sum(u.g[0] for u in grams), sum(u.h[0] for u in grams), sum(u.a[0] for u in grams)


def _extra(base: Float, own: Float, held: tuple[Float, Float, Float]) -> float:
    """Return what a candidate's columns add to the loss of the judged units, the model's own step being `base`."""
    g, h, a = held
    return float(2.0 * base @ (g @ own) - 2.0 * own @ a + own @ h @ own)
