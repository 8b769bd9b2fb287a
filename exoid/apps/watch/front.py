"""The causal front end: samples as they come become filtered motion and torque, late by a known time.

    torque   each sample against the median of its neighbours (spikes are replaced), then `ORDER` equal poles
    angles   late by the same samples, then the same poles; differences give velocity and acceleration
    columns  of a model, and the torque alike: `COMMON_ORDER` equal poles, over the samples that can be used only

Torque and angles pass the same filter, so nothing is shifted between them, and the second filter treats the model's
columns as the torque, so that what holds between them goes on to hold. It is a *weighted* mean over the past: samples
at which a joint may stick (dry friction takes any value there) and holes have weight zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.signal import sosfilt

from exoid.apps.watch.recursive.encoder_noise import RING, EncoderNoise, following
from exoid.ground.errors import ExoidError
from exoid.ground.thresholds import Threshold
from exoid.optimisation.preparation.filtering import WORKING_RATE
from exoid.optimisation.preparation.sticking import STICK
from exoid.symbolic.motion import Float

Bool = np.ndarray

HALF = RING // 2
"""Samples on either side of one that its torque is compared with."""
SPIKE: Threshold = 4.0
"""robust deviations from their median beyond which a torque sample is replaced: a spike rings in the filter"""
ORDER, COMMON_ORDER = 4, 3
"""Poles of the two filters."""
ANGLE_BAND, COMMON_BAND = 4.0, 2.0
"""Their frequencies, in cut-offs."""
CUTOFF = 4.0
"""Hz, unless asked otherwise."""
SIGN_WIDTH = 0.01
"""rad/s over which the sign of a velocity fades; slower samples are not used."""
BEND = 0.12
"""Periods of the cut-off over which speeds are compared where it is judged how near a reversal is: an acceleration that
the encoders' noise has made large would leave its own sample out, and inertias come out too large."""
HOLE: Threshold = 2.5
"""steps of the clock from which samples are missing: jitter would empty the filter"""
LONGEST_HOLE: Threshold = 1.0
"""s of missing samples after which the filters start anew: motion invented across the hole"""
STEPPED_BACK: Threshold = 0.05
"""s by which a clock that goes on from there was set back: motion that is missing between two stamps is a push"""
LEAST_RATE: Threshold = 5.0
"""samples in a period of the cut-off: with three, a third of the intervals miss the truth"""
HIGHEST_RATE = 1e6
"""Hz; no machine is sampled faster, so the clock has lost its meaning."""
RINGING = 14.0
"""Time constants of a pole after which the first filter has forgotten a hole, to 1e-3."""
FIRST = 50
"""Samples from which the rate is told."""


