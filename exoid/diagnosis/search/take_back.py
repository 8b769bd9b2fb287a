"""Take back: accepted terms that a curve without physics clearly beats were only the nearest thing in the catalogue."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from exoid.diagnosis.evidence.columns import Columns, stacked
from exoid.diagnosis.evidence.enough_motion import little_motion
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.look_alikes import columns_at
from exoid.diagnosis.evidence.proxies import BetterCurve, beaten
from exoid.diagnosis.evidence.remainder import CurveData, Remainder, remainders, significant, suggest
from exoid.diagnosis.evidence.score import Score
from exoid.diagnosis.rules import Rules
from exoid.diagnosis.search.context import SearchContext, as_fitted
from exoid.diagnosis.search.state import Extension, State
from exoid.ground.ties import ascending

CONSTANT = 1e-6
"""Change of a column, of its size, that is none: the filter's ends leave as much."""


def take_back(context: SearchContext, state: State) -> State:
    """Return the state with what is left, and without the proxies among its terms; these are banned."""
    left = left_over(context, state.last)
    taken = proxies(context, state, left)
    if not taken:
        return replace(state, left=left)
    shorter = replace(state, banned=state.banned | taken, left=left)
    return context.replay(shorter, [name for name in state.names if name not in shorter.banned])


def left_over(context: SearchContext, extension: Extension) -> Remainder | None:
    """Remainder of the model of `extension` with suggested closed forms; None where none is significant."""
    if little_motion(context.prepared, context.rules):  # a free curve looks as real there as any effect
        return None
    context.tick(0.88, "looking at what is left")
    found = remainders(extension.fitted, context.evidence(extension))
    rules = context.rules
    best = next((r for r in found if significant(r, rules) and not _of_filter(r, extension, rules)), None)
    return None if best is None else replace(best, suggestions=suggest(best))


def _of_filter(left: Remainder, extension: Extension, rules: Rules) -> bool:
    """True if a curve explains no more than filter and derivatives get wrong at its joint."""
    j = extension.fitted.model.joint_names.index(left.joint)
    explained = np.sqrt(left.share) * extension.fitted.evaluation_rms[j]
    return bool(explained <= rules.artefact * extension.fitted.prepared.filter_error[j])


def proxies(context: SearchContext, state: State, left: Remainder | None) -> frozenset[str]:
    """Return the accepted terms that a curve without physics clearly beats.

    All of a joint together first: two entries may build one curve that neither would pass for. Then one by one, at
    their own joint; and, where something is `left`, at its joint too: what nobody explains at one joint bends the
    parameters that both share, and a term at the other joint may bend them back. With them go the candidates that
    could only take their place: those that add little to the same curve.
    """
    scores = {score.name: score for score in state.accepted}
    # A constant is part of any curve: with others it builds none that it is not part of, too.
    bent = {score.name for score in state.accepted if not _is_constant(context, state, score)}

    @cache
    def without(*names: str) -> _Without:
        taken = [scores[name] for name in names]
        extension = context.without(state.last, taken)
        evidence = context.evidence(extension, draws=0)
        fitted = [as_fitted(score, state.last) for score in taken]
        columns = [columns_at(score.candidate, score.shape, extension.fitted) for score in fitted]
        numbers = sum(score.candidate.numbers for score in taken)
        return _Without(names, extension, evidence, tuple(stacked(columns, len(evidence.sigma))), numbers)

    for joint in state.last.fitted.model.joint_names:
        here = [n for n, s in scores.items() if s.candidate.term.joint == joint and n in bent]
        disturbed = left is not None and left.joint == joint
        single = [n for n, s in scores.items() if disturbed or s.candidate.term.joint in (joint, None)]
        for item in _in_turn(without, here, single):
            context.tick(0.9, f"comparing {' and '.join(item.names)} with a curve without physics")
            now, several = item.extension.fitted, len(item.names) > 1
            winner = beaten(now, item.evidence, joint, item.columns, item.numbers, several=several)
            if winner is not None:
                return frozenset({*item.names, *_superseded(context, item.extension, item.evidence, winner, joint)})
    return frozenset()


def _is_constant(context: SearchContext, state: State, score: Score) -> bool:
    """True if a term has one number alone, a torque that does not change over any recording."""
    if score.candidate.numbers != 1 or not score.candidate.term.effect.coefficients:
        return False
    columns = context.library.columns(context.library.find(score.name), state.extensions[0].fitted)
    return all(bool(np.all(np.ptp(c.values, axis=2) <= CONSTANT * np.abs(c.values).max())) for c in columns)


def _in_turn(without: Callable[..., _Without], here: Sequence[str], single: Sequence[str]) -> Iterator[_Without]:
    """Yield a joint's terms together, then one by one: of two that imitate each other the weaker is beaten first."""
    if len(here) > 1:
        yield without(*here)
    yield from ascending(map(without, single), lambda item: CurveData((item.evidence,)).share(item.columns), 1.0)


@dataclass(frozen=True, eq=False)
class _Without:
    """The model without the terms `names`, the evidence against it, and these terms' columns, one node, together."""

    names: tuple[str, ...]
    extension: Extension
    evidence: Evidence
    columns: tuple[Columns, ...]
    numbers: int


def _superseded(
    context: SearchContext, extension: Extension, evidence: Evidence, winner: BetterCurve, joint: str
) -> set[str]:
    """Return the candidates that touch `joint` and add little to the curve that won there."""
    out = set()
    for candidate in context.library.candidates:
        if candidate.name in extension.fitted.model.effects or candidate.term.joint not in (joint, None):
            continue
        columns = context.library.columns(candidate, extension.fitted)
        score = context.weighed(extension, evidence, candidate)
        best = [c.node(int(n)) for c, n in zip(columns, score.nodes, strict=True)]
        if score.share >= context.rules.least_share and winner.supersedes(best):
            out.add(candidate.name)
    return out
