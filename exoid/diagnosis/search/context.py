"""Context that stays the same during one search, and the few operations that every move is made of."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate
from exoid.diagnosis.evidence.fitted import FittedModel, beside_offsets, fitted_model, places_pay, shapes_from
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.library import Library
from exoid.diagnosis.evidence.look_alikes import columns_at
from exoid.diagnosis.evidence.model_error import noise_with, repeats
from exoid.diagnosis.evidence.ranking import agreed, rank, weigh_all, with_chance
from exoid.diagnosis.evidence.score import Score, weigh
from exoid.diagnosis.evidence.simulated import made_by_itself
from exoid.diagnosis.evidence.swinging import ENTRY as SWAY
from exoid.diagnosis.evidence.swinging import sway_nodes
from exoid.diagnosis.rules import RULES, Rules
from exoid.diagnosis.search.doubt import Objection, doubt
from exoid.diagnosis.search.state import Extension, State
from exoid.ground.progress import Progress, part_of, silent
from exoid.ground.ties import least_of, order_of
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

Ranked = tuple[Evidence, list[Score]]
DRAWN = 2
"""Sets of recordings that the present model makes itself."""
FEW, LEADING = 4, 2
"""Terms up to which a search refits whatever may be the better one, and how many it refits beside more of them, as
machines of many joints have: those that lead linearised.
"""
RESOLUTION = 1.2
"""How much finer than the strictest p-value of a ranking its placebos resolve."""


@dataclass(eq=False)
class SearchContext:
    """Recordings, candidates, seed and thresholds of one search, and what it has found out so far."""

    prepared: Prepared
    library: Library
    seed: int = 0
    tick: Progress = silent
    rules: Rules = RULES
    grown: Callable[[State], None] | None = None
    """Called with the state whenever a term was added."""
    ranked: dict[tuple[str, ...], Ranked] = field(default_factory=dict)
    """What was found against a model with these terms, for when the search comes back to it."""
    doubts: dict[tuple[tuple[str, ...], str], Objection] = field(default_factory=dict)
    """Why a candidate was not accepted beside a model with these terms, although it helps."""
    fits: dict[tuple[tuple[str, ...], bytes], Extension] = field(default_factory=dict)
    """A model with these terms fitted from these shapes: moves take the same terms out again and again."""
    own: dict[tuple[str, ...], tuple[FittedModel, ...]] = field(default_factory=dict)
    """The model with these terms on recordings that it made itself: of the one asked last, since those are large."""
    settled: set[tuple[str, str, frozenset[str]]] = field(default_factory=set)
    """Moves that changed nothing about a term, with the names of the terms at its joints then."""

    # -- models -----------------------------------------------------------------------------------------------

    def fit(self, model: Model, start: Float | None = None) -> Extension:
        """Return `model` fitted to the training recordings, on all of them; no term is added yet."""
        begun = b"" if start is None else np.asarray(start, dtype=float).tobytes()
        key = tuple(f"{term.name}{'*' * term.own_places}" for term in model.terms), begun
        if key not in self.fits:
            fit = identify(model, self.prepared.train, optimisers=(), start=start)
            self.fits[key] = Extension(beside_offsets(fitted_model(fit, self.prepared)))
        return self.fits[key]

    def with_term(self, extension: Extension, score: Score) -> Extension:
        """Return the model of `extension` with the candidate of `score` added, everything refitted; a place that may
        move between recordings is one, unless a place in each pays.
        """
        if not score.candidate.term.may_move:
            return self._refitted(extension, score, own_places=False)
        candidate = self.library.find(score.name).at_one_place
        fixed = self.weighed(extension, self.evidence(extension, draws=0), candidate)
        once = self._refitted(extension, fixed, own_places=False)
        each = self._refitted(extension, score, own_places=True)
        return replace(each if places_pay(once.fitted, each.fitted, self.rules) else once, added=score)

    def _refitted(self, extension: Extension, score: Score, *, own_places: bool) -> Extension:
        before, term = extension.fitted, score.candidate.term
        model = before.model.with_effect(term.effect, term.joint, own_places=own_places)
        count = len(self.prepared.train)
        shapes = np.broadcast_to(before.fit.shapes, (count, len(before.shape)))
        start = np.concatenate([shapes, score.start[:count]], axis=1)
        if not any(s.shape.per_recording for s in model.shapes):
            start = start[0]
        return replace(self.fit(model, start if model.shapes else None), added=score)

    def without(self, extension: Extension, scores: Sequence[Score]) -> Extension:
        """Return the model of `extension` without the terms of `scores`, refitted."""
        known = extension.fitted
        model = known.model.without(*(score.name for score in scores))
        return self.fit(model, shapes_from(known, model, len(self.prepared.train)))

    def replay(self, state: State, names: Sequence[str]) -> State:
        """Return the state again with only the terms in `names`, the one that helps most at each step first.

        Their old order may not do: a term can be worth nothing before another has come.
        """
        out = [state.extensions[0]]
        waiting = [e for e in state.extensions[1:] if e.score.name in names]
        while waiting:
            tried = [(self.with_term(out[-1], e.score), e) for e in self._leading(out[-1], waiting)]
            found, old = least_of(tried, lambda pair: -out[-1].unseen_gain(pair[0], self.rules), 1.0)
            out.append(replace(found, alike=old.alike, never=old.never))
            waiting = [e for e in waiting if e is not old]
        return state.grown(*out)

    def _leading(self, before: Extension, waiting: Sequence[Extension]) -> Sequence[Extension]:
        """Those of `waiting` that may help most beside `before`: of many, those whose columns say so."""
        if len(waiting) <= FEW:
            return waiting
        evidence, shares = self.evidence(before, draws=0), []
        for e in waiting:
            candidate, shape = e.score.candidate, e.score.shape
            columns = columns_at(candidate, shape, before.fitted)
            score = weigh(evidence, replace(candidate, nodes=shape[:, None, :]), columns)
            shares.append(score.share if score.unseen is None else min(score.share, score.unseen))
        return [waiting[k] for k in order_of(-np.array(shares))[:LEADING]]

    # -- evidence ---------------------------------------------------------------------------------------------

    def evidence(self, extension: Extension, draws: int | None = None) -> Evidence:
        """Return the evidence against the model of `extension`."""
        return extension.fitted.evidence(seed=self.seed, draws=draws, rules=self.rules)

    def rank(self, extension: Extension, step: int) -> Ranked:
        """Return the evidence against the model of `extension`, and all candidates weighed by it, best first."""
        key = self.key(extension)
        if key not in self.ranked:
            self._notice_sway(extension)
            evidence = self.evidence(extension, self._draws())
            low, high = (0.9 * (1.0 - 0.55**k) for k in (step - 1, step))  # nobody knows how many steps there will be
            tick = part_of(self.tick, low, high, f"step {step}: ")
            self.ranked[key] = evidence, rank(evidence, self.library, extension.fitted, tick)
            evidence.forget()
        return self.ranked[key]

    def _notice_sway(self, extension: Extension) -> None:
        """Let the sway of the base be weighed with a phase of its own in every recording, where all swing alike."""
        if any(candidate.name == SWAY for candidate in self.library.candidates):
            nodes = sway_nodes(extension.fitted, self.noise(extension), self.rules)
            if nodes is not None:
                self.library.narrow(SWAY, nodes)

    def _draws(self) -> int:
        """Number of placebos of a candidate: enough that one among so many candidates can be significant."""
        wanted = RESOLUTION * len(self.library.effects) / self.rules.level
        return max(self.rules.placebos, math.ceil(wanted))

    def weighed(self, extension: Extension, evidence: Evidence, candidate: Candidate) -> Score:
        """Weigh a candidate against the model of `extension`, without placebos and splits."""
        return weigh(evidence, candidate, self.library.columns(candidate, extension.fitted))

    def doubt(self, before: Extension, after: Extension) -> Objection | None:
        """Reason why the term added last must not be accepted, which is kept; None where nothing speaks against."""
        found = doubt(before, after, self.noise(before), self.rules)
        if found is not None:
            self.doubts[self.key(before), after.score.name] = found
        return found

    def noise(self, extension: Extension) -> Float:
        """Return the noise (J,), N·m: what the sensors say or, where the motion repeats, what of the error does not.

        What does not come again when the motion does is no function of it, and no effect can take up part of it.
        """
        return noise_with(repeats(extension.fitted), self.prepared)

    def simulated(self, extension: Extension) -> tuple[FittedModel, ...]:
        """Return the model of `extension` on recordings that it made itself, a few times."""
        key = self.key(extension)
        if key not in self.own:
            floor = self.prepared.noise_floor
            self.own.clear()
            self.own[key] = tuple(made_by_itself(extension.fitted, floor, self.seed + k) for k in range(DRAWN))
        return self.own[key]

    def is_settled(self, move: str, state: State, score: Score) -> bool:
        """True if a move changed nothing about a term before, and no term at its joints has come or gone since; asked
        where there are many. What is not is noted, for the next time.
        """
        at = {*score.candidate.joints}
        near = frozenset(other.name for other in state.accepted if at & {*other.candidate.joints})
        known = len(state.accepted) > FEW and (move, score.name, near) in self.settled
        self.settled.add((move, score.name, near))
        return known

    @staticmethod
    def key(extension: Extension) -> tuple[str, ...]:
        """Return the names of the terms of a model: what was found against it is kept under them."""
        return extension.fitted.model.effects

    def tested(self, extension: Extension, score: Score, draws: int | None = None) -> Score:
        """Weigh the candidate of `score` anew against the model of `extension`, with so many placebos."""
        evidence, candidate = self.evidence(extension, draws), self.library.find(score.name)
        scores, columns = weigh_all(evidence, self.library, extension.fitted, [candidate])
        return with_chance(evidence, agreed(evidence, scores, columns, extension.fitted), columns)[0]

    def sure(self, score: Score) -> bool:
        """True if an accepted term that was tested anew beside the others may stay."""
        return score.helps and score.p_value is not None and score.p_value <= self.rules.strict_level


def as_fitted(score: Score, extension: Extension) -> Score:
    """Return the score of an accepted candidate at the shape values that the model of `extension` ended at.

    It was weighed on a grid; compared with a curve that bends freely, it must stand where it fits best.
    """
    own = [k for k, entry in enumerate(extension.fitted.model.shapes) if entry.term == score.name]
    if not own or score.candidate.tangent:
        return score
    shapes = extension.fitted.shapes[:, own]
    nodes = replace(score.candidate, nodes=shapes[:, None, :])
    return replace(score, candidate=nodes, nodes=np.zeros(len(shapes), dtype=int))