@dataclass(frozen=True)
class Filters:
    """The two filters at a sampling `rate` in Hz for a `cutoff` in Hz; every `factor`-th sample is worked with, of
    these every `stride`-th is kept for fits. ExoidError where the rate is too low for the cut-off, or absurd.
    """

    rate: float
    cutoff: float = CUTOFF

    def __post_init__(self) -> None:
        least = LEAST_RATE * self.cutoff
        if not least <= self.rate * (1.0 + 1e-3) <= HIGHEST_RATE:
            slow = self.rate < least
            raise ExoidError(
                f"a sampling rate of {self.rate:.4g} Hz is too {'low' if slow else 'high'} for a cut-off of "
                f"{self.cutoff:g} Hz: no number would be true",
                remedy=f"sample at {least:g} Hz at least" + (
                    f", or give a lower cut-off ({self.rate / LEAST_RATE:.2g} Hz at most); if the time is not in s, "
                    "say so: --units t=ms" if slow else f" and {HIGHEST_RATE:g} Hz at most, in s"
                ),
            )  # fmt: skip

    @property
    def factor(self) -> int:
        """Samples per working sample."""
        return max(1, int(self.rate / max(WORKING_RATE, 12.0 * self.cutoff) + 1e-3))

    @property
    def working(self) -> float:
        """Rate of the working samples, Hz."""
        return self.rate / self.factor

    @property
    def stride(self) -> int:
        """Working samples per kept sample."""
        return max(1, int(self.working / (6.0 * self.cutoff) + 1e-3))

    @property
    def keep(self) -> float:
        """Share of the past in each pole of the first filter."""
        return float(np.exp(-2.0 * np.pi * min(ANGLE_BAND * self.cutoff / self.rate, 0.25)))

    @property
    def common(self) -> float:
        """Share of the past in each pole of the second filter, at the working rate."""
        return float(np.exp(-2.0 * np.pi * min(COMMON_BAND * self.cutoff / self.working, 0.25)))

    @property
    def reach(self) -> float:
        """Seconds over which the first filter blurs a reversal of the motion."""
        return 2.0 * float(np.sqrt(ORDER * self.keep)) / ((1.0 - self.keep) * self.rate)

    @property
    def lag(self) -> int:
        """Samples over which speeds are compared where it is judged how near a reversal is."""
        return max(1, round(BEND * self.rate / self.cutoff))

    @property
    def ringing(self) -> int:
        """Samples after a hole for which the first filter still rings."""
        return int(np.ceil(RINGING / -np.log(self.keep)))

    @property
    def delay(self) -> float:
        """The delay of what is fitted, in s."""
        first = HALF + ORDER * self.keep / (1.0 - self.keep) + 1.0
        return first / self.rate + COMMON_ORDER * self.common / (1.0 - self.common) / self.working

    @cached_property
    def roughness(self) -> float:
        """Variance in (rad/s²)² that white noise of the angles of 1 rad² leaves in accelerations after both filters."""
        first, second = (np.zeros(self.settled * many) for many in (self.factor, 1))
        first[0] = second[0] = 1.0
        first = poles(first, self.keep, np.zeros(ORDER))[0]
        second = poles(second, self.common, np.zeros(COMMON_ORDER))[0]
        apart = np.zeros((len(second), self.factor))
        apart[:, 0] = second
        answer = np.convolve(self.rate**2 * np.convolve(first, [1.0, -2.0, 1.0]), apart.ravel())
        return float(answer @ answer)

    @property
    def settled(self) -> int:
        """Working samples after which the second filter has forgotten how it started, to 1e-12."""
        return int(np.ceil(40.0 / -np.log(self.common)))


@dataclass(frozen=True, eq=False)
class Samples:
    """Working samples: `t` (N,) s, `q`, `dq`, `ddq`, `tau` (N, J), `good` (N, J), 1 where a joint's torque can be
    used, measured forces, `force` (N, C), and the variance of the noise of each angle, `noise` (N, J) rad².
    """

    t: Float
    q: Float
    dq: Float
    ddq: Float
    tau: Float
    good: Float
    force: Float
    noise: Float

    def __len__(self) -> int:
        return int(self.t.size)

    def part(self, first: int, last: int | None = None) -> Samples:
        """Return the samples from `first` to before `last`."""
        return Samples(*(values[first:last] for values in vars(self).values()))

    @classmethod
    def joined(cls, parts: Sequence[Samples]) -> Samples:
        """Return several stretches as one."""
        return cls(*map(np.concatenate, zip(*(vars(part).values() for part in parts), strict=True)))

    @classmethod
    def none(cls, joints: int, forces: int = 0) -> Samples:
        """Return no samples."""
        empty = np.zeros((0, joints))
        return cls(np.zeros(0), empty, empty, empty, empty, empty, np.zeros((0, forces)), empty)


def poles(x: Float, keep: float, state: Float) -> tuple[Float, Float]:
    """Return `x` (..., N) after first-order poles of gain one, and their state (K, ...) at the end."""
    sections = np.tile([1.0 - keep, 0.0, 0.0, 1.0, -keep, 0.0], (len(state), 1))
    begin = np.stack([keep * state, np.zeros(state.shape)], axis=-1)
    out, end = sosfilt(sections, x, axis=-1, zi=begin)
    return out, end[..., 0] / keep


