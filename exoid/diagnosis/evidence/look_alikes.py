"""Look-alikes: candidates that these data, or any data, cannot distinguish from the accepted one.

Two candidates are compared on held-out samples, each refitted with everything else. The difference of their losses is
summed over blocks of a few seconds, longer than the residual remembers; if its sum is within the scatter of the blocks,
the data cannot distinguish them (in the manner of Vuong, Econometrica 57(2), 1989, with blocks for dependence).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate, candidate_columns
from exoid.diagnosis.evidence.columns import Columns, stacked
from exoid.diagnosis.evidence.fitted import FittedModel, lag
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.gram import RIDGE
from exoid.diagnosis.evidence.score import Score, weigh
from exoid.diagnosis.rules import Rules
from exoid.ground.ties import TIED, least_of
from exoid.optimisation.fitting.shapes import from_unit, to_unit
from exoid.symbolic.motion import Float

PERIODS = 6.0
"""Periods of the band after which a residual hardly remembers itself."""


def refine(evidence: Evidence, score: Score, fitted: FittedModel) -> tuple[Score, list[Columns]]:
    """Return the score at shape values refined between the nodes, and the columns there (one node).

    Another choice, where there is one, is refined from there as well: which of two is the better one at a node says
    little about which is between the nodes.
    """
    own = score.shape  # (R, S)
    shapes = [] if score.candidate.tangent else list(score.candidate.term.placed_shape.values())
    chosen = [i for i, shape in enumerate(shapes) if shape.choices]
    best = _refined(evidence, score, own, fitted)
    for other in itertools.product(*(shapes[i].choices for i in chosen)):
        if np.any(own[0, chosen] != other):
            begin = own.copy()
            begin[:, chosen] = other
            found = _refined(evidence, score, begin, fitted)
            best = least_of([best, found], lambda pair: -pair[0].share, 1.0)
    return best


def _refined(evidence: Evidence, score: Score, chosen: Float, fitted: FittedModel) -> tuple[Score, list[Columns]]:
    """Return the score at the best shape values around `chosen` (R, S), choices as they are, and the columns there."""
    candidate = score.candidate
    entries = list(candidate.term.placed_shape.values())

    def weighed(shapes: Float) -> tuple[Score, list[Columns]]:
        columns = columns_at(candidate, shapes, fitted)
        found = weigh(evidence, replace(candidate, nodes=shapes[:, None, :]), columns)
        known = {name: getattr(score, name) for name in ("p_value", "significant", "caution", "agreement")}
        return replace(found, **known), columns

    best = weighed(chosen)
    # What all recordings share may lie between nodes, and places, which move in all of them together.
    free = [i for i, s in enumerate(entries) if not (s.choices or s.is_own)]
    for index in [] if candidate.tangent else free:
        entry = entries[index]
        reach = 1.0 / max(1, entry.points - 1)
        for _ in range(evidence.rules.refinements):
            middle = chosen[:, index].copy()
            for step in (-0.5 * reach, 0.5 * reach):
                trial = chosen.copy()
                trial[:, index] = [from_unit(entry, to_unit(entry, float(value)) + step) for value in middle]
                found = weighed(trial)
                if found[0].share > best[0].share + TIED:
                    best, chosen = found, trial
            reach *= 0.5
    return best


def columns_at(candidate: Candidate, chosen: Float, fitted: FittedModel) -> list[Columns]:
    """Return the columns (one node) of a candidate on every recording, at shape values `chosen` (R, S)."""
    pairs = zip(chosen, fitted.prepared.all, strict=True)
    return [candidate_columns(candidate, row[None], item, fitted) for row, item in pairs]


def look_alikes(
    evidence: Evidence, best: tuple[Score, list[Columns]], rivals: Sequence[tuple[Score, list[Columns]]]
) -> dict[str, float]:
    """Return the rivals whose held-out loss is not clearly larger than that of the best, and their lag behind it.

    The lag is in standard errors of the difference; 0 is a tie. A rival that still gains beside the best one is no
    look-alike but another effect, and so is one that leaves the error of the best one's joints: `leaves_joints`.
    """
    by_joint, without = (joint_losses(evidence, some) for some in (best[1], _nothing(best[1])))
    reference = by_joint.sum(axis=0)
    out: dict[str, float] = {}
    for score, columns in rivals:
        both = evidence.gain(evidence.plain(stacked([best[1], columns], len(evidence.sigma)))).total[0]
        beside = float(both) / float(evidence.fold_losses.sum()) - best[0].share
        if beside > evidence.rules.half * score.share:  # it keeps enough of its gain beside the best to be another one
            continue
        loss = joint_losses(evidence, columns)
        behind = lag(loss.sum(axis=0), reference)
        practically = score.share >= evidence.rules.practically * best[0].share
        elsewhere = leaves_joints(loss, by_joint, without, best[0].candidate, evidence.rules)
        if practically and score.candidate.numbers < best[0].candidate.numbers:
            out[score.name] = 0.0
        elif behind < evidence.rules.clear and not elsewhere:
            out[score.name] = behind
    return out


def leaves_joints(loss: Float, than: Float, without: Float, best: Candidate, rules: Rules) -> bool:
    """True if a rival's loss (J, blocks) is clearly above that of the `best` candidate (`than`) at a joint where the
    best one acts, or falls there, from that `without` either, by less than half as much: what makes the error of
    another joint smaller is another effect, however much that may be.
    """
    at = list(best.joints)
    fall, most = (float(np.sum(without[at]) - np.sum(entry[at])) for entry in (loss, than))
    return fall < rules.half * most or any(lag(loss[joint], than[joint]) >= rules.clear for joint in at)


def clearly_helps(evidence: Evidence, columns: Sequence[Columns], cutoff: float) -> bool:
    """True if the held-out loss of the model is clearly above that with a candidate's columns (one node), as blocks of
    some periods of the band of `cutoff` Hz scatter.
    """
    seconds = min(evidence.rules.block_seconds, PERIODS / cutoff)
    each = [joint_losses(evidence, some, seconds=seconds) for some in (_nothing(columns), columns)]
    return lag(*(loss.sum(axis=0) for loss in each)) >= evidence.rules.clear


def _nothing(columns: Sequence[Columns]) -> list[Columns]:
    return [Columns(c.joints, np.zeros_like(c.values)) for c in columns]


def joint_losses(
    evidence: Evidence, columns: Sequence[Columns], ridge: float = RIDGE, seconds: float | None = None
) -> Float:
    """Return the held-out loss beside a candidate's columns (one node) joint by joint in strides, or blocks of time,
    over all units of all splits (J, blocks).
    """
    out, seconds = [], evidence.rules.block_seconds if seconds is None else seconds
    for unit, step, coefficients in evidence.held_out_fits(evidence.plain(columns), ridge):
        index, weight = evidence.units[unit]
        loss = weight * evidence.left(index, step, columns[index], coefficients) ** 2
        live = np.flatnonzero(weight.sum(axis=0) > 0.0)
        blocks = np.searchsorted(evidence.blocks[index].starts(seconds), live, side="right")
        out.append(np.add.reduceat(loss[:, live], np.flatnonzero(np.diff(blocks, prepend=-1)), axis=1))
    return np.concatenate(out, axis=1)
