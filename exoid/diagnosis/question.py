"""The question asked of recordings, and the search that looks for the answer, whichever of them are fitted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import chain, repeat
from typing import TypeGuard

import numpy as np

from exoid.diagnosis.evidence.best_effects import as_given, may_be_explained, most_effects
from exoid.diagnosis.evidence.fitted import FittedModel, beside_offsets, fitted_model, fitted_on
from exoid.diagnosis.evidence.intermittent import Intermittent, intermittent
from exoid.diagnosis.evidence.library import build_library
from exoid.diagnosis.evidence.model_error import is_near_noise
from exoid.diagnosis.evidence.stretches import searched_stretches
from exoid.diagnosis.hypotheses.channels import doubts_after, doubts_before, doubts_first
from exoid.diagnosis.hypotheses.readings import is_reading, readings_of
from exoid.diagnosis.own_numbers.numbers import OwnNumbers
from exoid.diagnosis.results import Conclusion, Step
from exoid.diagnosis.rules import Rules
from exoid.diagnosis.search.context import SearchContext
from exoid.diagnosis.search.engine import Found, run_search
from exoid.diagnosis.search.state import Extension, State
from exoid.diagnosis.settings import DiscoverySettings
from exoid.diagnosis.verdict import check_channels, doubted, pushed, within_filter_error
from exoid.ground.progress import Progress
from exoid.measurement.auditing.masses import MASSES
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import Prepared, prepare
from exoid.symbolic.effect import Effect
from exoid.symbolic.language.torque import transforms
from exoid.symbolic.model import Model


@dataclass(frozen=True, eq=False)
class Searched:
    """A search that has ended: all recordings prepared, what was searched of them (`context`), and what was found.

    `base` is the model that was given, on all of them; `answer` is the conclusion where no search was needed, `outside`
    what may push the machine, unless that is explained.
    """

    prepared: Prepared
    base: FittedModel
    context: SearchContext
    found: Found
    answer: Conclusion | None = None
    outside: Intermittent | None = None


@dataclass(frozen=True, eq=False)
class Question:
    """The question asked of recordings, whichever of them are fitted; `own` are the numbers that belong to them."""

    model: Model
    asked: DiscoverySettings
    own: OwnNumbers | None = None

    @property
    def rules(self) -> Rules:
        """The thresholds that decide."""
        return self.asked.limited(len(self.model.joints))

    def fitted(
        self,
        recordings: Sequence[Recording],
        verify: Sequence[Recording],
        tick: Progress,
        prepared: Prepared | None = None,
    ) -> FittedModel:
        """Return the model as it was given, fitted to the recordings, which are prepared unless they are."""
        tick(0.02, "preparing the recordings")
        if prepared is None:
            asked = self.asked
            prepared = prepare(self.model, recordings, verify, cutoff=asked.cutoff, derivative=asked.derivative)
            prepared = prepared if self.own is None else self.own.applied(prepared)
        return beside_offsets(fitted_model(identify(self.model, prepared.train, optimisers=()), prepared))

    def search(
        self,
        base: FittedModel,
        tick: Progress,
        found: Callable[[Sequence[Step]], None] | None = None,
        read: Callable[[str], FittedModel] | None = None,
    ) -> Searched:
        """Search beside `base`, the model as it was `fitted`; `found` hears of every step, `read` fits it to the
        recordings in another convention.

        That channels are misread has to beat the machine with its best effects, and that something outside pushes, them
        and what belongs to recordings. Not that torques are too small for its masses: no effect speaks of their size.
        """
        prepared = base.prepared
        if any(finding.check == MASSES for finding in prepared.misread):
            return self._answered(base, check_channels(prepared.misread), tick)
        if prepared.misread:
            given = as_given(base)
            rival = self.search(given, tick) if is_near_noise(most_effects(given, self.rules), self.rules) else None
            if self._is_explained(rival) and not self._takes_fewer(rival, prepared.misread, read, tick):
                return rival
            return self._answered(base, check_channels(prepared.misread), tick)
        if (wrong := doubts_first(base, self.rules)) is not None:
            return self._answered(base, doubted(wrong), tick)
        outside = intermittent(base, self.rules)
        if outside is None or may_be_explained(base, self.rules):
            return replace(self._searched(base, tick, found), outside=outside)
        return self._answered(base, pushed(outside, base.model.joints), tick)

    def pushed(self, done: Searched, tick: Progress) -> Searched | None:
        """The answer that something outside pushes, where a search that is `done` explains nothing; None elsewhere."""
        if done.outside is None or done.answer is not None or self._is_explained(done):
            return None
        return self._answered(done.base, pushed(done.outside, done.base.model.joints), tick)

    def _takes_fewer(
        self, rival: Searched, misread: Sequence[Finding], read: Callable[[str], FittedModel] | None, tick: Progress
    ) -> bool:
        """True if recordings that are read otherwise are explained by fewer effects than a rival has, the other reading
        counted as one: effects that make up for a wrong side are as many as it takes.
        """
        option = next((item.option for item in misread if item.option), "")
        if read is None or not option:
            return False
        other = read(option)
        if other.prepared.misread:
            return False
        found = self.search(other, tick)
        return self._is_explained(found) and len(found.found.state.names) + 1 < len(rival.found.state.names)

    def _is_explained(self, rival: Searched | None) -> TypeGuard[Searched]:
        """True if a model that can be was found, and leaves about the noise."""
        if rival is None or rival.answer is not None:
            return False
        last = rival.found.state.last.fitted
        return is_near_noise(last, self.rules) and doubts_after(rival.base, last, self.rules) is None

    def _searched(
        self,
        base: FittedModel,
        tick: Progress,
        found: Callable[[Sequence[Step]], None] | None,
        earlier: State | None = None,
    ) -> Searched:
        """The search, of which an `earlier` one found that torques are late: these show later that a joint sticks."""
        rules, part = self.rules, searched_stretches(base.prepared, self.rules)
        context = self.context(part, base.prepared, tick)
        if (doubt := doubts_before(base, rules)) is not None:
            return self._answered(base, doubted(doubt), tick)
        if np.all(base.evaluation_rms <= rules.artefact * base.prepared.filter_error):
            return self._answered(base, within_filter_error(base), tick)
        if found is not None:
            context = replace(context, grown=lambda state: found(steps_of(state.extensions)))
        start = Extension(base) if part is base.prepared else context.fit(self.model)
        if earlier is not None:
            late = [term.name for term in transforms(earlier.last.fitted.model.terms)]
            begun = context.replay(earlier.grown(start, *earlier.extensions[1:]), late)
            return Searched(base.prepared, base, context, run_search(context, *begun.extensions))
        result = run_search(context, start)
        shown = fitted_on(result.state.last.fitted.fit, base.prepared).shown_later()
        if shown is base.prepared or any(map(is_reading, result.state.names)):  # of what is misread no more is asked
            return Searched(base.prepared, base, context, result)
        return self._searched(self.fitted((), (), tick, shown), tick, found, result.state)

    def _answered(self, base: FittedModel, answer: Conclusion, tick: Progress) -> Searched:
        """Return an answer that no search led to."""
        context = self.context(base.prepared, base.prepared, tick)
        return Searched(base.prepared, base, context, Found(State((Extension(base),)), ()), answer)

    def context(self, part: Prepared, prepared: Prepared, tick: Progress) -> SearchContext:
        """Return the context of a search among the recordings `part`, of those that are `prepared`."""
        # What no catalogue has: the user's effects, and readings that may be the case.
        entries = (*own_effects(self.model, self.asked.extra), *readings_of(self.model, prepared))
        library = build_library(self.model, part.all, entries)
        return SearchContext(part, library, self.asked.seed, tick, self.rules)


def own_effects(model: Model, extra: Sequence[Effect]) -> tuple[Effect, ...]:
    """Return `extra` and the user's own effects, each once: those the model declares and those it has already."""
    own = (*extra, *model.custom, *(term.effect for term in model.terms if term.effect.custom))
    return tuple({effect.id: effect for effect in reversed(own)}.values())[::-1]


def steps_of(extensions: Sequence[Extension], sentences: Sequence[str] = ()) -> tuple[Step, ...]:
    """Return the falling error; `sentences` are about those that were added."""
    labels = ("base" if e.added is None else f"+ {e.added.name}" for e in extensions)
    said = chain(("",), sentences, repeat(""))
    errors = ((e.fitted.train_rms, e.fitted.verify_rms) for e in extensions)
    return tuple(Step(label, *rms, text) for label, rms, text in zip(labels, errors, said, strict=False))