@dataclass(eq=False)
class FrontEnd:
    """Takes samples in any portions and gives working samples; what it keeps does not grow.

    `filters` is None until the rate is known. The answer does not depend on how the samples are portioned. `outside`
    columns stand behind the torques: measured forces, and last 1 where the torques say nothing of the machine.
    """

    joints: int
    cutoff: float = CUTOFF
    outside: int = 0
    filters: Filters | None = None
    waiting: list[Float] = field(default_factory=list)
    last: Float | None = None
    """The last sample (1 + 2 J,) of the stream as it came."""
    begin: float = 0.0
    count: int = 0
    """Samples of the uniform clock so far, since `begin`."""
    raw: Float = field(default_factory=lambda: np.zeros((0, 0)))
    state: Float | None = None
    before: Float = field(default_factory=lambda: np.zeros((0, 0)))
    seen: int = 0
    unsettled: int = 0
    """Samples for which the first filter still rings from a hole."""
    restarts: int = 0
    noise: EncoderNoise | None = None
    late: int = 0
    """Samples passed over because their time is not after that of those before."""

    def push(self, samples: Float) -> Samples:
        """Return the working samples that `samples` (N, 1 + 2 J: t, q, tau, and `outside`) complete."""
        out = []
        for part in self._stretches(samples):
            out.append(self._push(part))
        return Samples.joined(out) if out else self.none

    @property
    def none(self) -> Samples:
        """No working samples."""
        return Samples.none(self.joints, max(0, self.outside - 1))

    def finish(self) -> Samples:
        """Return the working samples of a stream too short for its rate to have been told before it ended."""
        if self.filters is None and sum(map(len, self.waiting)) > 2:
            return self._begin(np.concatenate(self.waiting))
        return self.none

    def _stretches(self, samples: Float) -> list[Float]:
        """Cut where the clock jumps; what follows starts the filters anew."""
        if not len(samples):
            return []
        t = samples[:, 0] if self.last is None else np.concatenate([[self.last[0]], samples[:, 0]])
        step = np.diff(t)
        jump = np.flatnonzero((step > LONGEST_HOLE) | (step < -STEPPED_BACK)) + (1 if self.last is None else 0)
        return [part for part in np.split(samples, jump) if len(part)]

    def _push(self, samples: Float) -> Samples:
        if self.last is not None and not -STEPPED_BACK <= samples[0, 0] - self.last[0] <= LONGEST_HOLE:
            self._restart()
        if self.filters is None:
            self.waiting.append(samples)
            self.last = samples[-1]
            if sum(map(len, self.waiting)) < FIRST:
                return self.none
            return self._begin(np.concatenate(self.waiting))
        return self._on_clock(samples)

    def _restart(self) -> None:
        """Forget the filters' state; the rate is told anew."""
        self.filters, self.waiting, self.last, self.state = None, [], None, None
        self.restarts += 1

    def _begin(self, first: Float) -> Samples:
        rows = first[np.concatenate([[True], np.diff(first[:, 0]) > 0.0])]
        steps = np.diff(rows[:FIRST, 0])
        rate = 1.0 / float(np.median(steps[steps > 0.0])) if steps.size else 100.0
        self.waiting, self.last = [], None
        self.begin_at(Filters(rate, self.cutoff), float(first[0, 0]))
        return self._on_clock(first)

    def begin_at(self, filters: Filters, t: float) -> None:
        """Begin with a known rate, at `t` s."""
        self.filters, self.begin, self.count, self.seen = filters, t, 0, 0
        self.raw, self.state, self.unsettled = np.zeros((0, 2 + 2 * self.joints + self.outside)), None, 0
        self.before = np.zeros((0, 1 + 4 * self.joints + max(0, self.outside - 1)))
        self.noise = EncoderNoise(np.zeros(self.joints), following(filters.rate))

    def _on_clock(self, samples: Float) -> Samples:
        """Put samples on the uniform clock; those that do not come after the ones before are passed over."""
        assert self.filters is not None
        rows = samples if self.last is None else np.concatenate([self.last[None], samples])
        highest = np.maximum.accumulate(rows[:, 0])
        fresh = np.concatenate([[True], rows[1:, 0] > highest[:-1]])
        self.late += int(np.sum(~fresh))
        rows = rows[fresh]
        self.last = rows[-1]
        step = 1.0 / self.filters.rate
        whole = int(np.floor((rows[-1, 0] - self.begin) / step + 1e-6)) + 1
        grid = self.begin + step * np.arange(self.count, whole)
        if not grid.size:
            return self.none
        self.count = whole
        near = np.minimum(np.searchsorted(rows[:, 0], grid - 1e-3 * step), len(rows) - 1)
        exact = np.abs(rows[near, 0] - grid) < 2e-3 * step
        even = rows[near, 1:]
        if not exact.all():
            at = grid[~exact]
            even[~exact] = np.column_stack([np.interp(at, rows[:, 0], rows[:, k]) for k in range(1, rows.shape[1])])
        after = np.clip(np.searchsorted(rows[:, 0], grid), 1, max(1, len(rows) - 1))
        hole = np.zeros(grid.size) if len(rows) < 2 else (rows[after, 0] - rows[after - 1, 0] > HOLE * step) & ~exact
        return self._filter(np.column_stack([grid, even, hole]))

    def _filter(self, even: Float) -> Samples:
        """Filter samples (N, 2 + 2 J) of the uniform clock: t, q, tau, what is outside, hole."""
        assert self.filters is not None and self.noise is not None
        filters, joints = self.filters, self.joints
        rows = np.concatenate([self.raw, even])
        if len(rows) < 2 * HALF + 1:
            self.raw = rows
            return self.none
        self.raw = rows[-2 * HALF :]
        tau, noise = despiked(rows[:, 1 + joints : 1 + 2 * joints]), self.noise.take(rows[:, 1 : 1 + joints])
        middle = rows[HALF : len(rows) - HALF]
        lost, forces = middle[:, -1] != 0.0, middle[:, 1 + 2 * joints : -2]
        if self.outside:
            lost = lost | (sliding_window_view(rows[:, -2], 2 * HALF + 1).max(axis=1) > 0.0)
        x = np.concatenate([middle[:, 1 : 1 + joints], tau, forces], axis=1)
        if self.state is None:
            self.state = np.repeat(x[:1], ORDER, axis=0)
        rows_of, self.state = poles(x.T, filters.keep, self.state)
        smooth = rows_of.T
        good = np.repeat(self._settled(lost)[:, None], joints, axis=1)
        smooth, forces = smooth[:, : 2 * joints], smooth[:, 2 * joints :]
        rows = np.concatenate([self.before, np.column_stack([middle[:, 0], smooth, good, noise, forces])])
        lag = filters.lag
        self.before = rows[-2 - lag :]
        if len(rows) < 3 + lag:
            return self.none
        first = -self.seen % filters.factor
        self.seen += len(rows) - 2 - lag
        at = np.arange(1 + lag + first, len(rows) - 1, filters.factor)
        q = rows[:, 1 : 1 + joints]
        dq, was = (0.5 * filters.rate * (q[k + 1] - q[k - 1]) for k in (at, at - lag))
        ddq = filters.rate**2 * (q[at + 1] - 2.0 * q[at] + q[at - 1])
        moves = np.abs(dq) > STICK + filters.reach * filters.rate / lag * np.abs(dq - was)
        tau, good, noise = (rows[:, 1 + k * joints : 1 + (k + 1) * joints] for k in (1, 2, 3))
        usable, forces = good[at] * good[at + 1] * moves, rows[at, 1 + 4 * joints :]
        return Samples(rows[at, 0], q[at], dq, ddq, tau[at], usable, forces, noise[at + 1])

    def _settled(self, hole: Bool) -> Bool:
        """Return a mask (N,) of samples at which the first filter has forgotten the last hole."""
        assert self.filters is not None
        place = np.arange(len(hole))
        ends = np.maximum.accumulate(np.where(hole, place + self.filters.ringing + 1, self.unsettled))
        self.unsettled = max(0, int(ends[-1]) - len(hole))
        return np.asarray(place >= ends)


def despiked(tau: Float) -> Float:
    """Return the torque (N - 2 HALF, J) with spikes replaced by the median of their neighbours."""
    count = len(tau) - 2 * HALF
    windows = np.stack([tau[k : k + count] for k in range(2 * HALF + 1)])
    windows.sort(axis=0)
    middle = windows[HALF]
    # The median of the deviations: of all stretches of HALF + 1 neighbours in order, that which deviates least.
    spread = [np.maximum(middle - windows[HALF - k], windows[2 * HALF - k] - middle) for k in range(HALF + 1)]
    scale = np.min(spread, axis=0) / 0.6745
    own = tau[HALF : len(tau) - HALF]
    return np.where(np.abs(own - middle) > SPIKE * scale, middle, own)
