"""The model at its numbers: its torque, columns and sensitivities on every recording, and what it leaves.

The columns include the derivative by every shape parameter, so that a candidate is never credited with what a small
change of a shape already explains.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from exoid.diagnosis.evidence.gain import Evidence, RecordingEvidence, pooled_scale
from exoid.diagnosis.rules import RULES, Rules
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.fitting.local_shape import own_of_halves, own_shapes, shapes_for
from exoid.optimisation.fitting.shapes import slope_by_shape
from exoid.optimisation.linear.loss import huber_terms
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.optimisation.preparation.noise import mean_square
from exoid.optimisation.preparation.prepare import Prepared, judged_anew
from exoid.symbolic.evaluation import carrying
from exoid.symbolic.memory import sensor_delays
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

SLOPE_STEP = 1e-3
"""Step of the derivative by a shape parameter, as a share of its range."""
OFFSET_ROUNDS, SETTLED_OFFSET = 8, 0.05
"""Times at most that an offset is found beside a model whose shape moves with it, and the last step, in standard
deviations of what is left.
"""


@dataclass(frozen=True, eq=False)
class FittedModel:
    """A model at the numbers of `fit`, on all prepared recordings (training first), with its residuals (J, K) N·m.

    `shapes` (R, S) are the shape values in every recording, `slack` (S,) how far the data leave each of them open (a
    standard deviation).
    """

    fit: Fit
    shapes: Float
    residuals: tuple[Float, ...]
    prepared: Prepared
    slack: Float

    @property
    def model(self) -> Model:
        """The model that was fitted."""
        return self.fit.model

    @property
    def linear(self) -> Float:
        """Linear parameters (P,)."""
        return self.fit.linear

    @property
    def shape(self) -> Float:
        """Shape values (S,), the middle of those of the training recordings."""
        return self.fit.shape

    def torque(self, index: int) -> Float:
        """Return the torque (J, K) of recording `index` after the common filter, N·m."""
        return _filtered_torque(self.model, self.prepared.all[index], self.linear, self.shapes[index])

    @property
    def verified(self) -> bool:
        """True if there are verification recordings."""
        return bool(self.prepared.verify)

    @property
    def evaluation_rms(self) -> Float:
        """RMS residual (J,) in N·m that a reader is shown: of verification recordings, of fitted ones without any."""
        return pooled_rms(self.residuals[self._first :], self.prepared.all[self._first :])

    @property
    def train_rms(self) -> Float:
        """RMS residual (J,) over the training recordings, N·m."""
        return pooled_rms(self.residuals[: len(self.prepared.train)], self.prepared.train)

    @property
    def verify_rms(self) -> Float | None:
        """RMS residual (J,) over the verification recordings, N·m; None without any."""
        return self.evaluation_rms if self.prepared.verify else None

    @property
    def _first(self) -> int:
        """Index of the first recording that is taken as unseen: where none is held out, all are."""
        return len(self.prepared.train) if self.prepared.verify else 0

    @property
    def _used(self) -> list[tuple[Float, np.ndarray]]:
        """Residual (J, K) and use (J, K) of every recording."""
        return [(r, p.used) for r, p in zip(self.residuals, self.prepared.all, strict=True)]

    @property
    def unseen_scale(self) -> Float:
        """Robust standard deviation (J,) of the unseen residual, N·m."""
        return pooled_scale(self._used[self._first :])

    def unseen_loss(self, scale: Float, rules: Rules = RULES) -> float:
        """Return the Huber loss of the unseen residual in units of `scale` (J,), both joints together."""
        return float(sum(np.sum(loss) for loss in self._losses(scale, rules)[self._first :]))

    @property
    def scale(self) -> Float:
        """Robust standard deviation (J,) of the residual of all recordings, N·m."""
        return pooled_scale(self._used)

    def block_losses(self, scale: Float, rules: Rules = RULES) -> Float:
        """Return the Huber loss in strides, or blocks of time, recording after recording, in units of `scale` (J,)."""
        return np.asarray(self.joint_losses(scale, rules).sum(axis=0))

    def joint_losses(self, scale: Float, rules: Rules = RULES) -> Float:
        """Return that loss joint by joint (J, blocks)."""
        pairs = zip(self._losses(scale, rules), self.prepared.all, strict=True)
        parts = [np.add.reduceat(loss, item.starts(rules.block_seconds), axis=1) for loss, item in pairs]
        return np.concatenate(parts, axis=1)

    def recording_losses(
        self,
        scale: Float,
        rules: Rules = RULES,
        cuts: Mapping[int, int] = MappingProxyType({}),
        beside: Prepared | None = None,
    ) -> list[Float]:
        """Return the loss in blocks of each recording, all joints together; of those that are cut at a sample, in
        blocks of what comes before it and after it. Blocks are those of the recordings `beside` which it is compared:
        at other times a motion may have other strides.
        """
        out, recordings = [], (beside or self.prepared).all
        for k, (loss, item) in enumerate(zip(self._losses(scale, rules), recordings, strict=True)):
            for first, last in itertools.pairwise(sorted({0, cuts.get(k, 0), loss.shape[1]})):
                starts = item.starts_within(rules.block_seconds, first, last)
                out.append(np.add.reduceat(loss[:, first:last].sum(axis=0), starts))
        return out

    def _losses(self, scale: Float, rules: Rules) -> list[Float]:
        """Return the loss (J, K) of the samples of each recording."""
        return [huber_terms(np.where(use, np.abs(r), 0.0) / scale[:, None], rules.robust) for r, use in self._used]

    @property
    def per_recording(self) -> list[tuple[str, Float]]:
        """Name and RMS residual (J,) of every recording."""
        return [(p.name, pooled_rms([r], [p])) for p, r in zip(self.prepared.all, self.residuals, strict=True)]

    def evidence(
        self, *, seed: int, draws: int | None = None, sigma: Float | None = None, rules: Rules = RULES
    ) -> Evidence:
        """Return the evidence that weighs missing effects, in units of `sigma` (J,) N·m, by default its own scale."""
        count = len(self.prepared.train)
        moving = np.sum([recording.used.any(axis=1) for recording in self.prepared.train], axis=0)
        # Without the only recording in which a joint moves nothing would be known of it: then parts are left out.
        parts = [rules.blocks if np.any(moving == 1) else 1] * count + [1] * len(self.prepared.verify)
        every, zeroed = zip(self.prepared.all, self.shapes, self.residuals, parts, strict=True), self.prepared.zeroed
        # Of zeros that were found beside another model a little is left, which is no effect.
        blocks = [_block(self.model, item, self.linear, *rest).beside_offsets(zeroed) for item, *rest in every]
        train, held = blocks[:count], blocks[count:]
        # Slopes describe small changes of a shape value: a split that hardly shows it must not run off along one.
        free = np.zeros(len(self.model.parameters))
        prior = np.concatenate([free, (rules.robust * self.slack) ** -2.0, np.zeros(len(zeroed))])
        friction = self.model.friction.start, self.linear[self.model.friction].reshape(-1, 2)
        return Evidence(train, held, seed=seed, draws=draws, sigma=sigma, prior=prior, friction=friction, rules=rules)

    def unfiltered(self, index: int) -> tuple[Float, Float]:
        """Return the columns (J, N, P) on recording `index` before the common filter, and the torque (J, N) there that
        is known: of loads, and of measured forces.
        """
        model, motion, count = self.model, self.prepared.all[index].motion, len(self.linear)
        whole = model.whole_columns(motion, self.shapes[index], self.linear if model.needs_reference else None)
        return whole[:, :, :count], whole @ carrying(model, motion, np.zeros(count))

    def block_of(self, one: PreparedRecording) -> RecordingEvidence:
        """Return any prepared recording as the evidence sees it, at the numbers of this model."""
        return _block(self.model, one, self.linear, self.shape, one.torque - self.torque_on(one), 1)

    def torque_on(self, one: PreparedRecording) -> Float:
        """Return the torque (J, K) on any prepared recording after the common filter, N·m."""
        return _filtered_torque(self.model, one, self.linear, self.shape)

    def judged_anew(self) -> Prepared:
        """Return the recordings with spikes of the torques judged anew beside this model."""
        pairs = zip(self.prepared.all, self.shapes, strict=True)
        return judged_anew(self.prepared, [self.model.torque(item.motion, self.linear, at) for item, at in pairs])

    def shown_later(self) -> Prepared:
        """Return the recordings with moments hidden in which late torques of this model show that a joint may stick."""
        delays = [sensor_delays(self.model, at) for at in self.shapes]
        done = [item.shown_later(late) for item, late in zip(self.prepared.all, delays, strict=True)]
        same = all(new is old for new, old in zip(done, self.prepared.all, strict=True))
        return self.prepared if same else self.prepared.with_recordings(done)

    def judged_by_halves(self) -> FittedModel:
        """Return the model with what it leaves of each half of a recording where the values that belong to the
        recording are fitted to the other half.
        """
        if not own_shapes(self.model):
            return self
        return replace(self, residuals=tuple(_by_halves(self.fit, item) for item in self.prepared.all))

    def on(self, prepared: Prepared) -> FittedModel:
        """Return the same model with the same numbers on other versions of the recordings."""
        residuals = _residuals(self.model, self.linear, self.shapes, prepared)
        return replace(self, residuals=residuals, prepared=prepared)


def fitted_model(fit: Fit, prepared: Prepared) -> FittedModel:
    """Return the fitted model on training and verification recordings.

    Shape values that belong to a recording are fitted to each recording; of what is left of an unseen one each half is
    judged by those of the other. Everything else is as fitted on the training recordings.
    """
    model = fit.model
    shapes = shapes_for(fit, prepared)
    residuals = _residuals(model, fit.linear, shapes, prepared)
    if own_shapes(model):
        seen = residuals[: len(prepared.train)]
        residuals = (*seen, *(_by_halves(fit, recording) for recording in prepared.verify))
    return FittedModel(fit, shapes, residuals, prepared, _slack(fit, model))


def fitted_on(fit: Fit, prepared: Prepared) -> FittedModel:
    """Return a model on all recordings, whichever of them it was fitted to."""
    return fitted_model(fit_as_of(fit, prepared), prepared)


def refitted(model: Model, known: FittedModel, prepared: Prepared) -> FittedModel:
    """Return a model on other versions of the recordings of a `known` one, whose terms it has or fewer, fitted from the
    shape values of that.
    """
    fit = identify(model, prepared.train, optimisers=(), start=shapes_from(known, model, len(prepared.train)))
    return fitted_model(fit, prepared)


def beside_offsets(now: FittedModel) -> FittedModel:
    """Return a model fitted anew beside the offsets that it asks for of all recordings at joints whose zeros were found
    beside another model: only how these differ is known. Itself where recordings have none.
    """
    zeroed = list(now.prepared.zeroed)
    for _ in range(OFFSET_ROUNDS if zeroed else 0):
        evidence = now.evidence(seed=0, draws=0)
        offset = np.zeros(len(evidence.sigma))
        offset[zeroed] = evidence.fits(evidence.is_train[None]).step[0, -len(zeroed) :]
        recordings = [item.beside_own(np.tile(offset, (len(item.wide_tau), 1))) for item in now.prepared.all]
        now = refitted(now.model, now, now.prepared.with_recordings(recordings))
        if np.all(np.abs(offset) <= SETTLED_OFFSET * evidence.sigma):
            break
    return now


def shapes_from(known: FittedModel, model: Model, count: int) -> Float | None:
    """Return the shape values of a `known` model that another one has, too: (S,), or (R, S) of the first `count`
    recordings where these have some of their own; None where it has none.
    """
    places = {entry.name: k for k, entry in enumerate(known.model.shapes)}
    shapes = known.shapes[:count, [places[entry.name] for entry in model.shapes]]
    if not model.shapes:
        return None
    return shapes if own_shapes(model) else np.median(shapes, axis=0)


def fit_as_of(fit: Fit, prepared: Prepared) -> Fit:
    """Return a fit to other recordings, or to stretches, as one of these: with the same shape values in each."""
    if len(fit.shapes) == len(prepared.train):
        return fit
    return replace(fit, shapes=np.broadcast_to(fit.shape, (len(prepared.train), len(fit.shape))))


def lag(loss: Float, least: Float) -> float:
    """Return by how many standard errors a model's loss in blocks of time is above the least one's; 0 for itself."""
    difference = loss - least
    spread = float(np.sqrt(np.sum((difference - difference.mean()) ** 2)))
    return float(difference.sum()) / spread if spread > 1e-9 * float(least.sum()) else 0.0


def places_pay(once: FittedModel, each: FittedModel, rules: Rules = RULES) -> bool:
    """True if places that recordings have to themselves (`each`) are better than the same place in all (`once`): with
    places found in the other half of a recording, the torque is predicted clearly better.
    """
    fixed, moving = (item.judged_by_halves().block_losses(once.scale, rules) for item in (once, each))
    return lag(fixed, moving) >= rules.clear


def _by_halves(fit: Fit, one: PreparedRecording) -> Float:
    """Residual (J, K) of a recording, each half with its own values as the other half has them."""
    first, second = (one.torque - _filtered_torque(fit.model, one, fit.linear, at) for at in own_of_halves(fit, one))
    middle = first.shape[1] // 2
    return np.concatenate([first[:, :middle], second[:, middle:]], axis=1)


def _slack(fit: Fit, model: Model) -> Float:
    """Return the standard deviation (S,) of each shape value, a part of its range at least and at most."""
    known = {e.name: (e.high - e.low) / (2.0 * 1.96) for e in fit.estimates}
    spread = np.array([known.get(s.name, np.nan) for s in model.shapes], dtype=float)
    ranges = np.array([s.shape.max - s.shape.min for s in model.shapes], dtype=float)
    return np.clip(np.where(np.isfinite(spread), spread, np.inf), 1e-4 * ranges, 0.02 * ranges)


def _residuals(model: Model, linear: Float, shapes: Float, prepared: Prepared) -> tuple[Float, ...]:
    pairs = zip(prepared.all, shapes, strict=True)
    return tuple(item.torque - _filtered_torque(model, item, linear, shape) for item, shape in pairs)


def _filtered_torque(model: Model, one: PreparedRecording, linear: Float, shape: Float) -> Float:
    """Return the model's torque (J, K) after the common filter, N·m."""
    return one.smooth(model.torque(one.motion, linear, shape))


def pooled_rms(residuals: Sequence[Float], prepared: Sequence[PreparedRecording]) -> Float:
    """Return the RMS (J,) of residuals (J, K) over the usable samples of several recordings."""
    return np.sqrt(mean_square(residuals, prepared))


def _block(
    model: Model, one: PreparedRecording, linear: Float, shape: Float, residual: Float, parts: int
) -> RecordingEvidence:
    raw = model.columns(one.motion, shape, linear if model.needs_reference else None)
    columns = [raw]
    for k, entry in enumerate(model.shapes):
        slope = np.zeros(raw.shape[:2])  # by a choice
        if not entry.shape.choices:
            slope = slope_by_shape(lambda at: model.torque(one.motion, linear, at), shape, k, entry.shape, SLOPE_STEP).T
        columns.append(slope[:, :, None])
    smooth = one.smooth_columns(np.concatenate(columns, axis=2))
    path = one.motion.q[one.kept]
    return RecordingEvidence(smooth, residual, one.used, path, one.kept_rate, one.parts(parts), one.starts)
