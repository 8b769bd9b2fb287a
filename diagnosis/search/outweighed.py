"""Outweighed: terms that explain little while the error stays far above the noise and a curve without physics more.

Something larger is missing then, and what comes nearest to it in the catalogue is not known to be there.
"""

from __future__ import annotations

import numpy as np

from diagnosis.search.context import SearchContext
from diagnosis.search.state import State


def outweighed(context: SearchContext, state: State) -> State:
    """Return the state without the terms at whose joints all terms together explain little of what is more than noise,
    where a curve explains more than they do and the error is far above the noise; they are possible.
    """
    left, rules = state.left, context.rules
    if left is None or not state.accepted:
        return state
    first, last = state.extensions[0].fitted.judged_rms ** 2, state.last.fitted.judged_rms**2
    noise = context.noise(state.last) ** 2
    far, taken, whole = last > rules.far_above**2 * noise, first - last, np.maximum(first - noise, 0.0)
    if not far[left.index] or left.joint_share * last[left.index] <= taken[left.index]:
        return state

    def little(at: list[int]) -> bool:
        return bool(far[at].any() and taken[at].sum() < rules.outweighed * whole[at].sum())

    names = [one.name for one in state.accepted if little(list(one.candidate.term.reaches))]
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
