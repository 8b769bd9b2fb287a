"""The search for what a model is missing: moves, applied until nothing changes.

A move takes a state and returns another one: `forward` adds terms, `prune` drops superfluous ones, `exchange` compares
each with its rivals, `drop_unsteady` drops terms that only some splits of the recordings support, `take_back` takes
back proxies. What is left beside what was accepted takes nothing of it back: it is a sentence of its own. A new move is
a file with one function.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from exoid.diagnosis.evidence.score import Score
from exoid.diagnosis.search.context import SearchContext
from exoid.diagnosis.search.drop_unsteady import drop_unsteady
from exoid.diagnosis.search.exchange import exchange
from exoid.diagnosis.search.forward import forward
from exoid.diagnosis.search.prune import prune
from exoid.diagnosis.search.state import Extension, State
from exoid.diagnosis.search.take_back import left_over, take_back


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
        gain = context.unseen_gain(state.last, others.last)
        if others.numbers <= state.numbers and gain > -rules.least_share:
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
