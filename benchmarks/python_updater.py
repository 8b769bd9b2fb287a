"""The recursive estimator as a controller runs it, in Python: what `exoid export --updater` writes in C is compared
with it, one sample per period of its loop, nothing else.
"""

from __future__ import annotations

import numpy as np

from exoid.apps.watch.front import COMMON_ORDER, SIGN_WIDTH, Filters, FrontEnd, poles
from exoid.apps.watch.updater import first_estimator
from exoid.apps.watch.window import STEADY, column_errors
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion


class Updater:
    """Follows the numbers of `model` from identified ones on, at the sampling `rate` in Hz of the loop."""

    def __init__(self, model: Model, linear: Float, shape: Float, unit: Float, rate: float, cutoff: float) -> None:
        joints = len(model.joints)
        self.model, self.linear, self.shape = model, np.asarray(linear, dtype=float), shape
        self.filters = Filters(rate, cutoff)
        self.front = FrontEnd(joints, cutoff)
        self.front.begin_at(self.filters, 0.0)
        self.estimator = first_estimator(model, self.linear, unit, self.filters.working / self.filters.stride)
        width = len(model.parameters) + 2
        self.state = np.zeros((COMMON_ORDER, joints, width))
        self.count = 0

    def push(self, samples: Float) -> None:
        """Take samples (N, 1 + 2 J: t, q, tau), one per period, in any portions."""
        made = self.front.push(np.atleast_2d(samples))
        if not len(made):
            return
        motion = Motion(made.t, made.q, made.dq, made.ddq, np.tanh(made.dq / SIGN_WIDTH))
        reference = self.linear if self.model.needs_reference else None
        columns = np.moveaxis(self.model.columns(motion, self.shape, reference), 1, 2)  # (J, P, N)
        weight = made.good.T[:, None, :]
        whole = np.concatenate([weight, weight * made.tau.T[:, None, :], weight * columns], axis=1)
        done, self.state = poles(whole, self.filters.common, self.state)
        first = -self.count % self.filters.stride
        self.count += len(made)
        errors = column_errors(self.model, made.q, self.filters.roughness * made.noise, self.shape)
        for k in range(first, len(made), self.filters.stride):
            total = np.maximum(done[:, 0, k], 1e-6)
            use = done[:, 0, k] > STEADY
            self.estimator.step(done[:, 2:, k] / total[:, None], done[:, 1, k] / total, use, errors[k])
