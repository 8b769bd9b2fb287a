"""Merge: one term takes the place of two wherever it does as well, since forward steps may go round the truth."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from diagnosis.evidence.columns import stacked
from diagnosis.evidence.score import Score
from diagnosis.search.choice import choose
from diagnosis.search.context import SearchContext, as_fitted
from diagnosis.search.state import State


def merge(context: SearchContext, state: State) -> State:
    """Take out each pair of accepted terms; where one candidate then gains nearly what both did, believe that one."""
    rules = context.rules
    for pair in itertools.combinations(state.accepted, 2):
        context.tick(0.87, f"looking for one effect instead of {pair[0].name} and {pair[1].name}")
        if not _one_would_do(context, state, pair):
            continue
        names = {score.name for score in pair}
        shorter = context.replay(state, [name for name in state.names if name not in names])
        evidence, ranked = context.rank(shorter.last, len(shorter.extensions))
        found = choose(context, shorter.last, evidence, ranked, state.banned | state.unsteady).found
        fresh = found is not None and found.added is not None and found.added.name not in names
        if found is not None and fresh and context.unseen_gain(state.last, found) > -2.0 * rules.least_share:
            return merge(context, shorter.grown(*shorter.extensions, found))
    return state


def _one_would_do(context: SearchContext, state: State, pair: Sequence[Score]) -> bool:
    """Whether a single candidate gains nearly what the two of `pair` gain together."""
    without = context.without(state.last, pair)
    evidence = context.evidence(without, draws=0)
    columns = [context.columns_of(as_fitted(score, state.last), without.fitted) for score in pair]
    together = evidence.plain(stacked(columns, len(evidence.sigma)))
    wanted = context.rules.merged * float(evidence.gain(together).total[0]) / float(evidence.fold_losses.sum())
    taken = (
        {term.name for term in without.fitted.model.terms}
        | state.banned
        | state.unsteady
        | {score.name for score in pair}
    )
    others = [c for c in context.library.candidates if c.name not in taken]
    able = {joints for joints in {c.joints for c in others} if evidence.within_reach(joints) >= wanted}
    scores = context.all_weighed(without, evidence, [c for c in others if c.joints in able])
    enough = [s for s in scores if s.share >= wanted]
    return any(s.eligible for s in context.agreed(without, evidence, enough))
