"""Is an accepted term only the nearest thing in the catalogue? A curve without physics, or a single bump, that clearly
beats it on the same data shows that it is a proxy for something else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate, candidate_columns
from exoid.diagnosis.evidence.columns import Columns, stacked
from exoid.diagnosis.evidence.curves import may_move, signal_of, splines_along, tried_curves, variables
from exoid.diagnosis.evidence.fitted import FittedModel, lag
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.look_alikes import block_losses, refine
from exoid.diagnosis.evidence.remainder import CurveData, curve_data_per_recording
from exoid.diagnosis.evidence.score import weigh
from exoid.symbolic.effect import Coefficient, Effect, Shape
from exoid.symbolic.motion import Float
from exoid.symbolic.term import Term

BUMP_LEVELS = np.linspace(0.06, 0.94, 23)
"""Quantiles of a path at which bumps are tried."""
CONSTANT = 1e-4
"""Relative variation below which a column is constant: the filter leaves some."""


@dataclass(frozen=True, eq=False)
class BetterCurve:
    """A curve without physics that beat a term: its columns (one node) on every recording, on which data."""

    columns: tuple[Columns, ...]
    parts: tuple[CurveData, ...]
    ridge: float | None
    share: float

    def leaves(self, term: Sequence[Columns]) -> float:
        """Return the share of the loss that a term (one node) still explains beside the curve."""
        both = stacked([self.columns, term], len(self.parts[0].evidence.sigma))
        return _share(self.parts, both, self.ridge) - self.share

    def supersedes(self, term: Sequence[Columns]) -> bool:
        """True if a term adds less than half of its own gain to the curve.

        A constant adds nothing to any curve, each of which contains it: there the curve has to gain clearly more; and
        where recordings have offsets of their own, a constant says nothing.
        """
        rules, alone = self.parts[0].evidence.rules, _share(self.parts, term)
        if all(np.ptp(item.values, axis=2).max() < CONSTANT * np.abs(item.values).max() for item in term):
            return rules.least_share <= alone < rules.most * self.share
        return self.leaves(term) < rules.half * alone


def beaten(
    now: FittedModel, evidence: Evidence, joint: str, term: Sequence[Columns], numbers: int, *, several: bool = False
) -> BetterCurve | None:
    """Return the curve without physics at `joint` that clearly beats the columns (one node) of a term on the same data.

    Beaten is a term that explains less than most of what a curve does, clearly so in the scatter of blocks of time, or
    of what a single bump with fewer numbers than the `numbers` of the term does; and that adds little to that curve: it
    was a proxy. `several` terms together are beaten by a bump that does practically as well with fewer numbers. A true
    effect of a machine that has errors besides explains most of what a curve can bend to. A term beside which something
    else is left adds nearly as much to a curve as it gains alone. `now` and
    `evidence` are of the model without the term.
    """
    rules = evidence.rules
    common = _on_all(evidence)
    contests: list[Callable[[], BetterCurve | None]] = []
    for parts, own in ((common, False), (tuple(curve_data_per_recording(now, evidence)), True)):
        mine, losses = _share(parts, term), _blocks(parts, term)

        def by_curve(
            variable: str, factor: str, parts: Sequence[CurveData] = parts, mine: float = mine, losses: Float = losses
        ) -> BetterCurve | None:
            splines = splines_along(now, variable, now.model.joint_names.index(joint), factor, rules.knots)
            if splines is None:
                return None
            share = _share(parts, splines.columns, rules.curve_ridge)
            curve = BetterCurve(splines.columns, tuple(parts), rules.curve_ridge, share)
            if mine >= rules.most * curve.share:
                return None
            clear = lag(losses, _blocks(parts, splines.columns, rules.curve_ridge)) >= rules.clear
            return curve if clear and curve.supersedes(term) else None

        tried = (pair for pair in tried_curves(now.model.joints) if not own or may_move(*pair))
        contests += [partial(by_curve, variable, factor) for variable, factor in tried]
    alone = _share(common, term)

    def by_bump(candidate: Candidate) -> BetterCurve | None:
        columns = [
            candidate_columns(candidate, nodes, item, now)
            for nodes, item in zip(candidate.nodes, now.prepared.all, strict=True)
        ]
        score = weigh(evidence, candidate, columns)
        best = tuple(c.node(int(n)) for c, n in zip(columns, score.nodes, strict=True))
        if several:
            score, refined = refine(evidence, score, now)
            best = tuple(refined)
        bump = BetterCurve(best, common, None, score.share)
        least = rules.practically if several else 1.0 / rules.most
        return bump if score.share > least * alone and bump.supersedes(term) else None

    contests += [partial(by_bump, candidate) for candidate in _bumps(now, joint) if candidate.numbers < numbers]
    return next((found for contest in contests if (found := contest()) is not None), None)


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
        widths = np.geomspace(0.05, 0.3, 5) * (high - low)
        pooled = [np.quantile(np.concatenate(paths), BUMP_LEVELS)] * len(paths)
        each_own = [np.quantile(path, BUMP_LEVELS) for path in paths]
        tried = [each_own, pooled] if variable.startswith("q") else [pooled]
        nodes = np.concatenate(
            [np.array([[(m, w) for m in places for w in widths] for places in each]) for each in tried], axis=1
        )
        out.append(Candidate(Term(effect, joint, now.model.joints, own_places=True), nodes, False))
    return out


def explained_share(evidence: Evidence, columns: Sequence[Columns]) -> float:
    """Return the share of the loss on held-out units of all recordings that columns (one node) explain."""
    return _share(_on_all(evidence), columns)


def _on_all(evidence: Evidence) -> tuple[CurveData]:
    return (CurveData(evidence, tuple(range(len(evidence.blocks)))),)


def _blocks(parts: Sequence[CurveData], columns: Sequence[Columns], ridge: float | None = None) -> Float:
    """Return the losses of columns (one node) in blocks of time, on all that is held out."""
    trained = [(j.evidence, j.columns(columns)) for j in parts if j.trained]
    return np.concatenate([block_losses(e, e.plain(c), c, ridge) for e, c in trained])


def _share(parts: Sequence[CurveData], columns: Sequence[Columns], ridge: float | None = None) -> float:
    """Return the share of the loss on held-out units that columns (one node) explain."""
    trained = [j for j in parts if j.trained]
    fall = sum(float(j.evidence.gain(j.evidence.plain(j.columns(columns)), ridge).total[0]) for j in trained)
    return fall / sum(float(j.evidence.fold_losses.sum()) for j in trained)
