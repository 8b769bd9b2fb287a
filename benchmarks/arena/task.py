"""What an entry is given, what it gives back, and the truth, which it never sees."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.measurement.recording import Recording
from exoid.measurement.signals.conditioning import derivatives, low_pass
from exoid.optimisation.preparation.filtering import reaches
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion

BAND = 4.0
"""Hz below which a predicted torque is judged; angles of the motion asked are filtered at twice this."""
SLOW = 0.05
"""Share of a usual velocity below which a joint may stick: what holds it then follows from no motion."""
EDGE = 0.5
"""s at both ends of the motion that are not judged: a filter knows nothing beyond them."""


class Left(Exception):
    """A case or an entry that cannot run here, and why: a tool is missing."""


@dataclass(frozen=True, eq=False)
class Task:
    """What an entry gets: the `model` without what is hidden, recordings of one machine, and the angles `q` (N, J) at
    `t` (N,) of one more motion, whose torque nobody tells.
    """

    model: Model
    recordings: tuple[Recording, ...]
    t: Float
    q: Float

    @property
    def motion(self) -> Motion:
        """The motion whose torque is asked, filtered and differentiated as anybody would."""
        rate = 1.0 / float(np.median(np.diff(self.t)))
        q = low_pass(self.q, 2.0 * BAND, rate)
        dq, ddq = derivatives(q, rate)
        return Motion(self.t, q, dq, ddq, np.tanh(dq / (0.01 * reaches(self.model.joints))))


@dataclass(frozen=True, eq=False)
class Answer:
    """What an entry says: what is missing (each name first, then what it cannot distinguish from it), the torque (N, J)
    of the motion asked, and a verdict where it gives one.
    """

    names: Sequence[Sequence[str]]
    torque: Float
    verdict: str = ""


@dataclass(frozen=True, eq=False)
class Run:
    """A recording as the instruments show it, and the true motion and torque (N, J) behind it."""

    recording: Recording
    motion: Motion
    torque: Float


@dataclass(frozen=True, eq=False)
class Sealed:
    """A case drawn: its runs, the last of which is asked; what is `hidden`, by name; `noise` (J,) of the torque, N·m.

    `judged`: whether the torque of the last run can be compared with a prediction at all. `told` is the verdict that an
    entry with verdicts must give, "" for any.
    """

    model: Model
    runs: tuple[Run, ...]
    hidden: tuple[str, ...]
    noise: Float
    judged: bool = True
    told: str = ""

    @property
    def task(self) -> Task:
        """What entries are given of it."""
        *fitted, asked = (run.recording for run in self.runs)
        return Task(self.model, tuple(fitted), asked.t, asked.q)

    @property
    def in_band(self) -> Float:
        """Noise (J,) of the torque sensors below BAND, N·m."""
        return self.noise * np.sqrt(2.0 * BAND / self.runs[0].recording.rate)

    def away(self, torque: Float) -> float:
        """Return the error of a torque (N, J) predicted for the motion asked, in units of noise in the band; the mean
        over the joints' RMS.
        """
        last = self.runs[-1]
        rate = last.recording.rate
        wrong = low_pass(np.asarray(torque) - last.torque, BAND, rate)
        rms = np.sqrt(_mean(wrong**2, _moving(last, self.model)))
        return float(np.mean(rms / self.in_band))

    @property
    def size(self) -> float:
        """RMS of what the model as it is cannot imitate of the true torques, refitted to them, in units of noise in the
        band; that of the joint that shows most.
        """
        x, y, used = [], [], []
        for run in self.runs:
            rate = run.recording.rate
            x.append(low_pass(np.moveaxis(self.model.columns(run.motion), 1, 0), BAND, rate))
            y.append(low_pass(run.torque, BAND, rate))
            used.append(_moving(run, self.model))
        columns, torque, use = (np.concatenate(parts) for parts in (x, y, used))
        a, b = (columns * use[:, :, None]).reshape(-1, columns.shape[-1]), (torque * use).ravel()
        left = (b - a @ np.linalg.lstsq(a, b, rcond=None)[0]).reshape(torque.shape)
        return float(np.max(np.sqrt(_mean(left**2, use)) / self.in_band))


def _moving(run: Run, model: Model) -> np.ndarray:
    """Return where each joint moves (N, J), away from the ends."""
    use = np.abs(run.motion.dq) > SLOW * reaches(model.joints)
    edge = int(EDGE * run.recording.rate)
    use[:edge] = use[-edge:] = False
    return use


def _mean(x: Float, use: np.ndarray) -> Float:
    return np.asarray(np.sum(x * use, axis=0) / np.maximum(use.sum(axis=0), 1))


def measured(run: Run, noise: Float, rng: np.random.Generator, *, spoilt: float = 0.03, step: float = 1e-4) -> Run:
    """Return a clean run as instruments show it: `noise` (J,) N·m, a `spoilt` share of samples, encoder `step` rad."""
    clean, shape = run.recording, run.torque.shape
    far = np.where(rng.random(shape) < spoilt, 12.0 * rng.standard_normal(shape), 0.0)
    tau = run.torque + noise * (rng.standard_normal(shape) + far)
    q = np.round((clean.q + 0.5 * step * rng.standard_normal(shape)) / step) * step
    return replace(run, recording=replace(clean, q=q, tau=tau))


def number_of(name: str) -> int:
    """Return the seed that belongs to the name of a case."""
    return zlib.crc32(name.encode())
