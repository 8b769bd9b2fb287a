"""Drop what is unsteady: a term that only some splits of the recordings support is possible, not accepted.

So is one whose numbers, refitted beside the terms that came later, no longer show it: all its intervals contain zero,
or a parameter has run into a bound.
"""

from __future__ import annotations

from dataclasses import replace

from exoid.diagnosis.evidence.stability import Splits
from exoid.diagnosis.search.context import SearchContext
from exoid.diagnosis.search.doubt import on_bound, undetermined
from exoid.diagnosis.search.state import State
from exoid.ground.ties import least_of


def drop_unsteady(context: SearchContext, state: State) -> State:
    """Return the state without one accepted term: whose numbers no longer show it, or else that fewest splits support
    beside the others, if that are too few.
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
        shaped = {one.term for one in last.model.shapes if not one.shape.per_recording}
        found |= {name: splits.refitted(last, name) for name in weak if name in shaped}
        weak = [name for name in weak if not found[name].enough(context.rules)]
    if not weak:
        return state
    return _without(context, state, least_of(weak, lambda name: found[name].share or 0.0, 1.0))


def _without(context: SearchContext, state: State, name: str, reason: str = "") -> State:
    """Return the state without the term `name`, which is not tried again; `reason` is what speaks against it."""
    shorter = replace(state, unsteady=state.unsteady | {name})
    shorter = context.replay(shorter, [other for other in state.names if other != name])
    context.note_doubt(shorter.last, name, reason)
    return shorter
