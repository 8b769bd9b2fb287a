"""Beside rivals: where an accepted term may as well be another one, every lesser term must help beside that one too.

What only helps beside one of two that these data cannot distinguish takes up what the wrong one of them leaves.
"""

from __future__ import annotations

from diagnosis.evidence.score import Score
from diagnosis.search.choice import lag
from diagnosis.search.context import SearchContext
from diagnosis.search.state import Extension, State
from ground.ties import ascending


def drop_dependent(context: SearchContext, state: State) -> State:
    """Return the state without the terms that help beside an accepted term, and not beside a look-alike of it."""
    for extension in state.extensions:
        if extension.added is None:
            continue
        for score in state.accepted:
            if score is extension.added or score.share >= extension.added.share:
                continue
            if rival := _without_it(context, state, extension, score):
                names = [name for name in state.names if name != score.name]
                shorter = context.replay(state, names)
                reason = f"helps beside {extension.added.name}, but not beside {rival}, which it may be"
                context.note_doubt(shorter.last, score.name, reason)
                return drop_dependent(context, shorter)
    return state


def _without_it(context: SearchContext, state: State, extension: Extension, score: Score) -> str:
    """Return a look-alike of an accepted term that explains no less than both and beside which `score` does not help;
    "" where there is none."""
    assert extension.added is not None
    without = context.without(state.last, [extension.added, score])
    evidence = context.evidence(without, draws=0)
    names = [name for name in extension.alike if name not in {*state.names, *extension.never}]
    weighed = context.all_weighed(without, evidence, [context.library.find(name) for name in names])
    scale = state.last.fitted.scale
    both = state.last.fitted.block_losses(scale, context.rules)
    helping = ascending((one for one in weighed if one.helps and not one.caution), lambda one: -one.share, 1.0)
    for rival in helping[: context.rules.refitted]:
        other = context.with_term(without, rival)
        if lag(other.fitted.block_losses(scale, context.rules), both) >= context.rules.clear:
            continue  # together they explain clearly more than it does
        beside = context.evidence(other, draws=0)
        found = context.weighed(other, beside, context.library.find(score.name))
        if not context.agreed(other, beside, [found])[0].eligible:
            return rival.name
    return ""
