"""Drop what is unsteady: a term that only some splits of the recordings support is possible, not accepted."""

from __future__ import annotations

from dataclasses import replace

from diagnosis.evidence.stability import Splits
from diagnosis.search.context import SearchContext
from diagnosis.search.state import State


def drop_unsteady(context: SearchContext, state: State) -> State:
    """Return the state without the accepted term that fewest splits support beside the others, if that are too few."""
    if not state.accepted:
        return state
    context.tick(0.89, "repeating the decision over splits of the recordings")
    splits = Splits(context.evidence(state.last, draws=0))
    found = {name: splits.term(state.last.fitted, name) for name in state.names}
    weak = [name for name, agreement in found.items() if not agreement.enough(context.rules)]
    if not weak:
        return state
    least = min(weak, key=lambda name: found[name].share or 0.0)
    shorter = replace(state, unsteady=state.unsteady | {least})
    return context.replay(shorter, [name for name in state.names if name != least])
