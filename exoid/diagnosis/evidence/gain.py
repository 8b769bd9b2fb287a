"""The gain of an extra column: by how much it improves the prediction of motion it was not fitted on.

Everything is linear algebra on Gram blocks, one per *unit* (a recording, or a long block where there is only one):

    G = ΣBᵀWB,  b = ΣBᵀWr   of the present model with columns B, weights W and residual r
    g = ΣBᵀWx,  h = ΣxᵀWx,  a = ΣxᵀWr   of a candidate with columns x

From these the parameters refitted on some units, and the loss on the others, follow without touching a sample. The
placebo of a candidate is the candidate itself, shifted circularly in time by another amount in every recording; FFTs
give g, h, a for all shifts at once, so the null distribution passes through the very same search as the candidate.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations_with_replacement

import numpy as np

from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.gram import RIDGE, Fits, Gain, Gram, HeldOut, inverse_of, largest_eigenvalue
from exoid.diagnosis.rules import RULES, Rules
from exoid.symbolic.motion import Float

TOGETHER = 20_000
"""Values of columns that are multiplied at once: more no longer fit into a processor's cache."""
ROUNDING = 0.01
"""Part of a gain by which ridges, which differ from split to split, may bend what a fit leaves room for."""
FEW = 16
"""Columns of a model at a joint up to which they are taken as they are: those that span them are hardly fewer."""
SPANNED = 1e-10
"""Size of a direction of these columns, of the largest, that is rounding."""


@dataclass(frozen=True, eq=False)
class RecordingEvidence:
    """One prepared recording as the evidence sees it, all at the K kept samples.

    `columns` (J, K, P) of the present model, `residual` (J, K) N·m, `use` (J, K), `motion` (K, J) angles (to see
    where the motion repeats), `rate` Hz, `fold` (K,) number of the unit each sample belongs to. `starts` gives the
    samples at which blocks begin that are compared with one another: strides, or stretches of so many seconds.
    """

    columns: Float
    residual: Float
    use: np.ndarray
    motion: Float
    rate: float
    fold: np.ndarray
    starts: Callable[[float], np.ndarray]

    def beside_offsets(self, joints: Sequence[int]) -> RecordingEvidence:
        """Return the same with an offset of the torque at each of the joints (indices) among the columns, the last."""
        each = np.eye(len(self.residual))[:, None, list(joints)]
        offsets = np.repeat(each, self.residual.shape[1], axis=1)
        return replace(self, columns=np.concatenate([self.columns, offsets], axis=2))


