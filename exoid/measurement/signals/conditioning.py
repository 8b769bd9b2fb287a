"""Signals of a recording: uniform sampling, zero-phase low-pass, derivatives, and how noisy they are.

Every filter here runs forwards and backwards (Butterworth, order 4), so nothing is delayed. Arrays have time as
axis 0. The angle noise decides everything: its second derivative grows with the fifth power of the cut-off.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import NotEnoughDataError
from exoid.measurement.logged import Logged
from exoid.measurement.recording import Recording
from exoid.measurement.signals.bridging import Bridge
from exoid.measurement.signals.butterworth import (
    Filter,
    WaveProducts,
    both_ways,
    both_ways_at,
    filtered_wave_products,
    low_pass_filter,
)
from exoid.measurement.signals.compiled import POLES
from exoid.measurement.signals.holes import BRIEF_HOLE, HOLE_STEPS, MISSING_STEPS, interpolated
from exoid.measurement.signals.masks import straight_columns
from exoid.measurement.signals.spikes import spikes, spikes_beside
from exoid.measurement.stance import stances_of
from exoid.symbolic.mechanics.payload import Payload
from exoid.symbolic.motion import Float
from exoid.symbolic.waves import FEW, Waves, are_even

ORDER = 2 * POLES
MOST_APART, ENOUGH_APART = 0.9, 200
"""Share of samples left out of an estimate of noise beyond which fewer are, unless so many samples are left."""
SHORTEST = 2.0
"""Shortest recording in s that leaves something to fit after the edges of the filter are cut."""
MISSING = 0.25
"""Part of an averaged torque that must be missing for it to be missing."""


@dataclass(frozen=True, eq=False)
class UniformSignals:
    """A uniformly sampled recording: `t` (N,), `q` and `tau` (N, J).

    The logged time stamps are what it was interpolated from; `rate` is in Hz. `gap` (N,) is where an angle was bad or
    missing, or a whole row, `torque_gap` (N, J) where a torque was; there stands what neighbours suggest. `passive`
    (J,) are joints declared to have no drive; their torque is zero. `base` (N, 3) is that of the recording, `force`
    (N, C) measured forces.
    """

    t: Float
    q: Float
    tau: Float
    gap: NDArray[np.bool_]
    torque_gap: NDArray[np.bool_]
    rate: float
    passive: NDArray[np.bool_]
    payloads: tuple[Payload, ...] = ()
    base: Float | None = None
    force: Float | None = None
    as_read: Recording | None = None
    """The recording whose torques these are, sample by sample; None where they were resampled."""
    stances: Float | None = None
    """When (S, 2) in s a foot came down and left the ground, where that was measured."""
    logged: Mapping[str, Logged] = field(default_factory=dict)
    """Further columns that say in what state the machine was."""
    _slower: dict[int, Float] = field(default_factory=dict, init=False, repr=False)
    _beside: dict[int, NDArray[np.bool_]] = field(default_factory=dict, init=False, repr=False)

    def stretch(self, first: int, last: int) -> UniformSignals:
        """Return the samples from `first` to before `last` as signals of their own."""
        part = slice(first, last)
        base, force = (None if x is None else x[part] for x in (self.base, self.force))
        t, q, tau = self.t[part], self.q[part], self.tau[part]
        gap, torque_gap = self.gap[part], self.torque_gap[part]
        cut = replace(self, t=t, q=q, tau=tau, gap=gap, torque_gap=torque_gap, base=base, force=force, as_read=None)
        if "spikes" in vars(self):
            vars(cut)["spikes"] = self.spikes[part]
        return cut

    def slower_torque(self, factor: int) -> Float:
        """Return the torque (N / factor, J) at a rate lower by `factor`, without spikes; as it is for 1."""
        if factor == 1:
            return self.tau
        if factor not in self._slower:
            self._slower[factor] = averaged(self.despiked, factor)
        return self._slower[factor]

    def slower_gap(self, factor: int) -> NDArray[np.bool_]:
        """Return a mask of these torques (N / factor, J) that are missing: much of what they are made of is."""
        if factor == 1 or not self.torque_gap.any():
            return self.torque_gap[::factor]
        return np.asarray(averaged(self.torque_gap.astype(float), factor) > MISSING)

    def slower_force(self, factor: int) -> Float | None:
        """Return the measured forces (N / factor, C) at a rate lower by `factor`, as the torque."""
        return self.force if self.force is None or factor == 1 else averaged(self.force, factor)

    @cached_property
    def reach(self) -> Float:
        """Largest minus smallest torque (J,) in N·m."""
        return np.array([np.ptp(channel) for channel in self.tau.T])

    @cached_property
    def spectrum(self) -> tuple[Float, Float]:
        """Frequencies (F,) in Hz and power (F, J) in rad²/Hz of the angles; every cut-off is judged by it."""
        return welch(self.q, self.rate, self.averaged)

    @property
    def averaged(self) -> int:
        """Samples in a stretch whose power is averaged."""
        return min(len(self.q), int(10.0 * self.rate))

    @cached_property
    def span(self) -> Float:
        """Range (J,) of the torque in N·m without its outer tenths."""
        return middle_range(self.tau)

    @cached_property
    def spikes(self) -> NDArray[np.bool_]:
        """Samples (N, J) at which the torque has spikes of a few milliseconds, which decimation would smear."""
        return spikes(self.tau, self.rate, self.torque_gap) if self.as_read is None else self.as_read.spikes

    def slower_spikes(
        self, factor: int, known: Callable[[], Float], missing: NDArray[np.bool_]
    ) -> NDArray[np.bool_]:
        """Return a mask of the slower torques (N / factor, J) that are spikes beside what `known` gives, the torque of
        a model; those `missing` do not count. Asked once: all cut-offs see the same samples.
        """
        if factor not in self._beside:
            self._beside[factor] = spikes_beside(
                self.slower_torque(factor), known(), self.rate / factor, missing, averaged=factor > 1
            )
        return self._beside[factor]

    @cached_property
    def despiked(self) -> Float:
        """Torque (N, J) in N·m with straight lines across spikes."""
        return straight_columns(self.tau, self.spikes)


def uniform_sampling(recording: Recording, force: Float | None = None) -> UniformSignals:
    """Resample a recording uniformly at its own median rate, using only its valid rows, and with it a measured `force`
    (N, C).

    Bad rows and holes are bridged so that filters can run, and marked in `gap` so that no fit uses them.
    Refuses a recording that is too short.
    """
    t = recording.t[recording.valid]
    if t.size < 2 or t[-1] - t[0] < SHORTEST:
        what = f"only {0.0 if t.size < 2 else t[-1] - t[0]:.2f} s of usable data"
        remedy = f"record at least {SHORTEST:g} s; 30 s of motion is a good start"
        raise NotEnoughDataError(what, where=recording.source.path or recording.name, remedy=remedy)
    step = float(np.median(np.diff(t)))
    grid = t[0] + step * np.arange(int(np.floor((t[-1] - t[0]) / step + 1e-6)) + 1)
    if grid.size == t.size and np.max(np.abs(grid - t)) < 1e-3 * step:
        grid = t

    def even(x: Float, valid: NDArray[np.bool_], wide: float) -> tuple[Float, NDArray[np.bool_]]:
        """Return the valid values (N, J) of `x` on the grid, and where there are holes of more than `wide` s."""
        if grid is t and valid.all():
            return np.asarray(x[recording.valid]), np.zeros((grid.size, x.shape[1]), dtype=bool)
        pairs = [interpolated(grid, recording.t[known], x[known, j], step, wide) for j, known in enumerate(valid.T)]
        values, holes = (np.column_stack(each) for each in zip(*pairs, strict=True))
        return values, holes

    rows = recording.valid[:, None]
    slow = max(HOLE_STEPS * step, BRIEF_HOLE)
    q, unknown = even(recording.q, recording.angle_valid, slow)
    tau, torque_gap = even(recording.tau, recording.torque_valid, MISSING_STEPS * step)
    gap = np.asarray(unknown.any(axis=1))
    base = None
    if recording.base is not None:
        base, swayed = even(recording.base, np.broadcast_to(rows, recording.base.shape), slow)
        gap |= swayed.any(axis=1)
    passive = np.array([joint in recording.passive for joint in recording.joint_names])
    tau = np.where(passive, 0.0, tau)
    pushed = None
    if force is not None:  # where a force is not known, the torques are not explained
        pushed, unpushed = even(force, np.broadcast_to(rows, force.shape), MISSING_STEPS * step)
        torque_gap = torque_gap | np.any(unpushed, axis=1, keepdims=True)
    missing = torque_gap & ~passive
    as_read = recording if grid.size == len(recording) and np.array_equal(tau, recording.tau) else None
    known = (passive, recording.payloads, base, pushed, as_read, stances_of(recording), recording.logged)
    return UniformSignals(grid, q, tau, gap, missing, 1.0 / step, *known)


def middle_range(x: Float) -> Float:
    """Range (J,) of signals (N, J) without their outer tenths."""
    return np.asarray(np.ptp(np.quantile(x, (0.1, 0.9), axis=0), axis=0))


def low_pass(x: Float, cutoff: float, rate: float) -> Float:
    """Return `x` (N, ...) without what is faster than `cutoff` Hz, without delay."""
    return both_ways(_filter(cutoff, rate), x, min(len(x) - 1, int(3.0 * rate / cutoff)))


def low_pass_at(
    rows: Float, cutoff: float, rate: float, kept: NDArray[np.int_], out: Float | None = None
) -> Float:
    """Return the samples `kept` (K,), evenly spaced, of `rows` (C, N) after `low_pass`, as (C, K); much faster.

    What is further away than the response reaches (1e-7 of it) does not count. Where that is longer than the recording,
    `low_pass` itself runs. Written into `out` (C, K), contiguous, where that is given.
    """
    reach = _reach(cutoff, rate)
    if kept.size < 2 or reach >= rows.shape[1] - 1:
        out = np.empty((len(rows), kept.size)) if out is None else out
        out[:] = low_pass(rows.T, cutoff, rate)[kept].T
        return out
    return both_ways_at(_filter(cutoff, rate), rows, int(kept[0]), int(kept[1] - kept[0]), kept.size, reach, out)


def wave_products(
    waves: Waves,
    shapes: Float,
    bridges: Sequence[Bridge],
    cutoff: float,
    rate: float,
    kept: NDArray[np.int_],
    weights: Float,
    signals: Float,
) -> WaveProducts | None:
    """Return the products of waves at `shapes` (V, S), bridged joint by joint and filtered by `low_pass_at`, for
    `weights` (U, A, K) and weighted `signals` (S, A, K, Q), never having the waves; None where that is impossible.
    """
    numbers, reach = shapes[:, waves.place], _reach(cutoff, rate)
    if kept.size < 2 or reach >= waves.phase.size - 1 or len(numbers) < FEW or not are_even(numbers):
        return None
    lowpass, across, step = _filter(cutoff, rate), [bridge.in_c for bridge in bridges], int(kept[1] - kept[0])
    return filtered_wave_products(lowpass, waves, numbers, across, int(kept[0]), step, reach, weights, signals)


def _reach(cutoff: float, rate: float) -> int:
    """Return after how many samples a response has ended."""
    return int(np.ceil(response_seconds(cutoff) * rate))


def _filter(cutoff: float, rate: float) -> Filter:
    return low_pass_filter(ORDER, min(cutoff / (0.5 * rate), 0.95))


def welch(x: Float, rate: float, length: int) -> tuple[Float, Float]:
    """Return frequencies (F,) in Hz and the one-sided power (F, J) per Hz of `x` (N, J), the mean over half-overlapping
    stretches of `length` samples, each without its straight line, in a Hann window (Welch 1967).
    """
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(length) / length)
    line = np.linspace(-1.0, 1.0, length)
    starts = range(0, len(x) - length + 1, length - length // 2)
    total = np.zeros((length // 2 + 1, x.shape[1]))
    for start in starts:
        part = x[start : start + length] - x[start : start + length].mean(axis=0)
        part = part - np.outer(line, line @ part) / float(line @ line)
        total += np.abs(np.fft.rfft(part * window[:, None], axis=0)) ** 2
    total[1 : None if length % 2 else -1] *= 2.0
    scale = len(starts) * rate * float(window @ window)
    return np.asarray(np.fft.rfftfreq(length, 1.0 / rate), dtype=float), total / scale


def response_seconds(cutoff: float) -> float:
    """Return the time in s after which the slowest pole of `low_pass` has fallen to 1e-7."""
    return 6.7 / cutoff


def low_pass_every(x: Float, cutoff: float, rate: float, factor: int) -> Float:
    """Return every `factor`-th sample of `x` (N, J) after `low_pass`; the others are not computed."""
    reach = _reach(cutoff, rate)
    if factor == 1 or len(x) < 8 * reach:
        return low_pass(x, cutoff, rate)[::factor]
    rows, count = np.ascontiguousarray(x.T), -(-len(x) // factor)
    out = np.ascontiguousarray(both_ways_at(_filter(cutoff, rate), rows, 0, factor, count, reach).T)
    # Near the ends the result depends on how the recording is continued there.
    near, last = -(-reach // factor), factor * (count - -(-3 * reach // factor))
    out[:near] = low_pass(x[: 3 * reach], cutoff, rate)[::factor][:near]
    out[-near:] = low_pass(x[last:], cutoff, rate)[::factor][-near:]
    return out


def averaged(x: Float, factor: int) -> Float:
    """Return the mean of `x` (N, J) around every `factor`-th sample, as (N / factor, J): the value there of the cubic
    that fits the samples less than two of these steps away (Cleveland, Journal of the American Statistical Association
    74, 1979). A jump of `x` reaches no further.
    """
    if factor == 1:
        return x
    weights = _averaging(factor)
    half = weights.size // 2
    padded = np.pad(x, ((half, half), (0, 0)), mode="reflect", reflect_type="odd")
    windows = np.lib.stride_tricks.sliding_window_view(padded, weights.size, axis=0)[::factor]
    return np.asarray(windows @ weights)


@lru_cache(maxsize=32)
def _averaging(factor: int) -> Float:
    """Return the weights (4 factor - 1,) of the samples around one."""
    at = np.arange(1 - 2 * factor, 2 * factor) / (2.0 * factor)
    near = (1.0 - at**2) ** 2
    powers = at[:, None] ** np.arange(4)
    return np.asarray(np.linalg.solve(powers.T @ (near[:, None] * powers), (near[:, None] * powers).T)[0])


def derivatives(q: Float, rate: float) -> tuple[Float, Float]:
    """Return velocity and acceleration (N, J) of angles that are already smooth, by differences of fourth order."""
    dq = np.gradient(q, 1.0 / rate, axis=0)
    ddq = np.empty_like(q)
    ddq[1:-1] = (q[2:] - 2.0 * q[1:-1] + q[:-2]) * rate**2
    ddq[0], ddq[-1] = ddq[1], ddq[-2]
    dq[2:-2] = (8.0 * (q[3:-1] - q[1:-3]) - (q[4:] - q[:-4])) * rate / 12.0
    ddq[2:-2] = (16.0 * (q[3:-1] + q[1:-3]) - (q[4:] + q[:-4]) - 30.0 * q[2:-2]) * rate**2 / 12.0
    return dq, ddq


def noise_density(even: UniformSignals) -> Float:
    """Return the one-sided white noise density (J,) of the angles, rad²/Hz, from the top fifth of the spectrum.

    The median of a power averaged over few stretches lies below its mean: by 31 % for a single one.
    """
    frequency, power = even.spectrum
    length = even.averaged
    stretches = 1 + (len(even.t) - length) // (length - length // 2)
    freedom = 2.0 * stretches / (1.0 + (stretches - 1) / (18.0 * stretches))  # half-overlapping Hann windows
    median = (1.0 - 2.0 / (9.0 * freedom)) ** 3  # of χ² over its degrees of freedom, Wilson and Hilferty 1931
    return np.asarray(np.median(power[frequency > 0.4 * even.rate], axis=0)) / median


def quiet_noise(x: Float, rate: float, cutoff: float, apart: np.ndarray | None = None, factor: int = 1) -> Float:
    """Return the RMS (J,) that the steady noise of `x` (N, J) leaves below `cutoff` Hz, if it is white.

    Taken from the upper half of the spectrum by the median absolute deviation, so that bursts and jumps do not count,
    and without the samples `apart` (N, J) unless no others are left. `x` is the mean of `factor` times as many
    samples (`averaged`), or as it was measured.
    """
    fast = x - low_pass(x, 0.25 * rate, rate)
    left = np.ones(x.shape, dtype=bool) if apart is None else ~apart | apart.all(axis=0)
    told = [channel[keep] for channel, keep in zip(fast.T, left.T, strict=True)]
    scale = np.array([np.median(np.abs(channel - np.median(channel))) for channel in told]) / 0.6745
    return np.asarray(scale * np.sqrt(cutoff / (0.25 * rate) / _left_by_averaging(factor)))


def leaves_enough(apart: np.ndarray) -> NDArray[np.bool_]:
    """Return for which signals (J,) the samples that are not `apart` (N, J) are enough to tell the noise by."""
    return np.asarray((np.mean(apart, axis=0) < MOST_APART) | (np.sum(~apart, axis=0) >= ENOUGH_APART))


@lru_cache(maxsize=32)
def _left_by_averaging(factor: int) -> float:
    """Return the power that white noise keeps in the upper half of the spectrum where it is averaged, of that which it
    keeps in the lowest frequencies.
    """
    if factor == 1:
        return 1.0
    weights = _averaging(factor)
    lags = np.arange(4)
    both = np.array([weights[: weights.size - k * factor] @ weights[k * factor :] for k in lags])
    both[1:] *= 2.0
    frequency = (np.arange(512) + 0.5) / 1024.0
    power = np.cos(2.0 * np.pi * np.outer(frequency, lags)) @ both / both.sum()
    gain = 1.0 / (1.0 + np.tan(np.pi * frequency) ** (2 * ORDER))  # of `low_pass`, both ways, at a quarter of the rate
    return float(power @ (1.0 - gain) ** 2 / np.sum((1.0 - gain) ** 2))


def acceleration_quality(even: UniformSignals, cutoff: float) -> Float:
    """Return the share (J,) of noise in the variance of the second derivative below `cutoff` Hz.

    White angle noise of density S leaves S (2π)⁴ f⁵ / 5 in the acceleration; this share is the relative bias of
    an inertia towards zero (errors in variables).
    """
    frequency, power = even.spectrum
    inside = frequency <= cutoff
    total = np.sum(power[inside] * (2 * np.pi * frequency[inside, None]) ** 4, axis=0) * frequency[1]
    return np.asarray(acceleration_noise(even, cutoff) ** 2 / np.maximum(total, 1e-300))


def acceleration_noise(even: UniformSignals, cutoff: float) -> Float:
    """Return the standard deviation (J,) of the acceleration noise left below `cutoff` Hz, rad/s²."""
    return acceleration_deviation(noise_density(even), cutoff)


def acceleration_deviation(density: Float, band: float) -> Float:
    """Return the standard deviation (J,) of the acceleration noise below `band` Hz that angle noise of `density` (J,),
    rad²/Hz, makes, rad/s².
    """
    return np.asarray(np.sqrt(density * (2 * np.pi) ** 4 * band**5 / 5.0))


def velocity_noise(density: Float, cutoff: float) -> Float:
    """Return the standard deviation (J,) in rad/s of the velocity noise below `cutoff` Hz.

    `density` (J,) is that of the angle noise, rad²/Hz.
    """
    return np.sqrt(density * (2 * np.pi) ** 2 * cutoff**3 / 3.0)
