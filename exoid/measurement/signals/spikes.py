"""Torque samples that neither what is before them nor what is behind them predicts: spikes of a sensor.

Every sample is predicted by a linear combination of its neighbours on both sides, the one that predicts this torque
best (an autoregressive model, as clicks are found in recordings of sound: Godsill, Rayner, Digital Audio Restoration,
Springer 1998). A sample far off is a spike where parabolas through what is before it and through what is behind it miss
it in the same direction too; where a force jumps, its own side of the jump predicts it. Beside a spike one of the other
sign is found by neighbours further away: a sensor chatters. What is judged so is a torque, or what a model leaves of
one: what the model lacks has neighbours like itself, and is taken for spikes only where it is as brief as these.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.thresholds import Threshold
from exoid.measurement.signals.masks import Mask, straight
from exoid.symbolic.motion import Float

SPIKE: Threshold = 3.5
"""robust deviations of what neighbours predict beyond which a torque sample is a spike: noise would be hidden"""
AGAIN: Threshold = 5.5
"""the same of the means of several samples, which were judged one by one already: good ones would be hidden where a
model turns a little too early
"""
ALONE: Threshold = 0.4
"""part of that by which one side alone must miss it, too: where a force jumps, samples would be hidden"""
CROWD: Threshold = 5
"""spikes among a sample and its neighbours from which it is one: a sensor chatters, and what lies between its peaks
would be fitted
"""
DENSE: Threshold = 0.12
"""share of such samples from which they may be a drive's chatter: a sensor with as many is of no use"""
CARRIED: Threshold = 0.35
"""part of the slow torque in dense ones from which they are chatter that moves the machine, and are kept: without them
a machine would be far too light
"""
ALIGNED: Threshold = 1.4
"""times what such samples of random sign would hold: a disturbed sensor's spikes would be taken for a drive's"""
AVERAGED = 0.2
"""s over which the torque is averaged for that."""
SIDE, PARABOLA = 5, 8
"""Samples on either side that predict together, and alone."""
LASTS, MOST = 0.003, 5
"""Seconds that a spike lasts, at most, and samples; it may always last two."""
ROUNDS = 3
"""Times that a torque is judged, anew without what was found."""
STEPS, BISQUARE = 3, 4.7
"""Steps of the robust fit of a prediction, and deviations beyond which samples have no part in it (Tukey)."""
AMONG = 8
"""Samples on either side among which spikes crowd."""
BESIDE = 2
"""Samples on either side of a spike that may chatter with it."""
MANY = 1_000
"""Samples that it takes, at most."""
NEARBY = 100
"""Samples whose usual miss is taken together: a torque may be rough for a while."""
LEAST = 1e-7
"""Part of a torque's range that counts as its noise, at least."""


def spikes(x: Float, rate: float, unknown: Mask | None = None) -> Mask:
    """Return a mask of the spikes among samples `x` (N, J) of torques, evenly spaced at `rate` Hz: those far off that
    are not the chatter of a drive.
    """
    return without_chatter(x, far_off(x, rate, unknown), rate)


def far_off(x: Float, rate: float, unknown: Mask | None = None, *, averaged: bool = False) -> Mask:
    """Return a mask of the samples among `x` (N, J), evenly spaced at `rate` Hz, that are far off their neighbours; two
    in a row are found, or as many as last 3 ms. Those `unknown` (N, J) are none, nor do they count. `averaged` are
    means of samples judged before.
    """
    longest = int(np.clip(round(LASTS * rate), 2, MOST))
    out = np.zeros(x.shape, dtype=bool)
    for j, channel in enumerate(x.T):
        lost = np.zeros(len(x), dtype=bool) if unknown is None else unknown[:, j]
        if np.count_nonzero(~lost) > 8 * PARABOLA and np.ptp(channel[~lost]) > 0.0:
            out[:, j] = _of_channel(np.ascontiguousarray(channel), lost, (0, longest - 1), averaged)
    return out


def spikes_beside(tau: Float, known: Float, rate: float, missing: Mask, *, averaged: bool) -> Mask:
    """Return the spikes (N, J) of torques `tau`, judged by what the torque `known` of a model leaves of them; what is
    constant has none, whatever a model says. `averaged` are means of samples judged before.
    """
    far = far_off(tau - known, rate, missing, averaged=averaged) & (np.ptp(tau, axis=0) > 0.0)
    return without_chatter(tau, far, rate)


