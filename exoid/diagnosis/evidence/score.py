"""Fall of the error of motion that a candidate was not fitted on, with coefficients that physics allows."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.diagnosis.evidence.agreement import Agreement
from exoid.diagnosis.evidence.candidates import Candidate, LateColumns
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.gram import ABSORBED, Gain, Gram
from exoid.diagnosis.rules import Rules
from exoid.ground.ties import TIED, index_of_greatest, tied
from exoid.symbolic.effect import Coefficient, Shape
from exoid.symbolic.motion import Float

ROUNDS = 4
"""Times that recordings choose values of their own beside the numbers they share."""
TOGETHER = 10_000
"""Nodes times placebos that are fitted at once: more need memory, and wait for it."""


@dataclass(frozen=True, eq=False)
class Score:
    """Score of one candidate by the evidence.

    `nodes` (R,) index of the shape node in each recording; shares are falls of the weighted loss relative to the
    present model: `share` on held-out training units, `joint_share` that of the joints it acts on alone, `folds` (F,)
    on each, `unseen` on verification recordings (None without). `helps`: it lowers the error where it was not fitted.
    `agreement` is what splits of the recordings say, None where they were not asked, `steady` whether enough of them
    agree (where they cannot tell, whether the held-out recordings do).
    `p_value` is None where no placebo was run. `caution` says in words what speaks against it.
    """

    candidate: Candidate
    nodes: np.ndarray
    share: float
    folds: Float
    unseen: float | None
    coefficients: Float
    helps: bool = False
    agreement: Agreement | None = None
    steady: bool = True
    p_value: float | None = None
    significant: bool = False
    caution: str = ""
    joint_share: float = 0.0

    @property
    def name(self) -> str:
        """Full name of the candidate."""
        return self.candidate.name

    @property
    def eligible(self) -> bool:
        """True if it may be accepted if it is not chance: it helps, with a possible sign, in enough splits."""
        return self.helps and self.steady and not self.caution

    def repeats(self, rules: Rules) -> bool:
        """True if nearly all splits of many recordings support it."""
        return self.agreement is not None and self.agreement.repeats(rules)

    def agrees(self, rules: Rules) -> bool:
        """True if it is told of many recordings, and enough of their splits that can tell support it."""
        agreement = self.agreement
        return agreement is not None and agreement.recordings >= rules.many_recordings and agreement.enough(rules)

    @property
    def shape(self) -> Float:
        """Shape values (R, S) on each recording."""
        return self.candidate.nodes[np.arange(len(self.nodes)), self.nodes]

    @property
    def start(self) -> Float:
        """Shape values (R, S) at which a refit begins: of what has no coefficients, the first number as many times as
        its column was needed, inside its bounds.
        """
        if self.candidate.term.effect.coefficients:
            return self.shape
        first, *others = self.candidate.term.placed_shape.values()
        typical = [0.5 * (item.min + item.max) if item.typical is None else item.typical for item in others]
        begun = np.tile([1.0, *typical], (len(self.nodes), 1)) if self.candidate.tangent else self.shape.copy()
        begun[:, 0] = np.clip(begun[:, 0] * self.coefficients[0], first.min, first.max)
        return begun


def share_of_own_joints(score: Score, before: Float, floor: Float) -> float:
    """Return the share of the error (RMS `before` (J,)) of its own joints that a candidate explains on motion it was
    not fitted to, at most all that is above the noise (`floor` (J,)).
    """
    at = list(score.candidate.joints)
    return min(score.joint_share, above_noise(before[at], floor[at]))


def above_noise(before: Float, after: Float) -> float:
    """Return by what share of itself the squared error falls from one RMS (J,) to another."""
    return max(0.0, 1.0 - float(np.sum(after**2) / max(float(np.sum(before**2)), 1e-300)))


def weigh(evidence: Evidence, candidate: Candidate, columns: Sequence[Columns]) -> Score:
    """Return the score of a candidate at its best node, without placebos."""
    grams, active = _looked_at(evidence, columns)
    rules = evidence.rules
    alive = (evidence.novelty(grams) > ABSORBED) & (active >= rules.negligible)
    possible = alive & _friction_is_possible(evidence, candidate, grams)
    if not possible.any():
        nodes = np.zeros(len(columns), dtype=int)
        blank = np.zeros(len(evidence.fold_losses))
        text = "the model's own parameters already contain it, on this motion"
        if alive.any():
            text = "dry or viscous friction of its joint would be negative beside it"
        return Score(candidate, nodes, 0.0, blank, 0.0, np.zeros(grams.h.shape[1]), caution=text)
    best: tuple[np.ndarray, Gain] | None = None
    wrong, whole = 0.0, float(evidence.fold_losses.sum())
    choices = _choices(evidence, candidate, grams, possible)
    for nodes, gain in choices:
        right = admissible(candidate, gain.coefficients, rules)[0]
        total = float(gain.total[0])
        if right and (best is None or total > best[1].total[0] + TIED * whole):
            best = nodes, gain
        elif not right:
            wrong = max(wrong, total)
    if best is None or wrong > 2.0 * max(float(best[1].total[0]), 0.0):
        nodes, gain = best or choices[0]
        text = "fits best with a sign that this effect cannot have" if wrong > rules.least_share * whole else ""
    else:
        (nodes, gain), text = best, ""
    if candidate.term.effect.family == "drift" and len(evidence.blocks) == 1:
        text = text or "a drift comes once in a recording, and one recording shows many other things once"
    unseen = float(gain.unseen[0] / evidence.unseen_loss) if evidence.unseen_loss else None
    share = float(gain.total[0]) / whole if best is not None else 0.0
    folds = gain.folds[:, 0] / np.where(evidence.fold_losses > 0.0, evidence.fold_losses, np.inf)
    losses = evidence.joint_losses
    own = float(losses[list(columns[0].joints)].sum())
    joint_share = min(1.0, share * float(losses.sum()) / own) if own else 0.0
    helps = share >= rules.least_share and (unseen is None or unseen >= rules.least_share)
    if candidate.reads_torque:  # one that is misread leaves much
        helps = helps and joint_share >= rules.little
    found = Score(candidate, nodes, share, folds, unseen, gain.coefficients[0], helps, caution=text)
    return replace(found, steady=harmless(rules, gain.folds[:, 0]), joint_share=joint_share)


def _looked_at(evidence: Evidence, columns: Sequence[Columns]) -> tuple[Gram, Float]:
    """Return the Gram blocks of a candidate, and the share (V,) of samples on which a node is active."""
    late = [c for c in columns if isinstance(c, LateColumns)]
    if late and len(late) == len(columns):
        each = [c.sums(*evidence.signals(index, c.joints)) for index, c in enumerate(late)]
        found = [products for products in each if products is not None]
        if len(found) == len(columns):
            train = found[: len(evidence.train)]
            whole, seen = (np.sum([np.trace(p.square[k], axis1=1, axis2=2) for p in train], axis=0) for k in (-2, -1))
            active = _share_active(evidence, [p.largest for p in train], whole, seen)
            both = np.concatenate([p.both for p in found]).transpose(0, 3, 2, 1)
            square = np.concatenate([p.square[: len(p.both)] for p in found]).transpose(0, 2, 3, 1)
            return Gram(np.concatenate([both, square], axis=1)), active
    parts = [[c.some(piece) for c in columns] for piece in columns[0].pieces]
    pieces = [(evidence.plain(part), _active(evidence, part)) for part in parts]
    grams = Gram(np.concatenate([gram.rows for gram, _ in pieces], axis=-1))
    return grams, np.concatenate([share for _, share in pieces])


def harmless(rules: Rules, gains: Float) -> bool:
    """True if what held-out recordings lose is small beside what the others gain.

    `gains` (F,) are in units of the pooled residual, so that a quiet recording, which can only lose little torque, does
    not outvote loud ones. Where splits of the recordings can tell, they decide instead.
    """
    lost, won = float(-gains[gains < 0.0].sum()), float(gains[gains > 0.0].sum())
    return lost <= rules.little * won


def admissible(candidate: Candidate, coefficients: Float, rules: Rules) -> np.ndarray:
    """Return for each entry D of `coefficients` (D, m) whether all lie within their physical bounds.

    That of a `change` is how many times it is there.
    """
    effect = candidate.term.effect
    if candidate.change:
        return np.asarray(coefficients[:, 0] >= 0.0)  # in the direction that its value says
    entries: Sequence[Coefficient | Shape] = [*effect.coefficients.values()] or [*candidate.term.placed_shape.values()][
        :1
    ]
    reach = rules.artefact if candidate.tangent else 1.0
    ok = np.ones(len(coefficients), dtype=bool)
    for value, entry in zip(coefficients.T, entries, strict=True):
        if entry.min is not None:
            ok &= value >= entry.min * (reach if entry.min < 0.0 else 1.0 / reach)
        if entry.max is not None:
            ok &= value <= entry.max * (reach if entry.max > 0.0 else 1.0 / reach)
    return ok


def _friction_is_possible(evidence: Evidence, candidate: Candidate, grams: Gram) -> np.ndarray:
    """Mask (V,) of the nodes beside which the friction that a candidate bends stays positive."""
    if evidence.friction is None or not candidate.term.effect.bends_friction:
        return np.ones(grams.rows.shape[-1], dtype=bool)
    (first, numbers), joint = evidence.friction, candidate.term.first
    place = first + 2 * joint
    return np.all(numbers[joint][:, None] + evidence.step_beside(grams)[place : place + 2] >= 0.0, axis=0)


def _active(evidence: Evidence, columns: Sequence[Columns]) -> Float:
    """Return the share (V,) of training samples on which a node's columns are not zero, 0 where no fit looks at it."""
    largest: list[Float] = []
    whole: Float = np.zeros(())
    seen = whole
    for c, block in zip(columns, evidence.train, strict=False):  # strictly the first, which are fitted
        nodes, count, samples, width = c.values.shape
        if c.is_absent:
            largest.append(np.zeros((nodes, samples)))
            continue
        squares = np.square(c.flat)  # NumPy is slow in reductions over short axes: they are taken apart
        total = functools.reduce(np.add, [squares[:, m] for m in range(width)])
        whole = whole + total.sum(axis=1)
        seen = seen + total @ block.use[list(c.joints)].ravel().astype(float)
        parts = [squares[:, m, a * samples : (a + 1) * samples] for m in range(width) for a in range(count)]
        largest.append(functools.reduce(np.maximum, parts))
    return _share_active(evidence, largest, whole, seen)


