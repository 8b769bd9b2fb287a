"""Who did it: every candidate weighed on motion it was not fitted on, with placebos of itself as the measure.

A candidate *counts* when its coefficients have a physical sign, it lowers the error on whole held-out recordings, on
the verification recordings too, and hardly any placebo (the same entry, shifted in time, through the same search) does
as well. Over the catalogue the false-discovery rate is controlled (Benjamini, Hochberg 1995).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.evidence.candidates import Candidate, Columns, Library
from diagnosis.evidence.gain import Evidence, Gain, Gram
from symbolic.effect import Coefficient, Shape
from symbolic.model import Model
from symbolic.motion import Float

FALSE_DISCOVERY_RATE = 0.05
LEAST_SHARE = 0.01
"""Smallest share of the weighted unseen loss worth a term (about 2 % of the RMS error of one joint): below, errors of
the filter and of reversals take part in every significant-looking column."""
HARMLESS = 0.3
"""A recording may lose at most this part of the average gain; an effect it does not show costs it nearly nothing."""
LEAST_NOVELTY = 1e-6
"""Share of a column that must be new to the model; less is absorbed by its parameters."""
LEAST_ACTIVE = 0.003
"""Share of samples on which a column must differ from zero."""
LEAST_SEEN = 0.01
"""Share of a column's squares on samples that are fitted: a Stribeck peak inside the speeds at which a joint may stick
shows only in what the filter spreads, and would be credited with whatever is wrong there."""
TANGENT_REACH = 2.0
"""Times a bound that a tangent may reach: of a large delay or gain it only shows the direction and the order of size.
The fit that follows keeps the bound itself."""
PLACEBO_NODES = 100
"""Nodes at most in the search of a placebo; neighbouring nodes resemble each other."""
TELEGRAPH = 3.0
"""Seconds between possible changes of sign in the placebo of a constant torque."""
PLACEBO_FOR = 12
"""Candidates with the largest gains get placebos; the others cannot be the best and count as not significant."""


@dataclass(frozen=True, eq=False)
class Score:
    """What the evidence says about one candidate.

    `nodes` (R,) index of the shape node in each recording; shares are falls of the weighted loss relative to the
    present model: `share` on held-out training units, `folds` (F,) on each, `unseen` on verification
    recordings (None without).
    `p_value` is None where no placebo was run. `caution` says in words what speaks against it.
    """

    candidate: Candidate
    nodes: np.ndarray
    share: float
    folds: Float
    unseen: float | None
    coefficients: Float
    novelty: float
    p_value: float | None = None
    significant: bool = False
    caution: str = ""

    @property
    def name(self) -> str:
        """Full name of the candidate."""
        return self.candidate.name

    @property
    def helps(self) -> bool:
        """Whether it lowers the error where it was not fitted: in total, on verification, and hurts no recording."""
        harmless = np.all(self.folds > -HARMLESS * self.share)
        fresh = self.unseen is None or self.unseen >= 0.5 * LEAST_SHARE
        return self.share >= LEAST_SHARE and bool(harmless) and fresh

    @property
    def shape(self) -> Float:
        """Shape values (R, S) on each recording."""
        return self.candidate.nodes[np.arange(len(self.nodes)), self.nodes]


def weigh(evidence: Evidence, candidate: Candidate, columns: Sequence[Columns]) -> Score:
    """Return the score of a candidate at its best node, without placebos."""
    grams = evidence.plain(columns)
    novelty = evidence.novelty(grams)
    alive = (novelty > LEAST_NOVELTY) & (_active(evidence, columns) >= LEAST_ACTIVE)
    if not alive.any():
        nodes = np.zeros(len(columns), dtype=int)
        blank = np.zeros(len(evidence.fold_losses))
        text = "the model's own parameters already contain it, on this motion"
        return Score(
            candidate, nodes, 0.0, blank, 0.0, np.zeros(columns[0].values.shape[3]), float(novelty.max()), caution=text
        )
    best: tuple[np.ndarray, Gain] | None = None
    wrong = 0.0
    for nodes, gain in _choices(evidence, candidate, grams, alive):
        right = admissible(candidate, gain.coefficients)[0]
        total = float(gain.total[0])
        if right and (best is None or total > best[1].total[0]):
            best = nodes, gain
        elif not right:
            wrong = max(wrong, total)
    whole = float(evidence.fold_losses.sum())
    if best is None or wrong > 2.0 * max(float(best[1].total[0]), 0.0):
        nodes, gain = best or next(iter(_choices(evidence, candidate, grams, alive)))
        text = "fits best with a sign that this effect cannot have" if wrong > LEAST_SHARE * whole else ""
    else:
        (nodes, gain), text = best, ""
    unseen = float(gain.unseen[0] / evidence.unseen_loss) if evidence.unseen_loss else None
    share = float(gain.total[0]) / whole if best is not None else 0.0
    return Score(
        candidate,
        nodes,
        share,
        gain.folds[:, 0] / evidence.fold_losses,
        unseen,
        gain.coefficients[0],
        float(novelty[nodes[0]]),
        caution=text,
    )


def admissible(candidate: Candidate, coefficients: Float) -> np.ndarray:
    """Return for each entry D of `coefficients` (D, m) whether all lie within their physical bounds."""
    effect = candidate.term.effect
    entries: Sequence[Coefficient | Shape] = [*effect.coefficients.values()] or [*effect.shape.values()][:1]
    reach = TANGENT_REACH if candidate.tangent else 1.0
    ok = np.ones(len(coefficients), dtype=bool)
    for value, entry in zip(coefficients.T, entries, strict=True):
        if entry.min is not None:
            ok &= value >= entry.min * (reach if entry.min < 0.0 else 1.0 / reach)
        if entry.max is not None:
            ok &= value <= entry.max * (reach if entry.max > 0.0 else 1.0 / reach)
    return ok


def _active(evidence: Evidence, columns: Sequence[Columns]) -> Float:
    """Return the share (V,) of training samples on which a node's columns are not zero, 0 where no fit looks at it."""
    train = columns[: len(evidence.train)]
    largest = [c.largest for c in train]
    peak = np.max([size.max(axis=1) for size in largest], axis=0)
    live = [np.mean(size > 1e-3 * peak[:, None], axis=1) for size in largest]
    whole = seen = 0.0
    for c, block in zip(train, evidence.train, strict=True):
        squares = np.square(c.flat).sum(axis=1)
        whole = whole + squares.sum(axis=1)
        seen = seen + squares @ block.use[list(c.joints)].ravel()
    return np.where((peak > 0.0) & (seen >= LEAST_SEEN * whole), np.mean(live, axis=0), 0.0)


