"""Signals of a recording: an even clock, zero-phase low-pass, derivatives, and how noisy they are.

Every filter here runs forwards and backwards (Butterworth, order 4), so nothing is delayed. Arrays have time as
axis 0. The angle noise decides everything: its second derivative grows with the fifth power of the cut-off.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.signal import butter, sosfiltfilt, welch
from scipy.sparse import csr_array

from ground.errors import NotEnoughDataError
from measurement.recording import Recording
from symbolic.mechanics.payload import Payload
from symbolic.motion import Float

ORDER = 4
STRETCH = 48
"""Kept samples that one matrix product gives."""
BRIDGE_ENDS = 0.03
"""Seconds beside a bridged run over which its ends are averaged."""
SHORTEST = 2.0
"""Shortest recording in s that leaves something to fit after the edges of the filter are cut."""


@dataclass(frozen=True, eq=False)
class EvenSignals:
    """A recording on an even clock: `t` (N,), `q` and `tau` (N, J), `gap` (N,) where rows were bad or missing.

    The logged time stamps are what it was interpolated from; `rate` is in Hz. `passive` (J,) are joints declared
    to have no drive; their torque is zero.
    """

    t: Float
    q: Float
    tau: Float
    gap: NDArray[np.bool_]
    rate: float
    passive: NDArray[np.bool_]
    payloads: tuple[Payload, ...] = ()

    @cached_property
    def spectrum(self) -> tuple[Float, Float]:
        """Frequencies (F,) in Hz and power (F, J) in rad²/Hz of the angles; every cut-off is judged by it."""
        length = min(len(self.q), int(10.0 * self.rate))
        frequency, power = welch(self.q, self.rate, nperseg=length, detrend="linear", axis=0)
        return frequency, power

    @cached_property
    def despiked(self) -> Float:
        """Torque (N, J) in N·m without spikes of a few milliseconds, which decimation would smear."""
        spiky, middle = spikes(self.tau, 0.03, self.rate, 8.0)
        return np.where(spiky, middle, self.tau)


def even_clock(recording: Recording) -> EvenSignals:
    """Put a recording on an even clock at its own median rate, using only its valid rows.

    Bad rows and holes are bridged so that filters can run, and marked in `gap` so that no fit uses them.
    Refuses a recording that is too short.
    """
    good = recording.valid
    t = recording.t[good]
    if t.size < 2 or t[-1] - t[0] < SHORTEST:
        raise NotEnoughDataError(
            f"only {0.0 if t.size < 2 else t[-1] - t[0]:.2f} s of usable data",
            where=recording.source.path or recording.name,
            remedy=f"record at least {SHORTEST:g} s; 30 s of motion is a good start",
        )
    step = float(np.median(np.diff(t)))
    grid = t[0] + step * np.arange(int(np.floor((t[-1] - t[0]) / step + 1e-6)) + 1)
    if grid.size == t.size and np.max(np.abs(grid - t)) < 1e-3 * step:
        grid, q, tau = t, recording.q[good], recording.tau[good]
    else:
        q = np.column_stack([np.interp(grid, t, recording.q[good, j]) for j in range(recording.q.shape[1])])
        tau = np.column_stack([np.interp(grid, t, recording.tau[good, j]) for j in range(recording.q.shape[1])])
    after = np.clip(np.searchsorted(t, grid, side="right"), 1, t.size - 1)
    hole = (t[after] - t[after - 1]) > 2.5 * step
    passive = np.array([joint in recording.passive for joint in recording.joint_names])
    return EvenSignals(grid, q, np.where(passive, 0.0, tau), hole, 1.0 / step, passive, recording.payloads)


def low_pass(x: Float, cutoff: float, rate: float) -> Float:
    """Return `x` (N, ...) without what is faster than `cutoff` Hz, without delay."""
    sections = butter(ORDER, min(cutoff / (0.5 * rate), 0.95), output="sos")
    pad = min(len(x) - 1, int(3.0 * rate / cutoff))
    return sosfiltfilt(sections, x, axis=0, padlen=pad)


def low_pass_at(x: Float, cutoff: float, rate: float, kept: NDArray[np.int_]) -> Float:
    """Return the samples `kept` (K,), evenly spaced, of `x` (N, ...) after `low_pass`; several times faster.

    The filter's response is the same to 1e-7; it is applied as one matrix product per stretch of samples, so that
    hundreds of columns cost little. Needs a finite response shorter than the recording; else `low_pass` itself runs.
    """
    response = _response(cutoff, rate)
    reach = response.size // 2
    if kept.size < 2 or reach >= len(x) - 1:
        return low_pass(x, cutoff, rate)[kept]
    flat = np.ascontiguousarray(x.reshape(len(x), -1))
    step = int(kept[1] - kept[0])
    before, after = max(0, reach - int(kept[0])), max(0, int(kept[-1]) + reach + 1 - len(x))
    head = 2.0 * flat[0] - flat[before:0:-1]
    tail = 2.0 * flat[-1] - flat[-2 : -after - 2 : -1]
    flat = np.concatenate([head, flat, tail]) if before or after else flat
    rows = min(STRETCH, kept.size)
    band = np.zeros((rows, step * (rows - 1) + response.size))
    for row in range(rows):
        band[row, row * step : row * step + response.size] = response
    out = np.empty((kept.size, flat.shape[1]))
    for first in range(0, kept.size, rows):
        count = min(rows, kept.size - first)
        start = int(kept[first]) - reach + before
        width = step * (count - 1) + response.size
        np.matmul(band[:count, :width], flat[start : start + width], out=out[first : first + count])
    return out.reshape(kept.size, *x.shape[1:])


def bridging(hidden: NDArray[np.bool_], rate: float) -> csr_array:
    """Return the matrix (H, N) that puts a straight line across every run of `hidden` (N,) samples, H of them.

    Its ends are means over a few samples beside the run (`BRIDGE_ENDS` s). Being linear, it may be applied to a torque
    and to the columns of its regressor alike, and what holds between them goes on to hold. A run at an end of the
    recording gets the level of its other side.
    """
    count = hidden.size
    edges = np.flatnonzero(np.diff(np.concatenate([[False], hidden, [False]]).astype(int))).reshape(-1, 2)
    most = max(1, int(BRIDGE_ENDS * rate))
    rows, columns, values = [], [], []
    row = 0
    for k, (first, last) in enumerate(edges):
        before = np.arange(max(first - most, edges[k - 1][1] if k else 0), first)
        after = np.arange(last, min(last + most, edges[k + 1][0] if k + 1 < len(edges) else count))
        share = (np.arange(first, last) - first + 1.0) / (last - first + 1.0)
        if not before.size or not after.size:
            share = np.full(share.size, 0.0 if before.size else 1.0)
        for side, weight in ((before, 1.0 - share), (after, share)):
            if side.size:
                rows.append(np.repeat(np.arange(row, row + share.size), side.size))
                columns.append(np.tile(side, share.size))
                values.append(np.repeat(weight / side.size, side.size))
        row += share.size
    if not rows:
        return csr_array((row, count))
    parts = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return csr_array(parts, shape=(row, count))


def response_seconds(cutoff: float) -> float:
    """Return the time in s after which the slowest pole of `low_pass` has fallen to 1e-7."""
    return 6.7 / cutoff


@lru_cache(maxsize=32)
def _response(cutoff: float, rate: float) -> Float:
    """Return the zero-phase response (2 L + 1,) of `low_pass` to one sample, as far as it matters."""
    sections = butter(ORDER, min(cutoff / (0.5 * rate), 0.95), output="sos")
    reach = int(np.ceil(response_seconds(cutoff) * rate))
    pulse = np.zeros(4 * reach + 1)
    pulse[2 * reach] = 1.0
    response = sosfiltfilt(sections, pulse, padlen=0)[reach : 3 * reach + 1]
    return response / response.sum()


def decimate(x: Float, factor: int, rate: float) -> Float:
    """Return every `factor`-th sample of `x` (N, ...) after a zero-phase anti-alias filter."""
    return x if factor == 1 else low_pass(x, 0.4 * rate / factor, rate)[::factor]


def derivatives(q: Float, rate: float) -> tuple[Float, Float]:
    """Return velocity and acceleration (N, J) of angles that are already smooth, by central differences."""
    dq = np.gradient(q, 1.0 / rate, axis=0)
    ddq = np.empty_like(q)
    ddq[1:-1] = (q[2:] - 2.0 * q[1:-1] + q[:-2]) * rate**2
    ddq[0], ddq[-1] = ddq[1], ddq[-2]
    return dq, ddq


def fine_derivatives(q: Float, rate: float) -> tuple[Float, Float]:
    """Return the same by differences of fourth order: what `derivatives` gets wrong shows in the difference."""
    dq, ddq = derivatives(q, rate)
    dq[2:-2] = (8.0 * (q[3:-1] - q[1:-3]) - (q[4:] - q[:-4])) * rate / 12.0
    ddq[2:-2] = (16.0 * (q[3:-1] + q[1:-3]) - (q[4:] + q[:-4]) - 30.0 * q[2:-2]) * rate**2 / 12.0
    return dq, ddq


def noise_density(even: EvenSignals) -> Float:
    """Return the one-sided white noise density (J,) of the angles, rad²/Hz, from the top fifth of the spectrum."""
    frequency, power = even.spectrum
    return np.asarray(np.median(power[frequency > 0.4 * even.rate], axis=0))


def quiet_noise(x: Float, rate: float, cutoff: float) -> Float:
    """Return the RMS (J,) that the steady noise of `x` (N, J) leaves below `cutoff` Hz, if it is white.

    Taken from the upper half of the spectrum by the median absolute deviation, so that bursts and jumps do not count.
    """
    fast = x - low_pass(x, 0.25 * rate, rate)
    scale = np.median(np.abs(fast - np.median(fast, axis=0)), axis=0) / 0.6745
    return np.asarray(scale * np.sqrt(cutoff / (0.25 * rate)))


def acceleration_quality(even: EvenSignals, cutoff: float) -> Float:
    """Return the share (J,) of noise in the variance of the second derivative below `cutoff` Hz.

    White angle noise of density S leaves S (2π)⁴ f⁵ / 5 in the acceleration; this share is the relative bias of
    an inertia towards zero (errors in variables).
    """
    frequency, power = even.spectrum
    inside = frequency <= cutoff
    total = np.sum(power[inside] * (2 * np.pi * frequency[inside, None]) ** 4, axis=0) * frequency[1]
    return np.asarray(acceleration_noise(even, cutoff) ** 2 / np.maximum(total, 1e-300))


def acceleration_noise(even: EvenSignals, cutoff: float) -> Float:
    """Return the standard deviation (J,) of the acceleration noise left below `cutoff` Hz, rad/s²."""
    return np.asarray(np.sqrt(noise_density(even) * (2 * np.pi) ** 4 * cutoff**5 / 5.0))


def velocity_noise(density: Float, cutoff: float) -> Float:
    """Return the standard deviation (J,) in rad/s of the velocity noise below `cutoff` Hz.

    `density` (J,) is that of the angle noise, rad²/Hz.
    """
    return np.sqrt(density * (2 * np.pi) ** 2 * cutoff**3 / 3.0)


def running_median(x: Float, seconds: float, rate: float) -> Float:
    """Return the running median of each channel of `x` (N, J) over a window of `seconds`."""
    window = max(5, round(seconds * rate) | 1)
    return median_filter(x, size=(window, 1), mode="nearest")


def spikes(x: Float, seconds: float, rate: float, limit: float) -> tuple[NDArray[np.bool_], Float]:
    """Return where `x` (N, J) leaves its running median by more than `limit` robust deviations, and the median."""
    middle = running_median(x, seconds, rate)
    away = np.abs(x - middle)
    scale = np.median(away, axis=0) / 0.6745
    return away > limit * np.maximum(scale, 1e-300), middle


def widen(mask: NDArray[np.bool_], samples: int) -> NDArray[np.bool_]:
    """Return `mask` (N,) grown by `samples` on either side."""
    if samples <= 0 or not mask.any():
        return mask
    kernel = np.ones(2 * samples + 1)
    return np.convolve(mask.astype(float), kernel, mode="same")[: mask.size] > 0.5
