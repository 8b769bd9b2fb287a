"""Prune: a term that the later ones have made superfluous goes."""

from __future__ import annotations

from exoid.diagnosis.search.context import SearchContext
from exoid.diagnosis.search.state import State

FIRST = 199
"""Placebos that are asked first, all where one of them does as well."""


def prune(context: SearchContext, state: State) -> State:
    """Test every accepted term but the last anew beside the others; drop those that no longer count."""
    last, kept = state.last, list(state.accepted)
    for score in state.accepted[:-1]:
        if len(kept) < 2:
            break
        if context.is_settled("prune", state, score):
            continue
        without = context.without(last, [score])
        if not any(context.sure(context.tested(without, score, draws)) for draws in (FIRST, None)):
            kept = [s for s in kept if s is not score]
            last = without
    if len(kept) == len(state.accepted):
        return state
    return context.replay(state, [s.name for s in kept])