def without_chatter(tau: Float, far: Mask, rate: float) -> Mask:
    """Return the samples (N, J) of torques that are `far` off, without those of a channel in which they are dense and
    hold much of the slow torque, with one sign for a while: a drive that is switched fast moves its machine by them.
    """
    out = far.copy()
    for j in np.flatnonzero(np.count_nonzero(far, axis=0) > DENSE * len(far)):
        share, times = carried(tau[:, j], far[:, j], rate)
        out[:, j] &= not (share > CARRIED and times > ALIGNED)
    return out


def carried(tau: Float, far: Mask, rate: float) -> tuple[float, float]:
    """Part of a slow torque (N,) that is in those of its samples that are `far` off the line between the others, and
    how many times what they would hold with random signs.
    """
    off = tau - straight(tau, far)
    slow, bursts = (float(averaged(values, rate).std()) for values in (tau, off))
    random = float(np.sqrt(np.mean(off**2) / _count(rate)))
    return (bursts / slow, bursts / random) if slow > 0.0 and random > 0.0 else (0.0, 0.0)


def averaged(values: Float, rate: float) -> Float:
    """Means of neighbours in a fifth of a second; of all values where there are fewer."""
    sums, count = np.cumsum(np.concatenate([[0.0], values])), min(_count(rate), values.size)
    return np.asarray((sums[count:] - sums[:-count]) / count)


def _count(rate: float) -> int:
    return max(1, round(AVERAGED * rate))


def _of_channel(x: Float, lost: Mask, guards: tuple[int, ...], averaged: bool) -> Mask:
    """Return a mask of the spikes among samples `x` (N,), judged anew without those found until nothing changes; beside
    one so many have no part in its prediction.
    """
    bad = np.zeros(x.size, dtype=bool)
    least = LEAST * float(np.ptp(x[~lost]))
    clean = straight(x, lost)
    predictions = [_Prediction(guard, clean, lost, least, AGAIN if averaged else SPIKE) for guard in guards]
    for _ in range(ROUNDS):
        hidden = bad | lost
        clean = straight(x, hidden)
        far = [prediction.far(x, clean, hidden, least)[0] for prediction in predictions]
        found = np.logical_or.reduce(far) & ~lost
        if np.array_equal(found, bad):
            break
        bad = found
    if averaged or not bad.any():
        return bad
    crowded = np.convolve(bad, np.ones(2 * AMONG + 1), mode="same") >= CROWD - 0.5
    return _with_chatter(x, bad, lost, least) | (crowded & ~lost)


def _with_chatter(x: Float, bad: Mask, lost: Mask, least: float) -> Mask:
    """Return the spikes `bad` (N,) and those beside a spike of the other sign: where a sensor chatters the neighbours
    of a sample are as wrong as itself, and those further away predict it. What a model lacks has one sign for a while.
    """
    beside = np.ones(2 * BESIDE + 1)
    for _ in range(ROUNDS):
        hidden = bad | lost
        clean = straight(x, hidden)
        far, missed = _Prediction(SIDE, clean, hidden, least, SPIKE).far(x, clean, hidden, least)
        against = [np.convolve(bad & side, beside, mode="same") > 0.5 for side in (missed <= 0.0, missed > 0.0)]
        found = bad | far & np.where(missed > 0.0, *against) & ~lost
        if np.array_equal(found, bad):
            break
        bad = found
    return bad


