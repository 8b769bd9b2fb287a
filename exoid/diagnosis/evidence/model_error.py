"""The part of an error that is more than noise, whether it comes again when the motion does, and what to do: what comes
again is an error of the model, what does not is noise.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from exoid.diagnosis.evidence.enough_motion import little_motion
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.plain import AsJson
from exoid.ground.text import digits
from exoid.ground.ties import index_of_greatest, index_of_least
from exoid.optimisation.preparation.filtering import driven_joints
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.motion import Float
from exoid.symbolic.wording import the_joint

UNKNOWN = "these torques were filtered before or computed, and hold no noise to compare it with"
FUNCTION = "function of angle, velocity, acceleration, load or time that was tried"
_CHANGES = (
    "measure what touches the machine (cuffs with force sensors, columns f1, f2; a force plate, grf_x, grf_z), or look "
    "for what changes between repetitions: temperature, strapping, a loose mount, the torque sensor; no model of the "
    "motion can explain it"
)
ALIKE = 0.05
"""Motions are the same where their angles differ by less than this part of their standard deviation."""
SHORTEST = 1.0
"""s, of a period; and of what two recordings must have in common."""
LEAST_SAMPLES = 60
LEAST_NOISE = 1e-6
"""N·m; a joint without samples, or without noise, has none."""


@dataclass(frozen=True)
class ModelError(AsJson):
    """An error beyond the noise: how many `times` the noise it is at `joint`, in words, and what to do about it."""

    joint: str
    times: float
    sentence: str
    advice: str
    repeating: float | None = None
    beside: str = ""
    """How large it is beside the noise, in words."""

    def _json(self) -> dict[str, Any]:
        return {"joint": self.joint, "times_noise": self.times, "repeating": self.repeating, "sentence": self.sentence}


def sensor_noise(prepared: Prepared) -> Float:
    """Return the noise floor (J,), N·m, at least `LEAST_NOISE`; where no drive acts, of the other joints' sensors: zero
    torque has no noise.
    """
    floor = np.where(driven_joints(prepared.all), prepared.noise_floor, prepared.noise_floor.max())
    return np.asarray(np.maximum(floor, LEAST_NOISE))


def times_noise(last: FittedModel) -> Float:
    """Error of a model at each joint (J,) as a multiple of the noise floor."""
    return np.asarray(last.evaluation_rms / sensor_noise(last.prepared))


def is_near_noise(last: FittedModel, rules: Rules = RULES) -> bool:
    """True if the error of a model is at most a few times the noise floor at every joint."""
    return bool(np.all(times_noise(last) <= rules.near_noise))


def noise_with(again: Repeats | None, prepared: Prepared) -> Float:
    """Return the noise (J,), N·m: what the sensors say or what does `again` not repeat, whichever is more."""
    sensors = sensor_noise(prepared)
    return sensors if again is None else np.maximum(sensors, again.noise)


def model_error(last: FittedModel, rules: Rules = RULES) -> ModelError | None:
    """Error of a model beyond the noise, at the joint where it is largest; None where it is near the noise.

    Noise is what the sensors say is noise or, where the motion repeats, what does not repeat, whichever is more.
    """
    again = repeats(last)
    sensors, floor = sensor_noise(last.prepared), noise_with(again, last.prepared)
    error = last.evaluation_rms
    times, beyond = error / floor, error / sensors
    j = index_of_greatest(times)
    if times[j] <= rules.near_noise:
        worst = index_of_greatest(beyond)
        if again is None or beyond[worst] <= rules.near_noise:
            return None
        return _random(last, again, worst, beyond[worst])
    joint, kind = last.model.joint_names[j], "unseen" if last.verified else "fitted"
    unit = last.model.joints[j].unit("tau")
    size = f"{the_joint(joint)} keeps {digits(error[j])} {unit} on {kind} motion"
    text = (
        f"{size}, {digits(times[j], 2)} times the noise of {floor[j]:.2g} {unit}. It is not noise, and no {FUNCTION}"
        if last.prepared.noise_is_known
        else f"{size} ({UNKNOWN}). It is no {FUNCTION}"
    )
    if again is None:
        text += "; whether it repeats is not known, because no motion was recorded twice"
        advice = (
            "record one of these motions twice: what comes again is an error of the model, what does not is the "
            "machine or its sensors; until then trust the parameters no further than this error"
        )
    elif again.share[j] > 0.5:
        text += f"; {100 * again.share[j]:.0f} % of it comes again {again.what}, so it is an error of the model"
        advice = (
            "look at the figure over time for what the model lacks (a second contact, cables, a base that moves) and "
            "write it as [[custom_effects]]; recording more of the same will not lower it"
        )
    else:
        text += (
            f"; only {100 * again.share[j]:.0f} % of it comes again {again.what}: what changes is the machine or its "
            "sensors, not the motion"
        )
        advice = _CHANGES
    little = little_motion(last.prepared, rules) if last.verified else ""
    if little and np.all(last.train_rms <= rules.near_noise * floor):
        text += f". On fitted motion it is near the noise, and {little}: so few leave the numbers open"
        advice = "fit more motion and ask again: what is left may be no more than numbers that so little tells badly"
    elif last.verified and error[j] > rules.near_noise * last.train_rms[j]:
        fitted = digits(last.train_rms[j])
        text += f". On fitted motion it keeps {fitted} {unit}: what this is, no fitted recording shows"
        advice = (
            "fit a recording of the motion that is held out now and hold out another: an end stop or a load that no "
            "fitted recording meets cannot be named"
        )
    beside = compared(last, j, times[j])
    return ModelError(joint, float(times[j]), text, advice, None if again is None else float(again.share[j]), beside)


def compared(last: FittedModel, j: int, times: float, noise: str = "noise") -> str:
    """Size of the error at joint `j` beside the `noise`, in words; of torques that were filtered nobody knows it."""
    if last.prepared.noise_is_known:
        return f"{digits(times, 2)} times the {noise}"
    return f"{digits(last.evaluation_rms[j])} {last.model.joints[j].unit('tau')} ({UNKNOWN})"


def beside_floor(last: FittedModel) -> str:
    """Size of the error beside the noise floor, at the joint where it is largest, in words."""
    times = times_noise(last)
    j = index_of_greatest(times)
    return compared(last, j, float(times[j]), "noise floor")


def _random(last: FittedModel, again: Repeats, j: int, times: float) -> ModelError:
    """Return the error at joint `j` that is `times` what the sensors explain, but does not come again."""
    joint, unit = last.model.joint_names[j], last.model.joints[j].unit("tau")
    beside = f", {digits(times, 2)} times the noise of the sensors" if last.prepared.noise_is_known else f" ({UNKNOWN})"
    text = (
        f"{the_joint(joint)} keeps {digits(last.evaluation_rms[j])} {unit}{beside}, "
        f"but only {100 * again.share[j]:.0f} % of it comes again {again.what}: it is no function of the motion. "
        "Something acts that is not in the recordings (a person, the ground, what changes from time to time), or the "
        "torques were smoothed before they were stored, and their noise is larger than it looks"
    )
    advice = f"log the torques as the sensors give them; if they are, {_CHANGES}"
    return ModelError(joint, float(times), text, advice, float(again.share[j]), compared(last, j, times))


@dataclass(frozen=True, eq=False)
class Repeats:
    """The residual of the torque in motions that repeat: `share` (J,) of its variance that comes again, `noise` (J,)
    N·m the RMS of what does not, and between what it was compared (`what`).
    """

    share: Float
    noise: Float
    what: str


def repeats(fitted: FittedModel) -> Repeats | None:
    """Repeats of the residual, from period to period or from run to run; None where no motion repeats."""
    periods = [pair for index in range(len(fitted.residuals)) if (pair := _periods(fitted, index)) is not None]
    if periods:
        return _compared(periods, "from period to period")
    runs = [pair for a, b in combinations(range(len(fitted.residuals)), 2) if (pair := _runs(fitted, a, b)) is not None]
    return _compared(runs, "from run to run") if runs else None


Pair = tuple[Float, Float, np.ndarray]
"""Residuals (J, K) N·m at the same place of a motion, the first and the second time, and what of them counts (J, K)."""


def _periods(fitted: FittedModel, index: int) -> Pair | None:
    recording = fitted.prepared.all[index]
    q = recording.motion.q[recording.kept]
    moves = q.std(axis=0) > 0.0
    first, most = int(np.ceil(SHORTEST * recording.kept_rate)), len(q) // 2
    if most - first < 2 or len(q) - most < LEAST_SAMPLES or not moves.any():
        return None
    q = (q - q.mean(axis=0))[:, moves] / q.std(axis=0)[moves]
    away = _differences(q, most)[first:].max(axis=1)
    best = index_of_least(away, 1.0)
    if away[best] > ALIKE**2:
        return None
    lag, rest, use = first + best, fitted.residuals[index], recording.used
    return rest[:, :-lag], rest[:, lag:], use[:, :-lag] & use[:, lag:]


def _differences(x: Float, most: int) -> Float:
    """Return the mean of (x(t + lag) - x(t))² of signals `x` (N, J) for each lag up to `most`, (most + 1, J)."""
    count, lags = len(x), np.arange(most + 1)
    size = 2 * count
    alike = np.fft.irfft(np.abs(np.fft.rfft(x, size, axis=0)) ** 2, size, axis=0)[: most + 1]
    sums = np.concatenate([np.zeros((1, x.shape[1])), np.cumsum(x**2, axis=0)])
    return np.asarray((sums[-1] - sums[lags] + sums[count - lags] - 2.0 * alike) / (count - lags)[:, None])


def _runs(fitted: FittedModel, a: int, b: int) -> Pair | None:
    first, second = fitted.prepared.all[a], fitted.prepared.all[b]
    t, s = first.t - first.motion.t[0], second.t - second.motion.t[0]
    inside = (t >= s[0]) & (t <= s[-1])
    if inside.sum() < LEAST_SAMPLES or t[inside][-1] - t[inside][0] < SHORTEST:
        return None
    q, p = first.motion.q[first.kept][inside], second.motion.q[second.kept]
    at = t[inside]
    p = np.column_stack([np.interp(at, s, column) for column in p.T])
    size = np.maximum(q.std(axis=0), 0.02)
    if np.any(np.sqrt(np.mean((q - p) ** 2, axis=0)) > ALIKE * size):
        return None
    rest = np.array([np.interp(at, s, row) for row in fitted.residuals[b]])
    use = np.array([np.interp(at, s, row.astype(float)) > 0.99 for row in second.used])
    return fitted.residuals[a][:, inside], rest, first.used[:, inside] & use


def _compared(pairs: list[Pair], what: str) -> Repeats:
    again, whole, noise, count = (np.zeros(pairs[0][0].shape[0]) for _ in range(4))
    for first, second, use in pairs:
        again += np.sum(first * second * use, axis=1)
        whole += 0.5 * np.sum((first**2 + second**2) * use, axis=1)
        noise += 0.5 * np.sum((first - second) ** 2 * use, axis=1)
        count += use.sum(axis=1)
    share = np.clip(again / np.maximum(whole, 1e-300), 0.0, 1.0)
    return Repeats(share, np.sqrt(noise / np.maximum(count, 1)), what)
