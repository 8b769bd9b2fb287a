"""The model's numbers while it runs: what changed is forgotten from when it changed on, and what came is followed too.

A change is named some time after it began. The estimator is then taken back to before that, made to forget, and given
the windows since then once more: otherwise what was learnt while both were mixed would spoil the other numbers.
"""

from __future__ import annotations

from collections import deque
from copy import deepcopy
from dataclasses import dataclass, field, replace

import numpy as np

from exoid.apps.watch.alarm import SPANS
from exoid.apps.watch.course import Onset
from exoid.apps.watch.recursive.estimator import FORGOTTEN, FORGOTTEN_LEAST, Estimator, Pace
from exoid.apps.watch.window import Window, column_errors
from exoid.diagnosis.against.questions import LEVEL, LOAD, Acting
from exoid.diagnosis.against.result import ChangeFound
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate


@dataclass(frozen=True, eq=False)
class _Moment:
    """A window, and what was known before it."""

    window: Window
    estimator: Estimator
    followed: tuple[Acting, ...]


@dataclass(eq=False)
class FollowedNumbers:
    """The estimator of a model's numbers and of those of the effects that came since; `now` gives the columns."""

    estimator: Estimator
    now: FittedModel
    followed: tuple[Acting, ...] = ()
    past: deque[_Moment] = field(default_factory=lambda: deque(maxlen=SPANS[-1]))

    @classmethod
    def started(cls, now: FittedModel, scale: Float, rate: float, pace: Pace) -> FollowedNumbers:
        """Return numbers of which little more is known than those of the model `now`; `scale` (J,) N·m is that of the
        residual, `rate` Hz that of the samples.
        """
        spread = FORGOTTEN * np.abs(now.linear) + FORGOTTEN_LEAST
        return cls(Estimator.start(now.model, now.linear, spread, scale, rate, pace), now)

    def take(self, one: Window, base: Float | None = None) -> None:
        """Learn from a window of samples as they came; `base` are the model's columns (J, K, P) there, if known."""
        self.past.append(_Moment(one, deepcopy(self.estimator), self.followed))
        self._learn(one, self.now.block_of(one).columns if base is None else base)

    def estimates(self) -> tuple[Estimate, ...]:
        """Return the numbers as they are now, those of the model first."""
        return self.estimator.estimates()

    def changed(self, found: tuple[ChangeFound, ...], since: Onset) -> None:
        """Forget what has changed `since` then, and follow what came."""
        moments = list(self.past)
        first = next((k for k, entry in enumerate(moments) if entry.window.t[-1] > since.low), len(moments))
        again = moments[first:]
        if again:
            self.estimator, self.followed = deepcopy(again[0].estimator), again[0].followed
            self.past = deque(moments[:first], maxlen=self.past.maxlen)
        for item in found:
            self._forget(item)
        for moment in again:
            if moment.window.t[0] >= since.high - 1.0:  # what is mixed says nothing of either
                self.take(moment.window)

    def _forget(self, one: ChangeFound) -> None:
        """Forget the numbers that a change can be, look-alikes included; follow what is none of the model's."""
        names, inertial = self.estimator.names, len(self.now.model.inertial)
        labels = {one.name, *one.look_alikes}
        load = any(label.startswith(f"{LOAD}:") for label in labels)
        level = (label.partition(":")[2] for label in tuple(labels) if label.startswith(f"{LEVEL}:"))
        labels |= {f"{part}:{joint}" for joint in level for part in ("coulomb", "viscous")}
        self.estimator.forget([k for k, name in enumerate(names) if name in labels or (load and k < inertial)])
        if one.kind not in ("number", "load") and one.acting is not None:
            own = tuple(f"{one.name}.{e.name}" for e in one.change)
            if set(own) <= set(names):
                self.estimator.forget([names.index(name) for name in own])
                return
            size = np.array([e.value for e in one.change])
            scale = one.acting.size / np.where(size == 0.0, 1.0, size)
            self.estimator = self.estimator.extended(own, tuple(e.unit for e in one.change), size)
            self.followed = (*self.followed, replace(one.acting, size=scale))

    def _learn(self, one: Window, base: Float) -> None:
        own = base[:, :, : len(self.now.model.parameters)]
        columns = [own, *(acting.columns(one, base, self.now) * acting.size for acting in self.followed)]
        whole: Float = np.moveaxis(np.concatenate(columns, axis=2), 0, 1)
        noise = column_errors(self.now.model, one.motion.q[one.kept], one.rough, self.now.shape)
        followed = whole.shape[2] - noise.shape[3]
        errors = np.pad(noise, ((0, 0), (0, 0), (0, 0), (0, followed)))  # of what came since, nothing is said
        self.estimator.steps(whole, (one.torque - self._known(one)).T, one.steady.T, errors)

    def _known(self, one: Window) -> Float:
        """Return the torque (J, K) that measured forces ask for without a number."""
        model = self.now.model
        if not any(force.known(model.joints) for force in model.forces):
            return np.zeros_like(one.torque)
        return one.smooth(model.whole_columns(one.motion, self.now.shape)[:, :, -1].T)
