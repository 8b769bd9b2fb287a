"""Is an accepted term only the nearest thing in the catalogue? A curve without physics that clearly beats it on the
same data shows that it is a proxy for something else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exoid.diagnosis.evidence.columns import Columns, stacked
from exoid.diagnosis.evidence.curves import may_move, splines_along, tried_curves
from exoid.diagnosis.evidence.fitted import FittedModel, lag
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.remainder import CurveData, curve_data_per_recording

CONSTANT = 1e-4
"""Relative variation below which a column is constant: the filter leaves some."""


@dataclass(frozen=True, eq=False)
class BetterCurve:
    """A curve without physics that beat a term: its columns (one node) on every recording, on which data."""

    columns: tuple[Columns, ...]
    data: CurveData
    share: float

    def supersedes(self, term: Sequence[Columns]) -> bool:
        """True if a term adds less than half of its own gain to the curve.

        A constant adds nothing to any curve, each of which contains it: there the curve has to gain clearly more; and
        where recordings have offsets of their own, a constant says nothing.
        """
        evidence, alone = self.data.parts[0], self.data.share(term)
        rules = evidence.rules
        if all(np.ptp(item.values, axis=2).max() < CONSTANT * np.abs(item.values).max() for item in term):
            return rules.least_share <= alone < rules.most * self.share
        both = stacked([self.columns, term], len(evidence.sigma))
        return self.data.share(both, rules.curve_ridge) - self.share < rules.half * alone


def beaten(now: FittedModel, evidence: Evidence, joint: str, term: Sequence[Columns]) -> BetterCurve | None:
    """Return the curve without physics at `joint`, common to all recordings or one in each, that clearly beats the
    columns (one node) of a term, or of several together, on the same data; None where none does.

    Beaten is a term that explains less than most of what a curve does, clearly so in the scatter of blocks of time, and
    that adds little to that curve: it was a proxy. A true effect of a machine that has errors besides explains most of
    what a curve can bend to. A term beside which something else is left adds nearly as much to a curve as it gains
    alone. `now` and `evidence` are of the model without the term.
    """
    rules, place = evidence.rules, now.model.joint_names.index(joint)
    for own in (False, True):
        data = curve_data_per_recording(now, evidence) if own else CurveData((evidence,))
        mine, losses = data.share(term), data.losses(term)
        for variable, factor in tried_curves(now.model.joints):
            if own and not may_move(variable, factor):
                continue
            if (splines := splines_along(now, variable, place, factor, rules.knots)) is None:
                continue
            columns, ridge = splines.columns, rules.curve_ridge
            curve = BetterCurve(columns, data, data.share(columns, ridge))
            clearly = mine < rules.most * curve.share and lag(losses, data.losses(columns, ridge)) >= rules.clear
            if clearly and curve.supersedes(term):
                return curve
    return None