def _groups(candidate: Candidate) -> list[np.ndarray]:
    """Return the nodes that differ between recordings, those together that share every other value."""
    own = candidate.per_recording
    moving = np.setdiff1d(np.arange(candidate.nodes.shape[1]), candidate.common)
    if not own or not moving.size:
        return []
    _, label = np.unique(np.delete(candidate.nodes[0, moving], own, axis=1), axis=0, return_inverse=True)
    return [moving[label.ravel() == k] for k in range(label.max() + 1)]


def _choices(
    evidence: Evidence, candidate: Candidate, grams: Sequence[Gram], alive: np.ndarray
) -> list[tuple[np.ndarray, Gain]]:
    """Return (nodes (R,), Gain) of what the search may choose: of the nodes that are common to all recordings the best
    with an admissible sign and the best with another, and the best of every group.
    """
    recordings = len(evidence.blocks)
    gain = evidence.gain(grams)
    common = np.intersect1d(candidate.common, np.flatnonzero(alive))
    right = admissible(candidate, gain.coefficients[common])
    out = []
    for side in (common[right], common[~right]):
        if side.size:
            v = int(side[np.argmax(gain.total[side])])
            one = Gain(gain.folds[:, v : v + 1], gain.unseen[v : v + 1], gain.coefficients[v : v + 1])
            out.append((np.full(recordings, v), one))
    groups = _groups(candidate)
    if not groups:
        return out
    by_node = [[Gram(u.g[v : v + 1], u.h[v : v + 1], u.a[v : v + 1]) for u in grams] for v in range(len(alive))]
    for group in groups:
        nodes = np.array([group[_local(evidence, candidate, grams, r, group)] for r in range(recordings)])
        out.append((nodes, evidence.gain(evidence.pick(by_node, nodes[:, None]))))
    return out


def _local(evidence: Evidence, candidate: Candidate, grams: Sequence[Gram], recording: int, group: np.ndarray) -> int:
    coefficients, gain = evidence.recording_gain(grams, recording)
    gain = np.where(admissible(candidate, coefficients), gain, -np.inf)
    return int(np.argmax(gain[group]))


