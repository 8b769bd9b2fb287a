"""Forward: the best candidate is added, the model refitted, everything weighed anew, as long as one helps."""

from __future__ import annotations

from exoid.diagnosis.search.choice import choose
from exoid.diagnosis.search.context import SearchContext
from exoid.diagnosis.search.state import State


def forward(context: SearchContext, state: State) -> State:
    """Add the best candidate, and again, as long as one helps and more may be added."""
    out = state.banned | state.dropped | state.unsteady
    while len(state.extensions) <= context.rules.most_terms:
        evidence, scores = context.rank(state.last, len(state.extensions))
        choice = choose(context, state.last, evidence, scores, out)
        if choice.found is None:
            break
        out |= choice.failed
        state = state.grown(*state.extensions, choice.found)
        context.grown(state)
    return state
