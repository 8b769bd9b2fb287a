"""Recordings and a model, prepared once; every question is then answered on the same samples with the same filter.

    session = Session(leg, runs[:3], verify=runs[3:])
    session.compare().plot()
    session.fitted(["stribeck:knee"]).evaluation_rms
    found = session.discover()

Models are named by the effects that they have beyond the one given: `("stribeck:knee", "backlash:hip")`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Unpack

import numpy as np

from exoid.diagnosis.comparison import Comparison, compare_prepared
from exoid.diagnosis.discovery import answer_of
from exoid.diagnosis.evidence.candidates import Candidate
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model, places_pay
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.library import Library, build_library
from exoid.diagnosis.evidence.look_alikes import look_alikes
from exoid.diagnosis.evidence.model_error import ModelError, model_error, times_noise
from exoid.diagnosis.evidence.ranking import agreed, mark_significant, placebo
from exoid.diagnosis.evidence.score import Score, weigh
from exoid.diagnosis.evidence.stretches import origins, searched_stretches
from exoid.diagnosis.question import Question, own_effects
from exoid.diagnosis.results import Diagnosis, Step
from exoid.diagnosis.rules import RULES, Rules
from exoid.diagnosis.settings import DiscoveryOptions, DiscoverySettings
from exoid.diagnosis.sureness import sureness
from exoid.ground.progress import Progress, silent
from exoid.ground.ties import ascending
from exoid.measurement.forces import pushed_model
from exoid.measurement.reading.given import Given, question_of
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import Prepared, prepare
from exoid.symbolic.effect import Effect
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

Names = Sequence[str]
FIRST_DRAWS = 99
"""Placebos of the first look at a candidate; all that the rules ask for come after."""
DRAWN = 12
"""Placebos that are drawn behind a candidate."""
RIVALS = 8
"""Candidates that are asked whether they look alike."""


class Session:
    """Session of somebody who works with recordings; fits and rankings are kept.

    `recordings` are fitted, `verify` never; `settings`, or the same names as keywords, are those of `discover`. Nothing
    is computed before it is asked for; errors are those of `prepare` and `identify`.
    """

    def __init__(
        self,
        model: Model | Given | None = None,
        recordings: Given | None = None,
        verify: Given = (),
        settings: DiscoverySettings | None = None,
        *,
        prepared: Prepared | None = None,
        **changes: Unpack[DiscoveryOptions],
    ) -> None:
        asked = DiscoverySettings.chosen(settings, changes)
        machine, recordings, verify = question_of(model, recordings, verify)
        self.model = pushed_model(machine, (*recordings, *verify))
        self.recordings, self.verify = recordings, verify
        self.asked = replace(asked, extra=own_effects(machine, tuple(asked.extra)))
        if prepared is not None:
            self.prepared = prepared
        self._fits: dict[tuple[str, ...], FittedModel] = {}
        self._rankings: dict[tuple[str, ...], Ranking] = {}
        self._shapes: dict[str, Float] = {}
        self._own_places: dict[str, bool] = {}  # of effects with a place: whether recordings have others

    @property
    def rules(self) -> Rules:
        """The thresholds that decide."""
        return self.asked.limited(len(self.model.joints))

    @property
    def extra(self) -> tuple[Effect, ...]:
        """The user's own effects."""
        return tuple(self.asked.extra)

    @cached_property
    def prepared(self) -> Prepared:
        """The recordings, filtered alike."""
        asked = self.asked
        return prepare(self.model, self.recordings, self.verify, cutoff=asked.cutoff, derivative=asked.derivative)

    @cached_property
    def searched(self) -> Prepared:
        """Recordings in which suspects are looked for, or stretches of long ones."""
        return searched_stretches(self.prepared, self.rules)

    @cached_property
    def origins(self) -> tuple[int, ...]:
        """Of which recording of `prepared` each one of `searched` is, or is a stretch of."""
        return origins(self.prepared, self.searched)

    @cached_property
    def library(self) -> Library:
        """Every effect that may be missing."""
        return build_library(self.model, self.searched.all, self.extra)

    def knowing(self, effect: Effect) -> Session:
        """Return the session with one more effect of the user's own; what was prepared and fitted stays."""
        known = [e for e in self.extra if e.id != effect.id]
        other = self.light((*known, effect))
        keep = {names: fit for names, fit in self._fits.items() if effect.id not in [_id(name) for name in names]}
        other._fits.update(keep)
        other._shapes.update({name: value for name, value in self._shapes.items() if _id(name) != effect.id})
        return other

    def with_effects(self, names: Names) -> Model:
        """Return the model with these effects; EffectError where there is no such effect."""
        own = {effect.id: effect for effect in self.extra}
        model = self.model
        for name in names:
            identifier, _, joint = name.partition(":")
            places = self._own_places.get(name, False)
            model = model.with_effect(own.get(identifier, identifier), joint or None, own_places=places)
        return model

    def known(self, names: Names = ()) -> FittedModel | None:
        """Return the model with these effects as it was fitted; None where it was not yet."""
        return self._fits.get(tuple(names))

    def fitted(self, names: Names = ()) -> FittedModel:
        """Return the model with these effects, fitted to the training recordings, on all of them."""
        key = tuple(names)
        if key not in self._fits:
            found = self._fitted(key)
            if key and found.model.terms[-1].may_move and key[-1] not in self._own_places:
                self._own_places[key[-1]] = True
                each = self._fitted(key)
                self._own_places[key[-1]] = places_pay(found, each, self.rules)
                found = each if self._own_places[key[-1]] else found
            self._keep(key, found)
        return self._fits[key]

    def take(self, names: Names, found: FittedModel) -> None:
        """Take the model with these effects from a search that came to it, which has them last, in this order.

        Where that took from the recordings what belongs to them, models with further effects are fitted so, too.
        """
        terms = found.model.terms
        self._own_places |= {term.name: term.own_places for term in terms[len(terms) - len(names) :] if term.may_move}
        self._keep(tuple(names), found)

    def _keep(self, names: tuple[str, ...], found: FittedModel) -> None:
        self._fits[names] = found
        for entry, column in zip(found.model.shapes, np.asarray(found.fit.shapes).T, strict=True):
            self._shapes[entry.name] = column

    def _fitted(self, names: Names) -> FittedModel:
        model = self.with_effects(names)
        before = [self._fits[key] for key in (tuple(names[:k]) for k in range(len(names))) if key in self._fits]
        prepared = before[-1].prepared if before else self.prepared
        return fitted_model(identify(model, prepared.train, optimisers=(), start=self._start(model)), prepared)

    def ranking(self, names: Names = ()) -> Ranking:
        """Return the suspects beside these effects; they are weighed by its `work()`."""
        key = tuple(names)
        if key not in self._rankings:
            now = self.fitted(key)
            if self.searched is not self.prepared:
                now = fitted_model(now.fit, self.searched)
            self._rankings[key] = Ranking(now, self.library, seed=self.asked.seed, rules=self.rules)
        return self._rankings[key]

    def starts_at(self, names: Names, ranking: Ranking) -> None:
        """Take the shape values of the last of `names` from a ranking, so that its fit begins there."""
        score = ranking.score(names[-1]) if names else None
        if score is None or score.candidate.tangent:
            return
        term = score.candidate.term
        rows = score.shape[[self.origins.index(k) for k in range(len(self.prepared.train))]]
        for entry, column in zip(term.shapes, rows.T, strict=True):
            self._shapes.setdefault(entry.name, column)

    def step(self, names: Names = (), label: str = "base") -> Step:
        """Return the error of the model with these effects as a step of the falling error."""
        now = self.fitted(names)
        return Step(label, now.train_rms, now.verify_rms)

    def compare(self, names: Names = ()) -> Comparison:
        """Compare the model with these effects with the recordings."""
        return compare_prepared(self.fitted(names).fit, self.prepared)

    def error(self, names: Names = ()) -> ModelError | None:
        """Error of the model with these effects beyond the noise; None where it is near the noise."""
        return model_error(self.fitted(names), self.rules)

    def discover(
        self,
        names: Names = (),
        *,
        progress: Progress | None = None,
        most: int | None = None,
        found: Callable[[Sequence[Step]], None] | None = None,
    ) -> Diagnosis:
        """Search for what the model with these effects is missing, to the end (or at most `most` effects).

        `found` is called with the steps so far whenever there is another one.
        """
        asked = self.asked if most is None else replace(self.asked, most=most)
        question = Question(self.with_effects(names), asked)
        return answer_of(question, self.recordings, self.verify, progress or silent, self.prepared, found)

    def light(self, extra: Sequence[Effect] | None = None) -> Session:
        """Return the session with its prepared recordings alone, as it is sent to another process; with `extra` in
        place of the user's own effects.
        """
        asked = self.asked if extra is None else replace(self.asked, extra=extra)
        return Session(self.model, self.recordings, self.verify, asked, prepared=self.prepared)

    def _start(self, model: Model) -> Float | None:
        """Shape values at which their search begins; None where one of them was never found."""
        columns = [self._shapes.get(entry.name) for entry in model.shapes]
        found = [column for column in columns if column is not None]
        if not found or len(found) < len(columns):
            return None
        rows = np.column_stack(found)
        return rows if any(entry.shape.per_recording for entry in model.shapes) else rows[0]


