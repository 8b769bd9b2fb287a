"""Stability of a finished search: the splits that accept each term, and what else is only possible."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from exoid.diagnosis.evidence.agreement import Agreement
from exoid.diagnosis.evidence.ranking import with_chance
from exoid.diagnosis.evidence.score import Score, share_of_own_joints
from exoid.diagnosis.evidence.stability import Splits
from exoid.diagnosis.hypotheses.readings import is_reading
from exoid.diagnosis.results import Possible
from exoid.diagnosis.search.context import SearchContext
from exoid.diagnosis.search.doubt import Objection
from exoid.diagnosis.search.state import State
from exoid.ground.ties import ascending, index_of_greatest
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate

DRAWS_AT_LEVEL = 10
"""Placebos that may do better at the level of significance: so many draws tell a level well enough for a list."""


def agreements_of(context: SearchContext, state: State) -> dict[str, Agreement]:
    """Return for each accepted term in how many splits it is accepted beside the others."""
    if not state.accepted:
        return {}
    splits = Splits(context.evidence(state.last, draws=0))
    return {name: splits.term(state.last.fitted, name) for name in state.names}


def possible_of(context: SearchContext, state: State, several: bool) -> tuple[Possible, ...]:
    """Candidates that still help beside the last model and are not accepted, largest gain first.

    It was doubted after the refit, or too few splits support it; with a single recording (not `several`) only the
    former. In few splits anything flexible helps now and then: such an entry must also do better than its placebos.
    """
    rules, key = context.rules, context.key(state.last)
    out, untested = [], []
    for score in context.ranked[key][1] if key in context.ranked else ():
        if is_reading(score.name) or score.name in state.banned or score.caution or score.share < rules.least_share:
            continue
        agreement = score.agreement or Agreement()
        if agreement.share is not None and agreement.share < rules.little:
            continue
        if objection := _objection(context, state, score.name):
            out.append(replace(_possible(score, agreement, objection.reason), early=objection.early))
        elif reason := _too_few(score, several):
            untested.append((score, agreement, reason))
    if untested:
        draws = math.ceil(DRAWS_AT_LEVEL / rules.level)
        evidence = context.evidence(state.last, draws=draws)
        # They needed no placebos before, since they cannot be accepted.
        some = untested[: rules.most_possible]
        columns = {s.name: context.library.columns(s.candidate, state.last.fitted) for s, _, _ in some}
        for tested, (score, agreement, reason) in zip(
            with_chance(evidence, [score for score, _, _ in some], columns), some, strict=True
        ):
            if tested.p_value is not None and tested.p_value <= rules.level:
                out.append(_possible(score, agreement, reason))
    return tuple(ascending(out, lambda one: -one.explained_share, 1.0)[: rules.most_possible])


def leading_of(context: SearchContext, state: State, first: Sequence[Score], before: Float) -> Possible | None:
    """Leader of the candidates against the model that was given, if it was not accepted, with the reason; None where
    nothing is worth telling. `before` (J,) is the error of that model, N·m.
    """
    floor, told = context.prepared.noise_floor, [score for score in first if not is_reading(score.name)]
    shares = [share_of_own_joints(score, before, floor) for score in told]
    if not shares or max(shares) < context.rules.worth_telling:
        return None
    at = index_of_greatest(shares, 1.0)
    found = _possible(told[at], told[at].agreement or Agreement(), _why_not(context, state, told[at]))
    return replace(found, explained_share=shares[at])


def _why_not(context: SearchContext, state: State, score: Score) -> str:
    """Reason why a candidate was not accepted, whatever it explains of the error of the model that was given."""
    name = score.name
    if objection := _objection(context, state, name):
        return objection.reason
    if score.caution:
        return score.caution
    if name in state.banned:
        return "a smooth curve without physics explains clearly more at its joint, so it was only the nearest entry"
    if name in state.unsteady:
        return "too few splits of the recordings support it beside what else was tried"
    if not score.helps:
        unseen = score.share if score.unseen is None else min(score.share, score.unseen)
        return f"it explains {100 * max(unseen, 0.0):.1g} % of the error of some motion it was not fitted to"
    if not score.steady:
        lost = "some recordings lose much of what the others gain by it"
        if len(context.prepared.all) == 1:
            lost = "its gain is not clear beside how much it scatters over the only recording"
        return _too_few(score, True) or lost
    if not score.significant:
        chance = "" if score.p_value is None else f", p = {score.p_value:.2g} among {len(context.library.effects)}"
        return f"the same effect, shifted in time, does as well too often{chance}"
    return "after a refit of everything it explains nothing of unseen motion that is clearly more than chance"


def _objection(context: SearchContext, state: State, name: str) -> Objection | None:
    """Objection to a candidate after a refit, beside the last model on the way with which it was tried."""
    tried = (context.doubts.get((context.key(extension), name)) for extension in reversed(state.extensions))
    return next(filter(None, tried), None)


def _too_few(score: Score, several: bool) -> str:
    agreement = score.agreement
    if not several or agreement is None or score.steady or not agreement.accepted:
        return ""
    return f"supported by {agreement.accepted} of {agreement.of} splits of the recordings, too few to accept it"


def _possible(score: Score, agreement: Agreement, reason: str) -> Possible:
    term = score.candidate.term
    numbers = {}
    for value, (name, entry) in zip(score.coefficients, term.effect.coefficients.items(), strict=False):
        low, high = agreement.ranges.get(name, (float(value), float(value)))
        numbers[name] = Estimate(name, float(value), entry.unit, low, high)
    return Possible(term.effect.id, term.joint, agreement, numbers, score.share, reason)
