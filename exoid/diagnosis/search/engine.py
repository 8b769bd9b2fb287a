"""The search for what a model is missing: moves, applied until nothing changes.

A move takes a state and returns another one: `forward` adds terms, `prune` drops superfluous ones, `exchange` compares
each with its rivals, `drop_unsteady` drops terms that only some splits of the recordings support, `take_back` takes
back proxies. What is left beside what was accepted takes nothing of it back: it is a sentence of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from exoid.diagnosis.evidence.score import Score
from exoid.diagnosis.evidence.stability import Splits
from exoid.diagnosis.search.choice import choose
from exoid.diagnosis.search.context import SearchContext
from exoid.diagnosis.search.doubt import Objection, on_bound, undetermined
from exoid.diagnosis.search.exchange import exchange
from exoid.diagnosis.search.state import Extension, State
from exoid.diagnosis.search.take_back import left_over, take_back
from exoid.ground.ties import least_of

FIRST = 199
"""Placebos that are asked first of a term tested anew, all where one of them does as well."""


@dataclass(frozen=True, eq=False)
class Found:
    """End of a search: its last state, and the candidates as ranked against the model that was given."""

    state: State
    first: tuple[Score, ...]


def run_search(context: SearchContext, start: Extension) -> Found:
    """Search from the fitted model `start` until nothing that helps on unseen motion is left."""
    rules, begun = context.rules, State((start,))
    state = search_without_proxies(context, begun)
    first = tuple(context.rank(start, 1)[1])
    for score in state.accepted:
        # So many numbers can build what two plain effects make; see whether plain ones do as well.
        if score.candidate.numbers < rules.many_numbers:
            continue
        others = search_without_proxies(context, replace(begun, banned=state.banned | {score.name}))
        if others.numbers <= state.numbers and state.last.unseen_gain(others.last, rules) > -rules.least_share:
            return Found(others, first)
    return Found(state, first)


def search_without_proxies(context: SearchContext, state: State) -> State:
    """Search, take back proxies, and search on without them: what they stood in front of may now be seen."""
    for _ in range(context.rules.rounds):
        state = add_and_drop(context, state)
        shorter = drop_unsteady(context, state)
        if shorter.unsteady == state.unsteady:
            shorter = take_back(context, state)
        if shorter.names == state.names:
            return shorter
        state = shorter
    while (shorter := drop_unsteady(context, state)).names != state.names:  # nothing unsteady stays, however it ends
        state = shorter
    return replace(state, left=left_over(context, state.last))


def add_and_drop(context: SearchContext, state: State) -> State:
    """Go forward, drop what is superfluous, compare with rivals, and again, until nothing is dropped."""
    state = replace(state, dropped=frozenset())
    while True:
        longer = forward(context, state)
        shorter = exchange(context, prune(context, longer))
        fewer = {*longer.names} - {*shorter.names}
        state = replace(shorter, dropped=state.dropped | fewer)
        if not fewer:
            return state


def forward(context: SearchContext, state: State) -> State:
    """Add the best candidate, and again, as long as one helps and more may be added."""
    out = state.banned | state.dropped | state.unsteady
    while len(state.extensions) <= context.rules.most_terms:
        evidence, scores = context.rank(state.last, len(state.extensions))
        found, failed = choose(context, state.last, evidence, scores, out)
        if found is None:
            break
        out |= failed
        state = state.grown(*state.extensions, found)
        if context.grown is not None:
            context.grown(state)
    return state


def prune(context: SearchContext, state: State) -> State:
    """Test every accepted term but the last anew beside the others; drop those that the later ones made superfluous."""
    last, kept = state.last, list(state.names)
    for score in state.accepted[:-1]:
        if len(kept) < 2:
            break
        if context.is_settled("prune", state, score):
            continue
        without = context.without(last, [score])
        if not any(context.sure(context.tested(without, score, draws)) for draws in (FIRST, None)):
            kept.remove(score.name)
            last = without
    return state if len(kept) == len(state.names) else context.replay(state, kept)


def drop_unsteady(context: SearchContext, state: State) -> State:
    """Return the state without one accepted term: whose numbers, refitted beside the terms that came later, no longer
    show it, or else that fewest splits of the recordings support beside the others, if that are too few.
    """
    if not state.accepted:
        return state
    last = state.last.fitted
    for name in state.names:
        if text := on_bound(last, name, context.rules) or undetermined(last, name):
            return _without(context, state, name, text)
    context.tick(0.89, "repeating the decision over splits of the recordings")
    splits = Splits(context.evidence(state.last, draws=0))
    found = {name: splits.term(last, name) for name in state.names}
    weak = [name for name, agreement in found.items() if not agreement.enough(context.rules)]
    if len(splits.held_out) <= context.rules.most_folds:
        shaped = {shape.term for shape in last.model.shapes if not shape.shape.per_recording}
        found |= {name: splits.refitted(last, name) for name in weak if name in shaped}
        weak = [name for name in weak if not found[name].enough(context.rules)]
    if not weak:
        return state
    return _without(context, state, least_of(weak, lambda name: found[name].share or 0.0, 1.0))


def _without(context: SearchContext, state: State, name: str, reason: str = "") -> State:
    """Return the state without the term `name`, which is not tried again; `reason` is what speaks against it."""
    shorter = replace(state, unsteady=state.unsteady | {name})
    shorter = context.replay(shorter, [other for other in state.names if other != name])
    if reason:
        context.doubts[context.key(shorter.last), name] = Objection(reason)
    return shorter