def _id(name: str) -> str:
    """Return the effect's id in "stribeck:knee" or "stribeck:knee.v_s"."""
    return name.partition(":")[0].partition(".")[0]


class Ranking:
    """All candidates of `library` against `fitted` while one looks on; `work()` goes on by steps, the rest only looks.

    The same questions as `evidence.ranking.rank` asks, in small portions: whoever waits sees the order first, then
    p-values from few placebos, then from all of them. `scores` grows with the work. `draws` says from how many placebos
    the p-value of a candidate comes.
    """

    def __init__(self, fitted: FittedModel, library: Library, *, seed: int = 0, rules: Rules = RULES) -> None:
        self.fitted, self.library, self.seed, self.rules = fitted, library, seed, rules
        todo = [c for c in library.candidates if c.name not in fitted.model.effects]
        # A user's own effects first; then those whose columns cost least.
        self.candidates: tuple[Candidate, ...] = tuple(sorted(todo, key=_cost))
        self.draws: dict[str, int] = {}
        self.finished = False
        self._scores: dict[str, Score] = {}
        self._columns: dict[str, tuple[Columns, ...]] = {}
        self._trials: dict[str, FittedModel] = {}

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
        """Certainty that the leader is missing, when all placebos were asked; "" of others, which may but follow it."""
        return self._word if self.finished and self.scores and self.scores[0].name == name else ""

    @cached_property
    def _word(self) -> str:
        """Certainty of the leader; what is left beside it is told as a multiple of the noise at its joints."""
        first = self.scores[0]
        doubted = bool(first.caution) or not first.significant or bool(self.alike(first.name))
        trial = self.trial(first.name) or self.fitted
        left = float(times_noise(trial)[list(first.candidate.joints)].max())
        return sureness(first.p_value, first.agreement, doubted=doubted, left=left, rules=self.rules)

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
        """Return residuals (J, K) N·m between which placebos of a candidate stay, by recording; None if not weighed."""
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