class _Prediction:
    """A prediction of the samples of a torque from their neighbours, `guard` of which on either side have no part in
    it: by the weights that predict the `clean` ones (N,) best, fitted robustly to those not hidden. What is `bound`
    times the usual off is far off.
    """

    def __init__(self, guard: int, clean: Float, hidden: Mask, least: float, bound: float) -> None:
        self.reach = PARABOLA + guard
        self.bound = bound
        beside = np.arange(guard + 1, guard + 1 + SIDE)
        offsets = np.concatenate([-beside[::-1], beside])
        self.one_sided = np.zeros(2 * self.reach + 1)
        self.one_sided[:PARABOLA] = _parabola(tuple(np.arange(PARABOLA) - self.reach))
        self.taken = np.zeros(2 * self.reach + 1)
        self.taken[self.reach + offsets] = _fitted(offsets, clean, hidden, least)
        self.edges: list[tuple[Mask, Float]] = []
        if hidden.any():
            self._find_edges(hidden, beside, _fitted(beside, clean, hidden, least))

    def _find_edges(self, hidden: Mask, beside: NDArray[Any], weights: Float) -> None:
        """Find the samples beside those that are hidden, and the weights that take the neighbours of each side alone: a
        line across what is hidden begins at the sample itself.
        """
        behind = np.zeros(2 * self.reach + 1)
        behind[self.reach + beside] = weights
        near = np.zeros(behind.size)
        near[self.reach + beside] = 1.0
        before, after = (np.convolve(hidden, side, mode="same") > 0.5 for side in (near, near[::-1]))
        for edge, taken in ((before & ~after & ~hidden, behind), (after & ~before & ~hidden, behind[::-1])):
            if edge.any():
                self.edges.append((edge, taken))

    def far(self, x: Float, clean: Float, hidden: Mask, least: float) -> tuple[Mask, Float]:
        """Return a mask of the samples of `x` (N,) that are far off what the `clean` ones around them predict, from
        either side, and by what these miss each (N,).
        """
        ends = 2.0 * clean[0] - clean[self.reach : 0 : -1], 2.0 * clean[-1] - clean[-2 : -self.reach - 2 : -1]
        padded = np.concatenate([ends[0], clean, ends[1]])
        missed = x - np.convolve(padded, self.taken[::-1], mode="valid")
        size = np.abs(missed)
        at = np.flatnonzero(size > self.bound * _usual(size, hidden, least))
        rows = padded[at[:, None] + np.arange(2 * self.reach + 1)]
        sign = np.sign(missed[at])
        sides = [sign * (x[at] - rows @ taken) for taken in (self.one_sided, self.one_sided[::-1])]
        out = np.zeros(x.size, dtype=bool)
        out[at] = np.minimum(*sides) > ALONE * size[at]
        for edge, taken in self.edges:
            size = np.abs(x - np.convolve(padded, taken[::-1], mode="valid"))
            out = np.where(edge, size > self.bound * _usual(size, hidden, least), out)
        return out, missed


def _fitted(offsets: NDArray[Any], clean: Float, hidden: Mask, least: float) -> Float:
    """Return the weights (M,) of the neighbours at `offsets` that predict the `clean` samples (N,) best."""
    thin, edge = max(1, -(-clean.size // MANY)), int(offsets[-1])
    windows = np.lib.stride_tricks.sliding_window_view(clean, 2 * edge + 1)[::thin]
    inside = slice(edge, clean.size - edge, thin)
    rows, target, counts = windows[:, edge + offsets], clean[inside], ~hidden[inside]
    weights = _parabola(tuple(offsets))
    for _ in range(STEPS):
        missed = target - rows @ weights
        scale = max(_median(np.abs(missed[counts])) / 0.6745, least)
        share = np.maximum(1.0 - (missed / (BISQUARE * scale)) ** 2, 0.0) * counts
        weighted = rows * (share * share)[:, None]
        gram = weighted.T @ rows
        gram[np.diag_indices(len(gram))] += 1e-13 * np.trace(gram) + 1e-300
        weights = np.linalg.solve(gram, weighted.T @ target)
    return np.asarray(weights)


@lru_cache(maxsize=32)
def _parabola(at: tuple[int, ...]) -> Float:
    """Return the weights (M,) of samples at the places `at` that give the value at 0 of a parabola through them."""
    return np.asarray(np.linalg.pinv(np.array(at, dtype=float)[:, None] ** np.arange(3))[0])


def _usual(missed: Float, hidden: Mask, least: float) -> Float:
    """Return the standard deviation (N,) that sizes `missed` (N,) have among the samples around each that are not
    hidden, at least that of all.
    """
    known = missed[~hidden]
    if not known.size:
        return np.full(missed.size, least)
    count = -(-known.size // NEARBY)
    blocks = np.resize(known, count * NEARBY).reshape(count, NEARBY)
    middle = np.partition(blocks, NEARBY // 2, axis=1)[:, NEARBY // 2]
    whole = max(_median(middle), 0.6745 * least)
    around = np.maximum(np.cumsum(~hidden) - 1, 0) // NEARBY
    return np.asarray(np.maximum(middle, whole)[around] / 0.6745)


def _median(x: Float) -> float:
    """Return about the median of `x`."""
    return float(np.partition(x, x.size // 2)[x.size // 2])
