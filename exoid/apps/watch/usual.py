"""The usual state: the model fitted to windows from before, what is watched, and when a deviation is called one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from exoid.apps.watch.alarm import Detector
from exoid.apps.watch.scores import Scores, placebos, scores
from exoid.apps.watch.settings import Settings
from exoid.apps.watch.watched import Watched
from exoid.apps.watch.window import Window, prepared
from exoid.diagnosis.against.questions import Asked, questions
from exoid.diagnosis.against.result import Differences
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model, pooled_rms
from exoid.diagnosis.evidence.gain import RecordingEvidence
from exoid.ground.thresholds import Threshold
from exoid.optimisation.fitting.identify import identify
from exoid.symbolic.effect import Effect
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

GROWN: Threshold = 1.5
"""times the usual error from which a change without a name is no longer called small, and to which a name may leave it:
what leaves more is the nearest entry, not the answer
"""
REST: Threshold = 0.1
"""share of the grown squared error that a name may leave where it is above that: wrong names"""


@dataclass(frozen=True, eq=False)
class Usual:
    """The usual state: the model fitted to windows from before, what is watched, and the detector."""

    now: FittedModel
    watched: Watched
    detector: Detector
    scale: Float
    rms: Float
    largest: Float = field(default_factory=lambda: np.zeros(1))
    """The largest error (J,) in what was usual."""
    asked: Mapping[str, Asked] = field(default_factory=dict, repr=False)
    """{name: whatever may change}"""

    def scores(self, one: Window, block: RecordingEvidence | None = None) -> Scores:
        """Return the scores of all columns in a window beyond what is usual; `block` is it as evidence, if known."""
        block = block or self.now.block_of(one)
        return scores(self.watched.columns(one, block.columns), block.residual, block.use, self.scale, block)

    def grown_in(self, one: Window) -> Float:
        """Error of a window as a multiple of the usual error (J,)."""
        return self.grown(pooled_rms([self.now.block_of(one).residual], [one]))

    def grown(self, rms: Sequence[float] | Float) -> Float:
        """Error as a multiple of the usual error (J,)."""
        return np.array(rms) / np.maximum(self.rms, 1e-300)

    def explains(self, answer: Differences) -> bool:
        """True if what was found explains what has grown, at every joint."""
        grown, left = self.grown(answer.rms_after), self.grown(answer.rms_named)
        rest = (left**2 - 1.0) / np.maximum(grown**2 - 1.0, 1e-300)
        return bool(np.all((left <= GROWN) | (rest <= REST)))


def learned(
    model: Model, kept: Sequence[Window], usual: Sequence[Window], settings: Settings, extra: Sequence[Effect],
    rng: np.random.Generator,
) -> Usual:  # fmt: skip
    """Return the usual state: the model fitted to the `usual` windows, the detector calibrated on each of `kept`.

    ExoidError where they do not determine the model.
    """
    question = prepared(model.joints, usual)
    now = fitted_model(identify(model, question.train, optimisers=()), question)
    blocks = [now.block_of(entry) for entry in kept]
    scale = now.scale
    may = questions(now, extra)
    watched = Watched(may, now)
    found, chance = [], []
    for item, block in zip(kept, blocks, strict=True):
        columns = watched.columns(item, block.columns)
        found.append(scores(columns, block.residual, block.use, scale, block))
        chance.append(placebos(columns, block.residual, block, scale, settings.placebos, rng))
    detector = Detector.calibrated(found, chance, settings.block, settings.alarms_per_day)
    asked = {item.name: item for item in may}
    largest = np.max([np.max(np.abs(b.residual) * b.use, axis=1) for b in blocks], axis=0)
    return Usual(now, watched, detector, scale, now.train_rms, largest, asked)
