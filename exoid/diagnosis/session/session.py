"""Recordings and a model, prepared once; every question is then answered on the same samples with the same filter.

    session = Session(leg, runs[:3], verify=runs[3:])
    session.compare().plot()
    session.fitted(["stribeck:knee"]).evaluation_rms
    found = session.discover()

Models are named by the effects that they have beyond the one given: `("stribeck:knee", "backlash:hip")`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Unpack

import numpy as np

from exoid.diagnosis.comparison import Comparison, compare_prepared
from exoid.diagnosis.discovery import answer_of
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model, places_pay
from exoid.diagnosis.evidence.library import Library, build_library
from exoid.diagnosis.evidence.model_error import ModelError, model_error
from exoid.diagnosis.evidence.stretches import origins, searched_stretches
from exoid.diagnosis.question import Question, own_effects
from exoid.diagnosis.results import Diagnosis, Step
from exoid.diagnosis.rules import Rules
from exoid.diagnosis.session.ranking import Ranking
from exoid.diagnosis.settings import DiscoveryOptions, DiscoverySettings
from exoid.ground.progress import Progress, silent
from exoid.measurement.forces import pushed_model
from exoid.measurement.reading.given import Given, question_of
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import Prepared, prepare
from exoid.symbolic.effect import Effect
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

Names = Sequence[str]


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
