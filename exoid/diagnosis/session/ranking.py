"""All candidates against one fitted model while one looks on: weighed first, then compared with more and more placebos.

The same questions as `evidence.ranking.rank` asks, in small portions: whoever waits sees the order first, then p-values
from few placebos, then from all of them. `trial` says what would be left beside a candidate, without a refit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.library import Library
from exoid.diagnosis.evidence.look_alikes import look_alikes
from exoid.diagnosis.evidence.model_error import sensor_noise
from exoid.diagnosis.evidence.ranking import agreed, mark_significant, placebo
from exoid.diagnosis.evidence.score import Score, weigh
from exoid.diagnosis.rules import RULES, Rules
from exoid.diagnosis.sureness import sureness
from exoid.ground.ties import ascending
from exoid.symbolic.motion import Float

FIRST_DRAWS = 99
"""Placebos of the first look at a candidate; all that the rules ask for come after."""
DRAWN = 12
"""Placebos that are drawn behind a candidate."""
RIVALS = 8
"""Candidates that are asked whether they look alike."""


class Ranking:
    """The candidates of `library` against `fitted`; `work()` goes on step by step, everything else only looks.

    `scores` grows with the work. `draws` says from how many placebos the p-value of a candidate comes.
    """

    def __init__(self, fitted: FittedModel, library: Library, *, seed: int = 0, rules: Rules = RULES) -> None:
        self.fitted, self.library, self.seed, self.rules = fitted, library, seed, rules
        present = {term.name for term in fitted.model.terms}
        todo = [c for c in library.candidates if c.name not in present]
        # A user's own effects first; then those whose columns cost least.
        self.candidates: tuple[Candidate, ...] = tuple(sorted(todo, key=_cost))
        self.draws: dict[str, int] = {}
        self.finished = False
        self._scores: dict[str, Score] = {}
        self._columns: dict[str, tuple[Columns, ...]] = {}
        self._trials: dict[str, FittedModel] = {}
        self._word: str | None = None

    @cached_property
    def evidence(self) -> Evidence:
        """Evidence that the candidates are weighed with."""
        return self.fitted.evidence(seed=self.seed, rules=self.rules)

    @property
    def scores(self) -> list[Score]:
        """Those weighed so far, best first."""
        return ascending(self._scores.values(), lambda score: -score.share, 1.0)

    @property
    def weighed(self) -> float:
        """Share of the candidates that are weighed."""
        return len(self._scores) / max(1, len(self.candidates))

    def score(self, name: str) -> Score | None:
        """Return the score of a candidate; None where it is not weighed (yet)."""
        return self._scores.get(name)

    def work(self) -> Iterator[str]:
        """Do the next portion of the work at every step, and say which candidate it was about."""
        for candidate in self.candidates:
            columns = self.library.columns(candidate, self.fitted)
            self._columns[candidate.name] = columns
            self._scores[candidate.name] = weigh(self.evidence, candidate, columns)
            yield candidate.name
        for score in agreed(self.evidence, self.scores, self._columns, self.fitted):
            self._scores[score.name] = score
        promising = [s.name for s in self.scores if s.eligible][: self.rules.placebo_for]
        few = self.fitted.evidence(seed=self.seed, draws=FIRST_DRAWS, rules=self.rules)
        for evidence in (few, self.evidence):
            for name in promising:
                self._scores[name] = placebo(evidence, self._scores[name], self._columns[name])
                self.draws[name] = evidence.draws
                yield name
        for score in mark_significant(self.scores, self.rules.level):
            self._scores[score.name] = score
        self.finished = True

    def trial(self, name: str) -> FittedModel | None:
        """The model with what would be left beside a candidate, linear about the present numbers, which are refitted
        with it; shape values are the best that were tried. None where it is not weighed (yet).
        """
        if name not in self._scores:
            return None
        if name not in self._trials:
            self._trials[name] = replace(self.fitted, residuals=self._left(self._best(self._scores[name])))
        return self._trials[name]

    def alike(self, name: str) -> tuple[str, ...]:
        """Return the candidates that these recordings cannot distinguish from this one."""
        score = self._scores.get(name)
        if score is None or score.share < self.rules.least_share:
            return ()
        near = [s for s in self.scores if s is not score and s.share >= 0.5 * score.share and not s.caution]
        pairs = [(s, self._best(s)) for s in (score, *near[:RIVALS])]
        return tuple(look_alikes(self.evidence, pairs[0], pairs[1:]))

    def sureness(self, name: str) -> str:
        """Certainty that this one is missing, of the leader when all placebos were asked; "" of the others, which may
        do no more than follow it.
        """
        if not self.finished or not self.scores or self.scores[0].name != name:
            return ""
        if self._word is None:
            first = self.scores[0]
            doubted = bool(first.caution) or not first.significant or bool(self.alike(name))
            self._word = sureness(
                first.p_value, first.agreement, doubted=doubted, left=self._times_left(first), rules=self.rules
            )
        return self._word

    def _times_left(self, score: Score) -> float:
        """Error beside a candidate at its joints as a multiple of the noise."""
        trial, floor = self.trial(score.name), np.maximum(sensor_noise(self.fitted.prepared), 1e-300)
        return 0.0 if trial is None else float(np.max((trial.evaluation_rms / floor)[list(score.candidate.joints)]))

    def explained(self, selected: Sequence[np.ndarray]) -> dict[str, float]:
        """Return, best first, which share of the squared error at the samples `selected` (J, K) of every recording
        each candidate would take away. Its numbers are those for all recordings: nothing is fitted to the selection.
        """
        parts = zip(selected, self.fitted.prepared.all, strict=True)
        weight = [chosen * item.used / self.evidence.sigma[:, None] ** 2 for chosen, item in parts]
        before = sum(float(np.sum(w * r**2)) for w, r in zip(weight, self.fitted.residuals, strict=True))
        if not before > 0.0:
            return {}
        out = {}
        for name in list(self._scores):
            trial = self.trial(name)
            if trial is not None:
                after = sum(float(np.sum(w * r**2)) for w, r in zip(weight, trial.residuals, strict=True))
                out[name] = 1.0 - after / before
        return dict(ascending(out.items(), lambda pair: -pair[1], 1.0))

    def _best(self, score: Score) -> list[Columns]:
        """Return the columns of a candidate at its best shape values."""
        return [c.node(int(n)) for c, n in zip(self._columns[score.name], score.nodes, strict=True)]

    def band(self, name: str) -> tuple[tuple[Float, ...], tuple[Float, ...]] | None:
        """Return between which residuals (J, K) N·m the placebos of a candidate stay, recording by recording; None
        where it is not weighed (yet).
        """
        if name not in self._scores:
            return None
        columns, shifts = self._best(self._scores[name]), self.evidence.shifts
        low: list[Float] = []
        high: list[Float] = []
        for draw in range(min(DRAWN, self.evidence.draws)):
            left = self._left([_shifted(c, int(s[draw])) for c, s in zip(columns, shifts, strict=True)])
            low = [np.minimum(a, b) for a, b in zip(low or left, left, strict=True)]
            high = [np.maximum(a, b) for a, b in zip(high or left, left, strict=True)]
        return tuple(low), tuple(high)

    def _left(self, columns: Sequence[Columns]) -> tuple[Float, ...]:
        """Return the residuals beside a candidate's columns (one node), everything refitted on training recordings."""
        coefficients, step = self.evidence.fitted(self.evidence.plain(columns))
        return tuple(self.evidence.left(k, step, own, coefficients) for k, own in enumerate(columns))


def _cost(candidate: Candidate) -> tuple[bool, bool, int]:
    effect = candidate.term.effect
    return not effect.custom, effect.derive is not None, candidate.nodes.shape[1]


def _shifted(columns: Columns, samples: int) -> Columns:
    """Return the columns shifted circularly in time."""
    return replace(columns, values=np.roll(columns.values, samples, axis=2))
