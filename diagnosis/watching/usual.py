"""What is usual: the model fitted to windows from before, what is watched, and when a deviation is called one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from diagnosis.evidence.fitted import FittedModel, fitted_model
from diagnosis.evidence.gain import RecordingEvidence
from diagnosis.watching.alarm import Detector
from diagnosis.watching.questions import questions
from diagnosis.watching.scores import Scores, placebos, scores
from diagnosis.watching.settings import Settings
from diagnosis.watching.watched import Watched
from diagnosis.watching.window import Window, prepared
from optimisation.fitting.identify import identify
from symbolic.effect import Effect
from symbolic.model import Model
from symbolic.motion import Float


@dataclass(frozen=True, eq=False)
class Usual:
    """What is usual: the model fitted to windows from before, what is watched, and the detector."""

    now: FittedModel
    watched: Watched
    detector: Detector
    scale: Float
    rms: Float

    def scores(self, one: Window, block: RecordingEvidence | None = None) -> Scores:
        """Return how much of all columns a window has beyond what is usual; `block` is it as evidence, if known."""
        block = block or self.now.block_of(one)
        return scores(self.watched.columns(one, block.columns), block.residual, block.use, self.scale, block)

    def errors(self, one: Window) -> Float:
        """Return the RMS error (J,) in a window."""
        block = self.now.block_of(one)
        squares = np.sum(block.residual**2 * block.use, axis=1) / np.maximum(block.use.sum(axis=1), 1)
        return np.asarray(np.sqrt(squares))


def learned(
    model: Model, kept: Sequence[Window], usual: Sequence[Window], settings: Settings, extra: Sequence[Effect],
    rng: np.random.Generator,
) -> Usual:  # fmt: skip
    """Return what is usual: the model fitted to the `usual` windows, the detector calibrated on each of `kept`.

    ExoidError where they do not determine the model.
    """
    question = prepared(model.joints, usual)
    now = fitted_model(identify(model, question.train, optimisers=()), question)
    blocks = [now.block_of(one) for one in kept]
    scale = now.scale
    watched = Watched(questions(now, [b.columns for b in blocks], len(blocks), extra, always=False), now)
    found, chance = [], []
    for one, block in zip(kept, blocks, strict=True):
        columns = watched.columns(one, block.columns)
        found.append(scores(columns, block.residual, block.use, scale, block))
        chance.append(placebos(columns, block.residual, block, scale, settings.placebos, rng))
    detector = Detector.calibrated(found, chance, settings.block, settings.alarms_per_day)
    return Usual(now, watched, detector, scale, now.train_rms)