def _share_active(evidence: Evidence, largest: Sequence[Float], whole: Float, seen: Float) -> Float:
    """Return the share (V,) of samples at which a node is not zero, from the `largest` squares (V, K) in recordings; 0
    where too little of the sum of squares, `whole` (V,), is `seen` (V,) by a fit.
    """
    peak = np.max([size.max(axis=1) for size in largest], axis=0)
    live = [np.count_nonzero(size > 1e-6 * peak[:, None], axis=1) / size.shape[1] for size in largest]
    return np.where((peak > 0.0) & (seen >= evidence.rules.least_share * whole), np.mean(live, axis=0), 0.0)


def _choices(evidence: Evidence, candidate: Candidate, grams: Gram, alive: np.ndarray) -> list[tuple[np.ndarray, Gain]]:
    """Return (nodes (R,), Gain) of what the search may choose: of the nodes that are common to all recordings the best
    with an admissible sign and the best with another, and the best of every group.
    """
    recordings = len(evidence.blocks)
    gain = evidence.gain(grams)
    common = np.intersect1d(candidate.common, np.flatnonzero(alive))
    right = admissible(candidate, gain.coefficients[common], evidence.rules)
    out = []
    for side in (common[right], common[~right]):
        if side.size:
            v = int(side[index_of_greatest(gain.total[side], float(evidence.fold_losses.sum()))])
            out.append((np.full(recordings, v), gain.entry(v)))
    if groups := candidate.groups:
        nodes = np.column_stack([v[own_nodes(evidence, candidate, grams.entries(v[:, None]))[:, 0]] for v in groups])
        gain = evidence.gain(evidence.pick(grams.entries(slice(None), None), nodes))
        out += [(own, gain.entry(k)) for k, own in enumerate(nodes.T)]
    return out