class Evidence:
    """Gram blocks of the present model on training and verification recordings, ready to weigh candidates.

    Frozen after construction. `units` are the recordings' indices and weights (J, K), `of` (U,) the former alone;
    `draws` shifts per recording (by default as many as `rules` say) are drawn from `seed`. `prior` (P,) is the
    precision with which each parameter of the model is held where it is, 0 for free ones. `friction` is the place of
    the first number of friction among them, and dry and viscous friction (J, 2) of every joint; None where nobody asks
    for them.
    """

    def __init__(
        self,
        train: Sequence[RecordingEvidence],
        verify: Sequence[RecordingEvidence],
        *,
        seed: int,
        draws: int | None = None,
        sigma: Float | None = None,
        prior: Float | None = None,
        friction: tuple[int, Float] | None = None,
        rules: Rules = RULES,
    ) -> None:
        self.friction = friction
        self.train, self.verify = tuple(train), tuple(verify)
        self.rules = rules
        self.seed, self.draws = seed, rules.placebos if draws is None else draws
        self.prior = np.zeros(self.train[0].columns.shape[2]) if prior is None else prior
        self.sigma = pooled_scale([(b.residual, b.use) for b in self.train]) if sigma is None else sigma
        self.blocks, self.units, bases = self.train + self.verify, list[tuple[int, Float]](), []
        for index, block in enumerate(self.blocks):
            columns = block.columns.reshape(-1, block.columns.shape[2])
            whole = robust_weight(block, self.sigma, rules) / self.sigma[:, None] ** 2
            for fold in np.unique(block.fold):
                weight = np.where(block.fold == fold, whole, 0.0)
                self.units.append((index, weight))
                weighted = columns * weight.ravel()[:, None]
                square = float(np.sum(weight * block.residual**2))
                bases.append((weighted.T @ columns, weighted.T @ block.residual.ravel(), square))
        self._base = [np.array(part) for part in zip(*bases, strict=True)]
        self.of = np.array([index for index, _ in self.units])
        self.is_train = self.of < len(self.train)
        self._kept: dict[tuple[int, tuple[int, ...]], tuple[slice, Float, Float]] = {}
        self._spans: dict[tuple[int, ...], tuple[Float, list[Float]]] = {}
        self._transforms: dict[tuple[int, tuple[int, ...]], list[tuple[np.ndarray, np.ndarray]]] = {}
        # Every split fits some training units and holds out the others, the last one the verification recordings.
        training = np.flatnonzero(self.is_train)
        self.folds = min(len(training), rules.most_folds)
        held = np.zeros((self.folds + (not self.is_train.all()), len(self.units)))
        for k in range(self.folds):
            held[k, training[k :: self.folds]] = 1.0
        held[self.folds :] = ~self.is_train
        self._fits, self._held_out = self.fits(self.is_train * (1.0 - held)), self.held_out(held)
        self._losses = self._held_out.loss(self._fits.step[:, :, None])[:, 0]

    @cached_property
    def basis(self) -> Float:
        """Orthonormal columns (samples, P) that span the model's on the used samples of the fitted recordings."""
        known = np.concatenate([block.columns[block.use] for block in self.train])
        return np.asarray(np.linalg.qr(known / np.maximum(np.linalg.norm(known, axis=0), 1e-300))[0])

    def forget(self) -> None:
        """Let go of what is made of the model's columns for candidates, and is made again where more are weighed."""
        for kept in (self._kept, self._spans, self._transforms):
            kept.clear()

    # -- the present model ------------------------------------------------------------------------------------

    def pooled(self, units: np.ndarray) -> tuple[Float, Float, Float]:
        """Return G (S, P, P), b (S, P) and c (S,) of the units that are one in each of `units` (S, U)."""
        gram, slope, constant = (np.tensordot(units * 1.0, part, 1) for part in self._base)
        return gram, slope, constant

    def held_out(self, units: np.ndarray) -> HeldOut:
        """Return the units that are one in each of `units` (S, U) as what is held out."""
        return HeldOut(units * 1.0, *self.pooled(units))

    def fits(self, units: np.ndarray) -> Fits:
        """Return the present model fitted to the units that are one in each of `units` (S, U)."""
        gram, slope, _ = self.pooled(units)
        inverse = inverse_of(gram + np.diag(self.prior))
        return Fits(units * 1.0, inverse, (inverse @ slope[:, :, None])[:, :, 0])

    def left(self, index: int, step: Float, columns: Columns | None = None, coefficients: Float | None = None) -> Float:
        """Residual (J, K) of a recording after a step (P,) of the model's own numbers, and beside columns
        (one node) with their coefficients (m,).
        """
        block = self.blocks[index]
        out = block.residual - block.columns @ step
        if columns is not None:
            out[list(columns.joints)] -= columns.values[0] @ coefficients
        return np.asarray(out)

    @cached_property
    def _together(self) -> Fits:
        """The present model fitted to all training units."""
        return self.fits(self.is_train[None])

    @cached_property
    def alone(self) -> Fits:
        """The present model fitted to each recording alone."""
        return self.fits(self.of == np.arange(len(self.blocks))[:, None])

    @property
    def fold_losses(self) -> Float:
        """Weighted loss (F,) of the present model on each held-out training unit, refitted on the others."""
        return self._losses[: self.folds]

    @cached_property
    def joint_losses(self) -> Float:
        """Weighted squared residual (J,) of the training recordings, joint by joint."""
        units = [(self.blocks[index].residual, weight) for index, weight in self.units if index < len(self.train)]
        return np.asarray(np.sum([np.sum(weight * residual**2, axis=1) for residual, weight in units], axis=0))

    @property
    def unseen_loss(self) -> float:
        """Weighted loss of the present model on the verification recordings; 0 where there are none."""
        return float(self._losses[-1]) if len(self._losses) > self.folds else 0.0

    # -- candidates -------------------------------------------------------------------------------------------

    def plain(self, columns: Sequence[Columns]) -> Gram:
        """Return the Gram blocks of a candidate, one entry D per node of its shape parameters; no placebos."""
        nodes, _, _, width = columns[0].values.shape
        rows = np.zeros((len(self.units), self.prior.size + 1 + width, width, nodes))
        for unit, into in enumerate(rows):
            if (entry := columns[self.of[unit]]).is_absent:
                continue
            part, weight, own = self._own(unit, entry.joints)
            x = entry.within(part)
            samples = x.shape[2]
            some = max(1, TOGETHER // max(1, width * samples))
            # Plain products: for so many small ones the overhead of einsum was the larger part.
            for at in range(0, nodes, some):
                each = x[at : at + some]
                both = (each.reshape(len(each) * width, samples) @ own).reshape(len(each), width, -1)
                into[:-width, :, at : at + some] = both.transpose(2, 1, 0)
                into[-width:, :, at : at + some] = ((each * weight) @ np.swapaxes(each, 1, 2)).transpose(1, 2, 0)
        return Gram(rows)

    def signals(self, index: int, joints: tuple[int, ...]) -> tuple[Float, Float]:
        """Return the weights (S + 2, A, K) at `joints` of a recording's units, of all its samples and of those that a
        fit looks at, and the weighted columns and residual (S, A, K, P + 1) of the present model for the S units.
        """
        block, rows = self.blocks[index], list(joints)
        weights = np.array([weight[rows] for of, weight in self.units if of == index])
        both = np.concatenate([block.columns[rows], block.residual[rows, :, None]], axis=2)
        use = block.use[rows].astype(float)
        return np.concatenate([weights, np.ones((1, *use.shape)), use[None]]), weights[..., None] * both

    def _own(self, unit: int, joints: tuple[int, ...]) -> tuple[slice, Float, Float]:
        """Return the samples that a unit reaches, their weights (A·K,) at `joints`, and the weighted columns and
        residual (A·K, P + 1) of the present model there.
        """
        if (unit, joints) not in self._kept:
            index, weight = self.units[unit]
            block, rows = self.blocks[index], list(joints)
            live = np.flatnonzero(weight.any(axis=0))
            part = slice(int(live[0]), int(live[-1]) + 1) if live.size else slice(0, 0)
            w = weight[rows, part].ravel()
            both = np.concatenate([block.columns[rows, part], block.residual[rows, part, None]], axis=2)
            self._kept[unit, joints] = part, w, w[:, None] * both.reshape(w.size, both.shape[2])
        return self._kept[unit, joints]

    def shifted(
        self, columns: Sequence[Columns], node: int, *, trained: bool = False, by: Sequence[np.ndarray] | None = None
    ) -> Gram:
        """Return the Gram blocks of the circularly shifted placebos of one node; `trained`: zero for all but the
        training units, `by`: shifted by these numbers of samples (D,) in every recording instead of those drawn.
        """
        shifts = self.shifts if by is None else by
        width, lift = columns[0].values.shape[3], self._span(columns[0].joints)[0]
        rows = np.zeros((len(self.units), lift.shape[1] + 1 + width, width, len(shifts[0])))
        for index in range(len(self.train) if trained else len(self.blocks)):
            if not columns[index].is_absent:
                spectra = _spectra(columns[index], node)  # of all parts of a recording
                for unit in np.flatnonzero(self.of == index):
                    self._shift_unit(int(unit), columns[index], spectra, shifts[index], rows[unit])
        return Gram(rows, lift)

    @cached_property
    def shifts(self) -> list[np.ndarray]:
        """Shifts (draws,) of the placebos in every recording, in samples."""
        rng = np.random.default_rng(self.seed)
        return [_draw_shifts(block, self.draws, rng, self.rules) for block in self.blocks]

    @cached_property
    def different_shifts(self) -> tuple[list[np.ndarray], np.ndarray]:
        """Shifts (D,) in every recording without repetition, and which of them each placebo has: a single recording is
        shifted alike again and again.
        """
        different, back = np.unique(np.stack(self.shifts), axis=1, return_inverse=True)
        return list(different), back.ravel()

    def shifted_gains(self, columns: Sequence[Columns], node: int, ridge: float = RIDGE) -> Float:
        """Gains (draws,) of the placebos of one node; those that are shifted alike are fitted once."""
        different, back = self.different_shifts
        grams = self.shifted(columns, node, by=different)
        return np.asarray(self.gain(grams, ridge).total[back])

    def exceed(self, grams: Gram, least: float, allowed: Callable[[Float], np.ndarray]) -> np.ndarray:
        """Mask (D,) of the entries of shifted placebos that gain `least` or more on training units they were not fitted
        on, with coefficients (D, m) that are `allowed`.

        On what it was not fitted to a model loses no less than on the same units when they are fitted with the rest.
        So nothing can gain more than a fit to all of them leaves room for, and the others need no splits.
        """
        coefficients, gain = self._together.gain(grams, self.prior)
        room = self._spare + gain[0]
        out = np.asarray(allowed(coefficients[0].T) & (room >= least - ROUNDING * abs(least)))
        if out.any():
            out[out] = self.gain(grams.entries(out)).total >= least
        return out

    @cached_property
    def _spare(self) -> float:
        """By how much the fit to all training units leaves less of them, with what holding its numbers costs, than the
        splits among them do.
        """
        step = self._together.step
        least = self.held_out(self.is_train[None]).loss(step[:, :, None])[0, 0]
        return float(self.fold_losses.sum() - least - self.prior @ step[0] ** 2)

    def _shift_unit(
        self,
        unit: int,
        columns: Columns,
        spectra: Sequence[tuple[np.ndarray, np.ndarray]],
        shifts: np.ndarray,
        into: Float,
    ) -> None:
        """Write the Gram blocks of the columns, shifted by `shifts` (D,) samples, into (L + 1 + m, m, D)."""
        _, _, samples, width = columns.values.shape
        crossed = squared = 0.0
        transforms = self._transform(unit, columns.joints)
        for (base, weight), (single, paired) in zip(transforms, spectra, strict=True):
            crossed = crossed + single * base[:, None]
            squared = squared + paired * weight
        both, square = np.fft.irfft(crossed, samples), np.fft.irfft(squared, samples)
        for each, row in zip(both, into, strict=False):
            np.take(each, shifts, axis=-1, out=row, mode="clip")  # which writes without a copy
        for each, (first, second) in zip(square, _pairs(width), strict=True):
            into[-width + first, second] = into[-width + second, first] = each[shifts]

    def _transform(self, unit: int, joints: tuple[int, ...]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return at each of `joints` the transforms of the weighted columns that span the model's, with the residual,
        and of the weights.
        """
        if (unit, joints) not in self._transforms:
            index, weight = self.units[unit]
            found = []
            for joint, columns in zip(joints, self._span(joints)[1][index], strict=True):
                both = np.concatenate([columns.T, self.blocks[index].residual[[joint]]])
                found.append((np.fft.rfft(weight[joint] * both), np.fft.rfft(weight[joint])))
            self._transforms[unit, joints] = found
        return self._transforms[unit, joints]

    def _span(self, joints: tuple[int, ...]) -> tuple[Float, list[Float]]:
        """Return `lift` (P, L), and of every recording L columns (A, K, L) that span the model's at `joints`: of many
        numbers of a machine a joint shows few, and what is multiplied with each of its columns is, with each of these.
        """
        if joints not in self._spans:
            parts = [block.columns[list(joints)] for block in self.blocks]
            whole = np.concatenate([part.reshape(-1, part.shape[2]) for part in parts])
            length = np.linalg.norm(whole, axis=0)
            live = np.flatnonzero(length)
            size, turned = np.ones(live.size), np.eye(live.size)
            if live.size > FEW:
                size = length[live]
                spread, turned = np.linalg.svd(np.linalg.qr(whole[:, live] / size, mode="r"))[1:]
                turned = turned[spread > SPANNED * spread[0]]
            lift = np.zeros((length.size, len(turned)))
            lift[live] = turned.T * size[:, None]
            self._spans[joints] = lift, [part[:, :, live] @ (turned / size).T for part in parts]
        return self._spans[joints]

    def gain(self, grams: Gram, ridge: float = RIDGE) -> Gain:
        """Gain of a candidate with these Gram blocks on units it was not fitted on."""
        coefficients, step, _ = self._fits.candidate(grams, ridge)
        falls = self._losses[:, None] - self._held_out.loss_beside(grams, coefficients, step)
        if len(falls) > self.folds:
            return Gain(falls[:-1], falls[-1], coefficients[-1].T)
        return Gain(falls, np.zeros(falls.shape[1]), self._together.candidate(grams, ridge)[0][0].T)

    def would_gain(self, grams: Gram, coefficients: Float) -> tuple[Float, Float]:
        """Return by how much the loss on the held-out training units (D,), and on the verification recordings (D,),
        would fall with a candidate of these `coefficients` (m,) if it were there, and noise were not.
        """
        falls = self._held_out.would_fall(self._fits, grams, coefficients)
        return falls[: self.folds].sum(axis=0), falls[self.folds :].sum(axis=0)

    def held_out_fits(self, grams: Gram, ridge: float = RIDGE) -> list[tuple[int, Float, Float]]:
        """Return (unit, base step (P,), candidate coefficients (m,)) for every held-out unit, fitted on the others."""
        coefficients, step, _ = self._fits.candidate(grams, ridge)
        return [(int(u), step[s, :, 0], coefficients[s, :, 0]) for s, u in np.argwhere(self._held_out.units)]

    def leave_one_out(self, grams: Gram, ridge: float = RIDGE) -> Float:
        """Return the candidate's coefficients (F, m) fitted without each training unit in turn (first entry of D)."""
        return self._fits.candidate(grams, ridge)[0][: self.folds, :, 0]

    def gains_once(self, grams: Gram, step: Float) -> Float:
        """Return the gain (R, ...) on each recording of a candidate's only column as it is, nothing fitted, the model's
        own numbers moved by `step` (P, ...); both may have axes of their own in D.
        """
        each = grams.of(self.alone.units)
        # Sums with all of the model's columns would take gigabytes for an arm: its step along those few is enough.
        few = step if each.lift is None else np.tensordot(each.lift.T, step, 1)
        of_step = np.einsum("p...,rp...->r...", few, each.few[:, :, 0])
        return np.asarray(2.0 * (each.a[:, 0] - of_step) - each.h[:, 0, 0])

    def step_beside(self, grams: Gram) -> Float:
        """Steps (P, D) of the model's own numbers when all training units are fitted beside a candidate."""
        return self._together.candidate(grams)[1][0]

    def pick(self, grams: Gram, nodes: np.ndarray) -> Gram:
        """Return Gram blocks made of node `nodes` (R, D) of each recording; D of `grams` is (V, D), or (V, 1)."""
        entries, of = np.arange(nodes.shape[1]) % grams.rows.shape[-1], nodes[self.of]
        rows = np.stack([unit[..., chosen, entries] for unit, chosen in zip(grams.rows, of, strict=True)])
        return Gram(rows, grams.lift)

    def novelty(self, grams: Gram) -> Float:
        """Return the share (D,) of the candidate that the present model cannot imitate, its weakest direction."""
        train = grams.of(self._together.units)
        g, h = train.g[0], train.h[0]
        scale = np.sqrt(np.maximum(np.einsum("mmd->md", h), 1e-300))
        norm = scale[:, None] * scale[None]
        lean = (self._together.inverse[0] @ g.reshape(len(g), -1)).reshape(g.shape)
        left = (h - np.einsum("pmd,pnd->mnd", g, lean)) / norm
        whole = np.where(np.isfinite(h / norm), h / norm, 0.0)
        # Two columns of one entry may resemble each other; what counts is that the best of them is new.
        return largest_eigenvalue(left) / np.maximum(largest_eigenvalue(whole), 1e-300)

    def fitted(self, grams: Gram) -> tuple[Float, Float]:
        """Return a candidate's coefficients (m,) and the step (P,) of the model's own numbers, both fitted to all
        training units (first entry of D).
        """
        coefficients, step, _ = self._together.candidate(grams)
        return coefficients[0, :, 0], step[0, :, 0]


def _pairs(count: int) -> list[tuple[int, int]]:
    """Return all pairs of so many columns, each with itself, too."""
    return list(combinations_with_replacement(range(count), 2))


def _spectra(columns: Columns, node: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the conjugate transforms of the columns of one node, and of their products, at each of its joints."""
    out, pairs = [], _pairs(columns.values.shape[3])
    for x in columns.values[node]:
        rows = np.ascontiguousarray(x.T)
        products = [rows[[first]] * rows[[second]] for first, second in pairs]
        both = np.conj(np.fft.rfft(np.concatenate([rows, *products])))
        out.append((both[: len(rows)], both[len(rows) :]))
    return out


def _draw_shifts(block: RecordingEvidence, draws: int, rng: np.random.Generator, rules: Rules) -> np.ndarray:
    """Return shifts (draws,) of a recording in samples, away from zero and from repeats of its motion."""
    samples, lag = len(block.motion), np.arange(len(block.motion))
    least = min(int(rules.min_shift * block.rate), samples // 4)
    centred = block.motion - block.motion.mean(axis=0)
    alike = np.fft.irfft(np.abs(np.fft.rfft(centred, axis=0)) ** 2, samples, axis=0)
    alike = (alike / np.maximum(alike[:1], 1e-300)).mean(axis=1)
    allowed = (lag >= least) & (lag <= samples - least)
    fresh = np.flatnonzero(allowed & (alike < rules.half))
    return rng.choice(fresh if fresh.size > 20 else np.flatnonzero(allowed), size=draws)


def pooled_scale(parts: Sequence[tuple[Float, np.ndarray]]) -> Float:
    """Return the robust standard deviation (J,) of pairs (residual (J, K) N·m, use (J, K)) together."""
    out = []
    for joint in range(len(parts[0][0])):
        values = np.concatenate([residual[joint][use[joint]] for residual, use in parts])
        out.append(max(float(np.median(np.abs(values))) / 0.6745, 1e-12) if values.size else 1.0)
    return np.array(out)


def robust_weight(block: RecordingEvidence, sigma: Float, rules: Rules = RULES) -> Float:
    """Return the weights (J, K) that make the squares of the present residual a bound of its Huber loss.

    Bursts and reversals count linearly (Huber 1964): a few hundred bad samples must not drown what all others say.
    """
    size = np.maximum(np.abs(block.residual), 1e-300)
    return block.use * np.minimum(1.0, rules.robust * sigma[:, None] / size)
