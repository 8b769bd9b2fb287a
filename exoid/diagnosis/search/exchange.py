"""Exchange: every accepted term but the last is compared with its rivals once more, now that the others are there.

The first terms were chosen while other effects were still missing: a rival that could imitate a little of those too had
an advantage then. What these data cannot distinguish is counted anew as well.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.ranking import agreed, weigh_all
from exoid.diagnosis.evidence.score import Score
from exoid.diagnosis.search.choice import refitted, shortlist
from exoid.diagnosis.search.context import FEW, SearchContext
from exoid.diagnosis.search.state import Extension, State

SAME = 1e-9
"""Difference of two columns, of their size, up to which they are the same but for rounding."""


def exchange(context: SearchContext, state: State) -> State:
    """Put a rival in the place of an accepted term where it is the better one beside all the others."""
    for score in state.accepted[:-1]:
        if context.is_settled("exchange", state, score):
            continue
        context.tick(0.87, f"comparing {score.name} with its rivals once more")
        without = context.without(state.last, [score])
        evidence = context.evidence(without, draws=0)
        taken = {*state.names, *state.banned, *state.unsteady} - {score.name}
        rivals = (context.library.find(name) for name in _rivals(context, score) if name not in taken)
        # What holds another accepted term, as a spring an offset, would stand for both.
        known = {s.candidate.joints for s in state.accepted if s.candidate.numbers == 1}
        effects = [rival for rival in rivals if not rival.reads_torque]
        apart = [r for r in effects if not (_made_of(r, known) or _holds_any(context, without, evidence, r))]
        wanted = [context.library.find(score.name), *apart]
        weighed, columns = weigh_all(evidence, context.library, without.fitted, wanted)
        helping = [s for s in agreed(evidence, weighed, columns, without.fitted) if s.eligible]
        if not helping:
            continue
        near, alike = shortlist(context, without, evidence, helping, {})
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


def _rivals(context: SearchContext, score: Score) -> list[str]:
    """Return the candidates that came close to an accepted one when it stood out most."""
    best: tuple[float, list[str]] = 0.0, []
    for _, scores in context.ranked.values():
        own = next((s.share for s in scores if s.name == score.name), 0.0)
        lead = own / max(s.share for s in scores) if scores and own > 0.0 else 0.0
        if lead > best[0]:
            close = context.rules.half * own
            best = lead, [s.name for s in scores if s.share >= close and s.name != score.name]
    return best[1]
