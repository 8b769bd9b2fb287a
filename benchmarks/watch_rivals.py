"""What `exoid watch` is compared with on the same samples: a CUSUM of residuals or innovations, and `ruptures`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exoid.apps.watch.front import FrontEnd, Samples
from exoid.apps.watch.window import window
from exoid.symbolic.model import Model

CUSUM = 12.0


@dataclass(frozen=True, eq=False)
class Filtered:
    """A run as everybody gets it: time (K,), columns (K, J, P), torque (K, J), and which can be used (K, J)."""

    t: np.ndarray
    columns: np.ndarray
    tau: np.ndarray
    use: np.ndarray

    @classmethod
    def of(cls, rows: np.ndarray) -> Filtered:
        front = FrontEnd(2)
        made = Samples.joined([front.push(rows[k : k + 5000]) for k in range(0, len(rows), 5000)])
        one = window("all", made, front.filters.settled, front.filters)
        columns = np.moveaxis(one.smooth_columns(Model.standard().columns(one.motion)), 0, 1)
        return cls(one.t, columns, one.torque.T, one.used.T)

    def residual(self, learn: float = 120.0) -> np.ndarray:
        """Return the scaled residual (K, J) of least squares fitted to the first `learn` s."""
        first = self.t < learn
        use = self.use[first].ravel()
        x, y = self.columns[first].reshape(-1, self.columns.shape[2])[use], self.tau[first].ravel()[use]
        left = self.tau - self.columns @ np.linalg.lstsq(x, y, rcond=None)[0]
        return np.where(self.use, left / left[first].std(axis=0), 0.0)

    def innovations(self, learn: float = 120.0, memory: float = 60.0) -> np.ndarray:
        """Return the scaled innovations (K, J) of textbook recursive least squares with one forgetting factor."""
        keep = 1.0 - (self.t[1] - self.t[0]) / memory
        numbers, spread = np.zeros(self.columns.shape[2]), 1e4 * np.eye(self.columns.shape[2])
        out = np.zeros(self.tau.shape)
        for k, (rows, tau, use) in enumerate(zip(self.columns, self.tau, self.use, strict=True)):
            for j in np.flatnonzero(use):
                gain = spread @ rows[j]
                gain = gain / (keep + rows[j] @ gain)
                out[k, j] = tau[j] - rows[j] @ numbers
                numbers = numbers + gain * out[k, j]
                spread = (spread - np.outer(gain, rows[j] @ spread)) / keep
        first = (self.t > 0.25 * learn) & (self.t < learn)
        return out / out[first].std(axis=0)


def cusum(t: np.ndarray, left: np.ndarray, learn: float = 120.0) -> list[float]:
    """Return the alarms of a two-sided CUSUM per sample, which starts again after each."""
    high, low, alarms = np.zeros(left.shape[1]), np.zeros(left.shape[1]), []
    for now, r in zip(t, left, strict=True):
        high, low = np.maximum(0.0, high + r - 0.5), np.maximum(0.0, low - r - 0.5)
        if now > learn and max(high.max(), low.max()) > CUSUM:
            alarms.append(float(now))
            high[:], low[:] = 0.0, 0.0
    return alarms


def oracle(t: np.ndarray, left: np.ndarray) -> list[float]:
    """Return where `ruptures` cuts the squared residual."""
    import ruptures

    power = np.log(np.add.reduceat(left**2, np.arange(0, len(left), 25), axis=0) + 1e-3)
    cuts = ruptures.Pelt(model="l2", min_size=5).fit(power).predict(pen=3.0 * np.log(len(power)) * power.var())
    return [float(t[min(25 * c, len(t) - 1)]) for c in cuts[:-1]]