def placebo(evidence: Evidence, score: Score, columns: Sequence[Columns]) -> Score:
    """Return `score` with its p-value: the share of placebos that gain as much through the same search."""
    candidate = score.candidate
    columns = [_telegraph(c, evidence.blocks[r].rate, r) for r, c in enumerate(columns)]
    nodes = candidate.common
    if nodes.size > PLACEBO_NODES:
        nodes = np.union1d(nodes[:: int(np.ceil(nodes.size / PLACEBO_NODES))], score.nodes[:1])
    null = np.full(evidence.draws, -np.inf)
    for v in nodes:
        null = np.maximum(null, _null_of(candidate, evidence.gain(evidence.shifted(columns, int(v)))))
    groups = _groups(candidate)
    by_node = {v: evidence.shifted(columns, int(v)) for group in groups for v in group}
    for group in groups:
        chosen = _local_draws(evidence, candidate, by_node, group)
        stacked = [by_node[v] for v in group]
        null = np.maximum(null, _null_of(candidate, evidence.gain(evidence.pick(stacked, chosen))))
    seen = score.share * float(evidence.fold_losses.sum())
    beaten = int(np.count_nonzero(null >= seen))
    return replace(score, p_value=(1 + beaten) / (1 + evidence.draws))


def _telegraph(columns: Columns, rate: float, seed: int) -> Columns:
    """Return columns whose constants have become random telegraphs: shifting a constant would not change it."""
    values = columns.values
    still = np.ptp(values, axis=2) <= 1e-6 * np.maximum(np.abs(values).max(axis=2), 1e-300)  # (V, A, m)
    still &= np.abs(values).max(axis=2) > 0.0
    if not still.any():
        return columns
    rng = np.random.default_rng(seed)
    count = int(np.ceil(values.shape[2] / max(1.0, TELEGRAPH * rate)))
    signs = rng.permutation(np.arange(count) % 2) * 2.0 - 1.0
    sign = np.repeat(signs, int(np.ceil(values.shape[2] / count)))[: values.shape[2]]
    return Columns(columns.joints, np.where(still[:, :, None, :], values * sign[None, None, :, None], values))


def _null_of(candidate: Candidate, gain: Gain) -> Float:
    """Return the gains (draws,) of placebos; one with a forbidden sign would not have been accepted either."""
    return np.where(admissible(candidate, gain.coefficients), gain.total, 0.0)[1:]


def _local_draws(
    evidence: Evidence, candidate: Candidate, by_node: Mapping[int, Sequence[Gram]], group: np.ndarray
) -> np.ndarray:
    """Return the place in `group` (R, D) that each recording would choose for each draw."""
    out = []
    for recording in range(len(evidence.blocks)):
        gains = []
        for v in group:
            coefficients, gain = evidence.recording_gain(by_node[v], recording)
            gains.append(np.where(admissible(candidate, coefficients), gain, -np.inf))
        out.append(np.argmax(gains, axis=0))
    return np.array(out)


def rank(
    evidence: Evidence,
    library: Library,
    model: Model,
    linear: Float,
    shape: Float,
    tick: Callable[[float, str], None] | None = None,
) -> list[Score]:
    """Return all candidates, best first: weighed, the promising ones with placebos and significance."""
    present = {term.name for term in model.terms}
    scores, columns = [], {}
    todo = [c for c in library.candidates if c.name not in present]
    for number, candidate in enumerate(todo):
        columns[candidate.name] = library.columns(candidate, model, linear, shape)
        scores.append(weigh(evidence, candidate, columns[candidate.name]))
        if tick:
            tick(0.6 * (number + 1) / len(todo), candidate.name)
    scores.sort(key=lambda s: -s.share)
    promising = [s for s in scores if s.helps][:PLACEBO_FOR]
    for number, score in enumerate(promising):
        scores[scores.index(score)] = placebo(evidence, score, columns[score.name])
        if tick:
            tick(0.6 + 0.4 * (number + 1) / len(promising), score.name)
    return _mark_significant(scores)


def _mark_significant(scores: Sequence[Score]) -> list[Score]:
    """Benjamini-Hochberg over the whole catalogue; candidates without a placebo run count with p = 1."""
    total = len(scores)
    values = sorted(s.p_value for s in scores if s.p_value is not None)
    passed = [p for k, p in enumerate(values, start=1) if p <= FALSE_DISCOVERY_RATE * k / total]
    limit = max(passed, default=0.0)
    return [
        replace(s, significant=s.p_value is not None and s.p_value <= limit and s.helps and not s.caution)
        for s in scores
    ]
