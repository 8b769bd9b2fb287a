"""How much an extra column would improve the prediction of motion it was not fitted on.

Everything is linear algebra on Gram blocks, one per *unit* (a recording, or a long block where there is only one):

    G = ΣBᵀWB,  b = ΣBᵀWr   of the present model with columns B, weights W and residual r
    g = ΣBᵀWx,  h = ΣxᵀWx,  a = ΣxᵀWr   of a candidate with columns x

From these the parameters refitted on some units, and the loss on the others, follow without touching a sample. The
placebo of a candidate is the candidate itself, shifted circularly in time by another amount in every recording; FFTs
give g, h, a for all shifts at once, so the null distribution passes through the very same search as the candidate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from diagnosis.evidence.columns import Columns
from diagnosis.rules import RULES, Rules
from symbolic.motion import Float


@dataclass(frozen=True, eq=False)
class RecordingEvidence:
    """One prepared recording as the evidence sees it, all at the K kept samples.

    `columns` (J, K, P) of the present model, `residual` (J, K) N·m, `use` (J, K), `motion` (K, J) angles (to see
    where the motion repeats), `rate` Hz, `fold` (K,) number of the unit each sample belongs to.
    """

    columns: Float
    residual: Float
    use: np.ndarray
    motion: Float
    rate: float
    fold: np.ndarray


@dataclass(frozen=True, eq=False)
class Gram:
    """g (D, P, m), h (D, m, m), a (D, m) of a candidate in one unit; D = 1 + number of placebo draws."""

    g: Float
    h: Float
    a: Float


@dataclass(frozen=True, eq=False)
class Gain:
    """What a candidate gains: first entry of axis D is the candidate, the others are placebos.

    `folds` (F, D): fall of the weighted loss on each held-out unit; `unseen` (D,) the same on the verification
    recordings (zeros where there are none); `coefficients` (D, m) fitted on all training units.
    """

    folds: Float
    unseen: Float
    coefficients: Float

    @property
    def total(self) -> Float:
        """Sum over the held-out training units (D,)."""
        return self.folds.sum(axis=0)


class Evidence:
    """Gram blocks of the present model on training and verification recordings, ready to weigh candidates.

    Frozen after construction. `train` and `verify` are Blocks; `draws` shifts per recording (`shifts`, in samples; by
    default as many as `rules` say) are drawn from `seed`. `prior` (P,) is the precision with which each parameter of
    the model is held where it is, 0 for free ones.
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
        rules: Rules = RULES,
    ) -> None:
        self.train, self.verify = tuple(train), tuple(verify)
        self.rules = rules
        self.draws = draws = rules.placebos if draws is None else draws
        self.prior = np.zeros(self.train[0].columns.shape[2]) if prior is None else prior
        self.sigma = pooled_scale([(b.residual, b.use) for b in self.train]) if sigma is None else sigma
        self._units: list[tuple[int, Float]] = []
        blocks = self.train + self.verify
        for index, block in enumerate(blocks):
            weight = robust_weight(block, self.sigma, rules) / self.sigma[:, None] ** 2
            for fold in np.unique(block.fold):
                self._units.append((index, np.where(block.fold == fold, weight, 0.0)))
        self.blocks = blocks
        self.is_train = np.array([index < len(self.train) for index, _ in self._units])
        self.shifts = _draw_shifts(blocks, draws, np.random.default_rng(seed), rules)
        self._transforms: dict[tuple[int, int], tuple[np.ndarray, np.ndarray, np.ndarray]] = {}
        self._base = [self._unit_base(index, weight) for index, weight in self._units]
        self._splits = self._make_splits()

    # -- the present model ------------------------------------------------------------------------------------

    def _unit_base(self, index: int, weight: Float) -> tuple[Float, Float, float]:
        block = self.blocks[index]
        weighted = block.columns * weight[:, :, None]
        gram = np.einsum("jkp,jkq->pq", weighted, block.columns, optimize=True)
        return gram, np.einsum("jkp,jk->p", weighted, block.residual), float(np.sum(weight * block.residual**2))

    def summed(self, units: Sequence[int]) -> tuple[Float, Float, float]:
        """Return G, b and c of several units together."""
        parts = [self._base[u] for u in units]
        return np.sum([p[0] for p in parts], axis=0), np.sum([p[1] for p in parts], axis=0), sum(p[2] for p in parts)

    def _normal(self, units: Sequence[int]) -> tuple[Float, Float]:
        """Return G⁻¹, the prior included, and b of several units that are fitted together."""
        gram, slope, _ = self.summed(units)
        return inverse_of(gram + np.diag(self.prior)), slope

    def _make_splits(self) -> list[tuple[list[int], list[int], Float, Float, tuple[Float, Float, float], float]]:
        """Return (fit units, judged units, G⁻¹, base step, judged Gram, judged loss) of every split."""
        training = [u for u in range(len(self._units)) if self.is_train[u]]
        judged = [u for u in range(len(self._units)) if not self.is_train[u]]
        count = min(len(training), self.rules.most_folds)
        groups = [training[k::count] for k in range(count)]
        self.folds = count
        splits = [([u for u in training if u not in held], held) for held in groups]
        if judged:
            splits.append((training, judged))
        out = []
        for fit, held in splits:
            inverse, b = self._normal(fit)
            step = inverse @ b
            g, b, c = self.summed(held)
            loss = float(c - 2.0 * step @ b + step @ g @ step)
            out.append((fit, held, inverse, step, (g, b, c), loss))
        return out

    @property
    def fold_losses(self) -> Float:
        """Weighted loss (F,) of the present model on each held-out training unit, refitted on the others."""
        return np.array([s[5] for s in self._splits[: self.folds]])

    def portion(self, joints: Sequence[int]) -> float:
        """Return how much of the weighted squared residual of the training recordings is that of `joints`."""
        each = self.joint_losses
        return float(each[list(joints)].sum() / each.sum()) if each.any() else 0.0

    @cached_property
    def joint_losses(self) -> Float:
        """Weighted squared residual (J,) of the training recordings, joint by joint."""
        parts = [
            np.sum(robust_weight(b, self.sigma, self.rules) * b.residual**2, axis=1) / self.sigma**2 for b in self.train
        ]
        return np.asarray(np.sum(parts, axis=0))

    @property
    def unseen_loss(self) -> float:
        """Weighted loss of the present model on the verification recordings; 0 where there are none."""
        return self._splits[-1][5] if len(self._splits) > self.folds else 0.0

    # -- candidates -------------------------------------------------------------------------------------------

    def plain(self, columns: Sequence[Columns]) -> list[Gram]:
        """Return the Gram blocks of a candidate, one entry D per node of its shape parameters; no placebos."""
        out = []
        for index, weight in self._units:
            block, x = self.blocks[index], columns[index]
            joints = list(x.joints)
            weighted = x.flat * weight[joints].ravel()
            nodes, width, samples = weighted.shape
            # Plain products: for so many small ones the overhead of einsum was the larger part.
            own = np.column_stack([block.columns[joints].reshape(samples, -1), block.residual[joints].ravel()])
            both = (weighted.reshape(-1, samples) @ own).reshape(nodes, width, -1)
            g, a = np.swapaxes(both[:, :, :-1], 1, 2), both[:, :, -1]
            out.append(Gram(g, weighted @ np.swapaxes(x.flat, 1, 2), a))
        return out

    def shifted(self, columns: Sequence[Columns], node: int) -> list[Gram]:
        """Return the Gram blocks of one node (first) and of its circularly shifted placebos."""
        return [self._shifted_unit(unit, columns[self._units[unit][0]], node) for unit in range(len(self._units))]

    def _shifted_unit(self, unit: int, columns: Columns, node: int) -> Gram:
        index, _ = self._units[unit]
        take = np.concatenate([[0], self.shifts[index]])
        _, _, samples, width = columns.values.shape
        g = np.zeros((take.size, self.blocks[index].columns.shape[2], width))
        h, a = np.zeros((take.size, width, width)), np.zeros((take.size, width))
        for joint, x in zip(columns.joints, columns.values[node], strict=True):
            base, residual, weight = self._transform(unit, joint)
            fx = np.conj(np.fft.rfft(x, axis=0))
            for m in range(width):
                g[:, :, m] += np.fft.irfft(fx[:, m, None] * base, samples, axis=0)[take]
                a[:, m] += np.fft.irfft(fx[:, m] * residual, samples)[take]
                for n in range(m, width):
                    product = np.conj(np.fft.rfft(x[:, m] * x[:, n]))
                    h[:, m, n] += np.fft.irfft(product * weight, samples)[take]
        for m in range(width):
            for n in range(m):
                h[:, m, n] = h[:, n, m]
        return Gram(g, h, a)

    def _transform(self, unit: int, joint: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if (unit, joint) not in self._transforms:
            index, weight = self._units[unit]
            block, w = self.blocks[index], weight[joint]
            self._transforms[unit, joint] = (
                np.fft.rfft(w[:, None] * block.columns[joint], axis=0),
                np.fft.rfft(w * block.residual[joint]),
                np.fft.rfft(w),
            )
        return self._transforms[unit, joint]

    def gain(self, grams: Sequence[Gram], ridge: float | None = None) -> Gain:
        """Return what a candidate with these Gram blocks (one per unit) gains on units it was not fitted on.

        `ridge` is relative to the candidate's own Gram matrix, by default that of `rules`.
        """
        folds, unseen, coefficients = [], None, None
        count = self.folds
        for number, split in enumerate(self._splits):
            fall, fitted = _split_gain(split, grams, self.ridge(ridge))
            if number < count:
                folds.append(fall)
            else:
                unseen, coefficients = fall, fitted
        if coefficients is None:
            coefficients = self._fit_all(grams, ridge)[0]
            unseen = np.zeros(len(coefficients))
        return Gain(np.array(folds), np.asarray(unseen), coefficients)

    @property
    def count(self) -> int:
        """How many units there are."""
        return len(self._units)

    def unit(self, number: int) -> tuple[int, Float]:
        """Return the recording index and the weights (J, K) of a unit."""
        return self._units[number]

    def held_out_fits(self, grams: Sequence[Gram], ridge: float | None = None) -> list[tuple[int, Float, Float]]:
        """Return (unit, base step (P,), candidate coefficients (m,)) for every judged unit, fitted on the others."""
        out = []
        for fit, held, inverse, step, _, _ in self._splits:
            coefficients, base, _ = fit_candidate(inverse, step, [grams[u] for u in fit], self.ridge(ridge))
            out += [(unit, base[0], coefficients[0]) for unit in held]
        return out

    def leave_one_out(self, grams: Sequence[Gram], ridge: float | None = None) -> Float:
        """Return the candidate's coefficients (F, m) fitted without each training unit in turn (first entry of D)."""
        count = self.folds
        return np.array([_split_gain(split, grams, self.ridge(ridge))[1][0] for split in self._splits[:count]])

    def recording_gain(self, grams: Sequence[Gram], index: int) -> tuple[Float, Float]:
        """Return coefficients (D, m) and gain (D,) when only recording `index` is fitted, base and candidate alike."""
        units = self._units_of(index)
        inverse, slope = self._normal(units)
        step = inverse @ slope
        return fit_candidate(inverse, step, [grams[u] for u in units], self.ridge(None))[::2]

    def gain_once(self, grams: Sequence[Gram], index: int, step: Float) -> Float:
        """Return the gain (D,) on recording `index` of a candidate's only column as it is, nothing fitted, the model's
        own numbers moved by `step` (D, P).
        """
        parts = [grams[u] for u in self._units_of(index)]
        return np.sum([2.0 * (u.a[:, 0] - np.sum(step * u.g[:, :, 0], axis=1)) - u.h[:, 0, 0] for u in parts], axis=0)

    def step_beside(self, grams: Sequence[Gram]) -> Float:
        """Return how the model's own numbers move (D, P) when all training units are fitted beside a candidate."""
        fit = [u for u in range(len(self._units)) if self.is_train[u]]
        inverse, slope = self._normal(fit)
        return fit_candidate(inverse, inverse @ slope, [grams[u] for u in fit], self.ridge())[1]

    def _units_of(self, index: int) -> list[int]:
        return [u for u in range(len(self._units)) if self._units[u][0] == index]

    def pick(self, grams_by_node: Sequence[Sequence[Gram]], nodes: np.ndarray) -> list[Gram]:
        """Return Gram blocks made of node `nodes` (R, D) of each recording; `grams_by_node` is [node][unit]."""
        out = []
        for unit, (index, _) in enumerate(self._units):
            chosen, entries = nodes[index], np.arange(nodes.shape[1])
            stacked = [np.stack([getattr(node[unit], k) for node in grams_by_node]) for k in ("g", "h", "a")]
            out.append(Gram(*(values[chosen, entries] for values in stacked)))
        return out

    def novelty(self, grams: Sequence[Gram]) -> Float:
        """Return the share (D,) of the candidate that the present model cannot imitate, its weakest direction."""
        fit = [u for u in range(len(self._units)) if self.is_train[u]]
        inverse, _ = self._normal(fit)
        g, h = sum(grams[u].g for u in fit), sum(grams[u].h for u in fit)
        scale = np.sqrt(np.maximum(np.einsum("dmm->dm", h), 1e-300))
        norm = scale[:, :, None] * scale[:, None, :]
        left = (h - np.swapaxes(g, 1, 2) @ inverse @ g) / norm
        whole = np.where(np.isfinite(h / norm), h / norm, 0.0)
        # Two columns of one entry may resemble each other; what counts is that the best of them is new.
        return np.linalg.eigvalsh(left)[:, -1] / np.maximum(np.linalg.eigvalsh(whole)[:, -1], 1e-300)

    def ridge(self, ridge: float | None = None) -> tuple[float, float]:
        """Return the relative ridge and the least scale it is relative to."""
        return self.rules.ridge if ridge is None else ridge, self.rules.least_scale

    def fitted(self, grams: Sequence[Gram], ridge: float | None = None) -> tuple[Float, Float]:
        """Return a candidate's coefficients (m,) and the step (P,) of the model's own numbers, both fitted to all
        training units (first entry of D).
        """
        coefficients, base = self._fit_all(grams, ridge)
        return coefficients[0], base[0]

    def _fit_all(self, grams: Sequence[Gram], ridge: float | None) -> tuple[Float, Float]:
        fit = [u for u in range(len(self._units)) if self.is_train[u]]
        inverse, slope = self._normal(fit)
        step = inverse @ slope
        return fit_candidate(inverse, step, [grams[u] for u in fit], self.ridge(ridge))[:2]


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


def _draw_shifts(
    blocks: Sequence[RecordingEvidence], draws: int, rng: np.random.Generator, rules: Rules
) -> list[np.ndarray]:
    """Return (draws,) shifts in samples for each recording, away from zero and from repeats of the motion."""
    out = []
    for block in blocks:
        samples = len(block.motion)
        least = min(int(rules.min_shift * block.rate), samples // 4)
        centred = block.motion - block.motion.mean(axis=0)
        spectrum = np.abs(np.fft.rfft(centred, axis=0)) ** 2
        alike = np.fft.irfft(spectrum, samples, axis=0)
        alike = (alike / np.maximum(alike[:1], 1e-300)).mean(axis=1)
        lag = np.arange(samples)
        allowed = (lag >= least) & (lag <= samples - least)
        fresh = np.flatnonzero(allowed & (alike < rules.repeats))
        out.append(rng.choice(fresh if fresh.size > 20 else np.flatnonzero(allowed), size=draws))
    return out


def inverse_of(gram: Float) -> Float:
    """Return the inverse of a Gram matrix, pseudo where columns depend on each other; scaled first."""
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    norm = np.outer(scale, scale)
    return np.linalg.pinv(gram / norm, rcond=1e-11, hermitian=True) / norm


def fit_candidate(
    inverse: Float, step: Float, grams: Sequence[Gram], ridge: tuple[float, float]
) -> tuple[Float, Float, Float]:
    """Return candidate coefficients (D, m), the base step (D, P) refitted with them, and the gain (D,) on the fit."""
    g = sum(gram.g for gram in grams)
    h = sum(gram.h for gram in grams)
    a = sum(gram.a for gram in grams)
    # Without products of one small matrix for each draw: NumPy takes longer to begin them than to do them.
    lean = np.tensordot(np.swapaxes(g, 1, 2), inverse, 1)  # (D, m, P); the inverse is symmetric
    schur = h - np.einsum("dmp,dpn->dmn", lean, g)
    scale = np.sqrt(np.maximum(np.einsum("dmm->dm", h), 1e-300))
    # A column that the fitted units hardly show must not escape the ridge by being small.
    scale = np.maximum(scale, ridge[1] * scale.max(axis=1, keepdims=True))
    normal = schur / (scale[:, :, None] * scale[:, None, :]) + ridge[0] * np.eye(schur.shape[1])
    right = a - step @ g
    if right.shape[1] == 1:
        coefficients = right / scale / normal[:, 0] / scale
    else:
        coefficients = np.linalg.solve(normal, (right / scale)[:, :, None])[:, :, 0] / scale
    base = step - np.einsum("dmp,dm->dp", lean, coefficients)
    return coefficients, base, np.sum(coefficients * right, axis=1)


def _split_gain(split: tuple, grams: Sequence[Gram], ridge: tuple[float, float]) -> tuple[Float, Float]:
    fit, held, inverse, step, (gram, slope, constant), loss = split
    coefficients, base, _ = fit_candidate(inverse, step, [grams[u] for u in fit], ridge)
    g = sum(grams[u].g for u in held)
    h = sum(grams[u].h for u in held)
    a = sum(grams[u].a for u in held)
    after = (
        constant
        - 2.0 * base @ slope
        - 2.0 * np.sum(coefficients * a, axis=1)
        + np.sum((base @ gram) * base, axis=1)
        + 2.0 * np.sum(base * np.einsum("dpm,dm->dp", g, coefficients), axis=1)
        + np.sum(coefficients * np.einsum("dmn,dn->dm", h, coefficients), axis=1)
    )
    return loss - after, coefficients
