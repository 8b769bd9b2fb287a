"""The search for what a model is missing: moves, applied until nothing changes.

A move takes a state and returns another one: `forward` adds terms, `prune` drops superfluous ones, `exchange` compares
each with its rivals, `drop_unsteady` drops terms that only some splits of the recordings support, `take_back` takes
back proxies. What is left beside what was accepted takes nothing of it back: it is a sentence of its own.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.ranking import agreed, weigh_all
from exoid.diagnosis.evidence.score import Score
from exoid.diagnosis.evidence.stability import Splits
from exoid.diagnosis.search.choice import choose, refitted, shortlist
from exoid.diagnosis.search.context import FEW, SearchContext, as_fitted
from exoid.diagnosis.search.doubt import Objection, on_bound, undetermined
from exoid.diagnosis.search.state import Extension, State
from exoid.diagnosis.search.take_back import left_over, take_back
from exoid.ground.ties import least_of

FIRST = 199
"""Placebos that are asked first of a term tested anew, all where one of them does as well."""
SAME = 1e-9
"""Difference of two columns, of their size, up to which they are the same but for rounding."""


@dataclass(frozen=True, eq=False)
class Found:
    """End of a search: its last state, and the candidates as ranked against the model that was given."""

    state: State
    first: tuple[Score, ...]


def run_search(context: SearchContext, *begun_with: Extension) -> Found:
    """Search from the fitted model, and terms already known, until nothing that helps on unseen motion is left."""
    rules, begun = context.rules, State(begun_with)
    state = search_without_proxies(context, begun)
    first = tuple(context.rank(begun.extensions[0], 1)[1])
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


def exchange(context: SearchContext, state: State) -> State:
    """Put a rival in the place of an accepted term but the last where it is the better one beside all the others.

    The first terms were chosen while other effects were still missing: a rival that could imitate a little of those too
    had an advantage then. What these data cannot distinguish is counted anew as well.
    """
    for score in state.accepted[:-1]:
        if context.is_settled("exchange", state, score):
            continue
        context.tick(0.87, f"comparing {score.name} with its rivals once more")
        without = context.without(state.last, [score])
        evidence = context.evidence(without, draws=0)
        taken, at = {*state.names, *state.banned, *state.unsteady} - {score.name}, {*score.candidate.joints}
        rivals = [c for c in context.library.candidates if c.name not in taken and at & {*c.joints}]
        # What holds another accepted term, as a spring an offset, would stand for both.
        known = {s.candidate.joints for s in state.accepted if s.candidate.numbers == 1}
        wanted = [
            c
            for c in rivals
            if c.name == score.name
            or not (c.reads_torque or _made_of(c, known) or _holds_any(context, without, evidence, c))
        ]
        weighed, columns = weigh_all(evidence, context.library, without.fitted, wanted)
        helping = [s for s in agreed(evidence, weighed, columns, without.fitted) if s.eligible]
        if not helping:
            continue
        near, alike = shortlist(context, without, evidence, helping, {})
        if all(s.name != score.name for s in near):  # linearised, a late torque may show little
            near.insert(1, as_fitted(score, state.last))
        if [s.name for s in near] == [score.name]:
            state = _relabelled(state, score, (), ())
        elif near[0].name == score.name and len(state.accepted) > FEW:  # of so many each that leads linearised stays
            never = next(e.never for e in state.extensions if e.added is score)
            others = [s.name for s in near if s.name in alike and s.candidate.numbers <= score.candidate.numbers]
            state = _relabelled(state, score, tuple(dict.fromkeys([*others, *never])), never)
        elif (found := refitted(context, without, evidence, near, alike)) is None:
            continue
        elif found.score.name == score.name:
            state = _relabelled(state, score, found.alike, found.never)
        elif context.sure(again := context.tested(without, found.score)):
            rest = context.replay(state, [name for name in state.names if name != score.name])
            state = rest.grown(*rest.extensions, replace(found, added=replace(found.score, p_value=again.p_value)))
    return state


def _made_of(rival: Candidate, known: Collection[tuple[int, ...]]) -> bool:
    """True if a rival of several numbers acts on several joints, each with a plain term of its own (`known`)."""
    return rival.numbers > 1 < len(rival.joints) and all((joint,) in known for joint in rival.joints)


def _holds_any(context: SearchContext, extension: Extension, evidence: Evidence, rival: Candidate) -> bool:
    """True if a number of a rival makes exactly the torque that one of a term of the model makes."""
    if rival.width < 2:
        return False
    own = [part.node(0) for part in context.library.columns(rival, extension.fitted)]
    same = []
    for block, part in zip(evidence.blocks, own, strict=True):
        mine = part.full(0, len(block.use))
        places = [k for k, parameter in enumerate(extension.fitted.model.parameters) if parameter.term is not None]
        apart = [np.abs(mine - block.columns[:, :, [k]]).max(axis=(0, 1)) for k in places]
        same.append(np.array(apart).reshape(-1, rival.width) <= SAME * np.abs(mine).max(axis=(0, 1)))
    return bool(np.all(same, axis=0).any())


def _relabelled(state: State, score: Score, alike: tuple[str, ...], never: tuple[str, ...]) -> State:
    """Return the state with other look-alikes of an accepted term."""
    changed = (replace(e, alike=alike, never=never) if e.added is score else e for e in state.extensions)
    return state.grown(*changed)


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
