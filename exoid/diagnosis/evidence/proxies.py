"""Is an accepted term only the nearest thing in the catalogue? A curve without physics, or a single bump, that clearly
beats it on the same data shows that it is a proxy for something else.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate, candidate_columns
from exoid.diagnosis.evidence.columns import Columns, stacked
from exoid.diagnosis.evidence.curves import may_move, signal_of, splines_along, tried_curves, variables
from exoid.diagnosis.evidence.fitted import FittedModel, lag
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.gram import RIDGE
from exoid.diagnosis.evidence.look_alikes import refine
from exoid.diagnosis.evidence.remainder import CurveData, curve_data_per_recording
from exoid.diagnosis.evidence.score import weigh
from exoid.symbolic.effect import Coefficient, Effect, Shape
from exoid.symbolic.term import Term

BUMP_LEVELS = np.linspace(0.06, 0.94, 23)
"""Quantiles of a path at which bumps are tried."""
CONSTANT = 1e-4
"""Relative variation below which a column is constant: the filter leaves some."""


@dataclass(frozen=True, eq=False)
class BetterCurve:
    """A curve without physics that beat a term: its columns (one node) on every recording, on which data."""

    columns: tuple[Columns, ...]
    data: CurveData
    ridge: float
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
        return self.data.share(both, self.ridge) - self.share < rules.half * alone


def beaten(
    now: FittedModel, evidence: Evidence, joint: str, term: Sequence[Columns], numbers: int, *, several: bool = False
) -> BetterCurve | None:
    """Return the curve without physics at `joint` that clearly beats the columns (one node) of a term on the same data.

    Beaten is a term that explains less than most of what a curve does, clearly so in the scatter of blocks of time, or
    of what a single bump with fewer numbers than the `numbers` of the term does; and that adds little to that curve: it
    was a proxy. `several` terms together are beaten by a bump that does practically as well with fewer numbers. A true
    effect of a machine that has errors besides explains most of what a curve can bend to. A term beside which something
    else is left adds nearly as much to a curve as it gains alone. `now` and `evidence` are of the model without the
    term.
    """
    curves = _better_curves(now, evidence, joint, term)
    better = itertools.chain(curves, _better_bumps(now, evidence, joint, term, numbers, several=several))
    return next((curve for curve in better if curve.supersedes(term)), None)


def _better_curves(now: FittedModel, evidence: Evidence, joint: str, term: Sequence[Columns]) -> Iterator[BetterCurve]:
    """Yield the curves, common to all recordings or one in each, that explain clearly more than a term."""
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
            share = data.share(columns, ridge)
            if mine < rules.most * share and lag(losses, data.losses(columns, ridge)) >= rules.clear:
                yield BetterCurve(columns, data, ridge, share)


def _better_bumps(
    now: FittedModel, evidence: Evidence, joint: str, term: Sequence[Columns], numbers: int, *, several: bool
) -> Iterator[BetterCurve]:
    """Yield the single bumps of fewer `numbers` that explain clearly more than a term, or than `several` practically as
    much.
    """
    common, rules = CurveData((evidence,)), evidence.rules
    least = (rules.practically if several else 1.0 / rules.most) * common.share(term)
    for candidate in _bumps(now, joint):
        if candidate.numbers >= numbers:
            continue
        pairs = zip(candidate.nodes, now.prepared.all, strict=True)
        columns = [candidate_columns(candidate, nodes, item, now) for nodes, item in pairs]
        score = weigh(evidence, candidate, columns)
        best = [c.node(int(n)) for c, n in zip(columns, score.nodes, strict=True)]
        if several:
            score, best = refine(evidence, score, now)
        if score.share > least:
            yield BetterCurve(tuple(best), common, RIDGE, score.share)


def _bumps(now: FittedModel, joint: str) -> list[Candidate]:
    """Return single bumps in the angles and in the joint's own velocity, as candidates at `joint`."""
    own, known = now.model.joint_names.index(joint) + 1, variables(now.model.joints)
    others = [k for k in range(1, len(now.model.joints) + 1) if k != own]
    out = []
    for word, variable in (*((f"theta{k}", f"q{k}") for k in (own, *others)), (f"dtheta{own}", f"dq{own}")):
        paths = [signal_of(p, now, variable, own - 1) for p in now.prepared.all]
        low, high = np.quantile(np.concatenate(paths), (0.02, 0.98))
        if not high - low > 1e-9:
            continue
        effect = Effect(
            f"bump_in_{variable}",
            "a single bump, no physics",
            f"c * exp(-(({word} - m)/w)**2)",
            None,
            (joint,),
            {"c": Coefficient(now.model.joints[own - 1].unit("tau"))},
            {
                "m": Shape(known[variable][1], low, high, per_recording=variable.startswith("q")),
                "w": Shape(known[variable][1], 0.05 * (high - low), 0.3 * (high - low), spacing="log"),
            },
            custom=True,
        )
        places = np.tile(np.quantile(np.concatenate(paths), BUMP_LEVELS), (len(paths), 1))
        if variable.startswith("q"):
            places = np.hstack([[np.quantile(path, BUMP_LEVELS) for path in paths], places])
        widths = np.geomspace(0.05, 0.3, 5) * (high - low)
        nodes = np.array([[*itertools.product(row, widths)] for row in places])
        out.append(Candidate(Term(effect, joint, now.model.joints, own_places=True), nodes, False))
    return out
