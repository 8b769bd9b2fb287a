"""Outweighed: terms that explain little beside a curve without physics that explains more.

Something larger is missing then, and what comes nearest to it in the catalogue is not known to be there.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from diagnosis.evidence.remainder import Remainder
from diagnosis.evidence.score import Score
from diagnosis.search.context import SearchContext
from diagnosis.search.state import Extension, State
from symbolic.language.torque import is_transform
from symbolic.motion import Float


def outweighed(context: SearchContext, state: State) -> State:
    """Return the state without the terms that a curve outweighs; they are possible.

    These are terms at whose joints all terms together explain little of what is more than noise, where the curve
    explains more than they do and the error is far above the noise. At any distance from the noise it is a term that
    explains less than the curve: one that gains little at all joints together, at the joint of the curve; and one that
    follows the model's own torque (elastic, late) wherever it acts, as part of what is left there. That takes up part
    of nearly anything, and what nobody explains at one joint bends the inertias that are in the torque of every other.
    """
    left = state.left
    if left is None or not state.accepted:
        return state
    rest = state.last.fitted.evaluation_rms**2
    by_curve = left.joint_share * float(rest[left.index])

    def behind(before: Extension, after: Extension) -> bool:
        """Whether the curve explains more than the term that `after` adds."""
        assert after.added is not None
        taken, term = _taken(before, after), after.added.candidate.term
        if is_transform(term):
            return bool(np.sum((taken / rest)[list(term.reaches)]) < left.joint_share)
        here = left.index in term.reaches and taken[left.index] < by_curve
        return bool(here and _gain(context, before, after) < context.rules.small_gain)

    names = _far_from_the_noise(context, state, left, by_curve) or [
        score.name for score, pair in zip(state.accepted, pairwise(state.extensions), strict=True) if behind(*pair)
    ]
    if not names:
        return state
    shorter = context.replay(state, [name for name in state.names if name not in names])
    text = (
        f"explains little of what is more than noise, and a smooth curve at the {left.joint} explains more: something "
        "larger is missing, and small terms may only take up part of it"
    )
    context.rank(shorter.last, len(shorter.extensions))
    for name in names:
        context.note_doubt(shorter.last, name, text)
    return shorter


def _gain(context: SearchContext, before: Extension, after: Extension) -> float:
    """Return what the term that `after` adds gains on unseen motion, and where it repeats, whichever is held out."""
    gain, score = context.unseen_gain(before, after), after.added
    return max(gain, score.share) if score is not None and score.repeats(context.rules) else gain


def _far_from_the_noise(context: SearchContext, state: State, left: Remainder, by_curve: float) -> list[str]:
    """Return the terms at whose joints all together explain little, the error being far above the noise.

    Of the fitted and the unseen motion together: where unseen motion is quiet it hardly shows a term. A curve at a
    joint that a term does not reach says nothing against one that repeats over many recordings.
    """
    rules, first, last = context.rules, state.extensions[0], state.last
    noise, taken = context.noise(last) ** 2, _taken(first, last)
    far = last.fitted.evaluation_rms**2 > rules.far_above**2 * noise
    if not far[left.index] or by_curve <= taken[left.index]:
        return []
    pairs = [(first.fitted.train_rms, last.fitted.train_rms), (first.fitted.evaluation_rms, last.fitted.evaluation_rms)]
    fallen = np.sum([before**2 - after**2 for before, after in pairs], axis=0)
    whole = np.sum([np.maximum(before**2 - noise, 0.0) for before, _ in pairs], axis=0)

    def little(one: Score) -> bool:
        at = list(one.candidate.term.reaches)
        there = left.index not in at and one.repeats(rules)
        return not there and bool(far[at].any() and fallen[at].sum() < rules.outweighed * whole[at].sum())

    return [one.name for one in state.accepted if little(one)]


def _taken(before: Extension, after: Extension) -> Float:
    """Return by how much the squared error (J,) falls, N²·m²."""
    return before.fitted.evaluation_rms**2 - after.fitted.evaluation_rms**2