def own_nodes(evidence: Evidence, candidate: Candidate, grams: Gram) -> np.ndarray:
    """Nodes (R, D) that each recording chooses for itself; D of `grams` is (V, D).

    A recording is fitted alone, base and candidate alike. Not where the candidate is a change of the model's torque: a
    delay would hide behind friction that all recordings share. There the model's numbers are those of all recordings,
    and the choice is repeated beside what was chosen.
    """
    many, entries = grams.rows.shape[3:]
    parts = np.array_split(np.arange(entries), -(-many * entries // TOGETHER))
    if not candidate.change:
        chosen = [_best_alone(evidence, candidate, grams.entries(slice(None), part)) for part in parts]
        return np.concatenate(chosen, axis=1)
    step: Float = np.zeros((len(evidence.prior), entries))
    loss = float(evidence.fold_losses.sum())
    for _ in range(ROUNDS):
        gains = (evidence.gains_once(grams.entries(slice(None), part), step[:, None, part]) for part in parts)
        nodes = np.concatenate([np.argmax(tied(-gain, loss, axis=1), axis=1) for gain in gains], axis=1)
        step = evidence.step_beside(evidence.pick(grams, nodes))
    return nodes


def _best_alone(evidence: Evidence, candidate: Candidate, grams: Gram) -> np.ndarray:
    """Return the node (R, D) at which a candidate gains most where each recording is fitted alone."""
    shape = grams.rows.shape[3:]
    flat = Gram(grams.rows.reshape(*grams.rows.shape[:-2], -1), grams.lift)
    coefficients, _, gain = evidence.alone.candidate(flat)
    right = [admissible(candidate, each.T, evidence.rules) for each in coefficients]
    best = tied(-np.where(right, gain, -np.inf).reshape(-1, *shape), float(evidence.fold_losses.sum()), axis=1)
    return np.asarray(np.argmax(best, axis=1))
