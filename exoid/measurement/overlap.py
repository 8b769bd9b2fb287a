"""Do two recordings share samples? Judged by the samples, whatever the file's name, format, units, digits or clock.

Motion made again has sensor noise of its own; a copy has the same noise. So the fast part of every channel, where noise
prevails, is compared: stretches of the shorter recording are looked for in the longer one at every shift, and at the
shift found all channels have to agree, in their fast part or to within half a step of the coarser digits. Every moment
counts alike: at the jolts of friction motion made again agrees as well. Scale and sign of a channel do not matter. A
copy that was resampled and given noise is told by whose the difference is (`noisy_copy.py`). Motion that was simulated
twice without noise is the same samples twice and counts as shared: the second run tells nothing that the first did not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import RecordingError
from exoid.ground.ties import index_of_greatest
from exoid.measurement.auditing.channels import step_of
from exoid.measurement.finding import Finding
from exoid.measurement.noisy_copy import BAND, BLOCK, noisy_copy, offset_of
from exoid.measurement.recording import Recording
from exoid.measurement.signals.butterworth import band_pass_filter, both_ways
from exoid.symbolic.motion import Float

Mask = NDArray[np.bool_]

STRETCH, STRETCHES, LEAST = 256, 8, 128
"""Samples of a stretch, stretches looked for, samples that an overlap needs at least."""
SAME_CLOCK = 1e-6
"""Relative difference of two sampling rates that rounding explains."""
SAME, RESAMPLED = 0.95, 0.85
"""Correlation of the fast parts from which on they are the same; where one recording was resampled."""
LEAST_PIECES, LEAST_SHARE = 3, 0.05
"""Pieces of 128 samples that have to agree, and their share: motion made again may start with the same jolt."""
TONE, TONE_LAG = 0.8, 12
"""Likeness of a fast part to itself, so many samples later or more, from which on it is a tone."""
MOST_THINNED = 10
"""Largest n for which a copy of every n-th sample is looked for."""
DIGITS = 0.6
"""RMS difference, in steps of the coarser digits, up to which rounding explains it."""
WHOLE = 0.9
"""Share of a recording's samples that another one has too, from which on it is left out as a whole."""


@dataclass(frozen=True, eq=False)
class Overlap:
    """Samples of the `second` recording that the `first` has too: `rows` (N,) marks them."""

    first: str
    second: str
    rows: Mask
    seconds: float

    @property
    def share(self) -> float:
        """Share of the second recording."""
        return float(np.mean(self.rows))

    @property
    def sentence(self) -> str:
        """The overlap in words."""
        part = "all of it" if self.share > WHOLE else f"{self.seconds:.3g} s, {self.share:.0%} of it"
        return f"{self.second} holds the same samples as {self.first} ({part})"


@dataclass(frozen=True, eq=False)
class _Even:
    """Angles and torques (N, 4), evenly sampled, and their fast part (N, 4)."""

    values: Float
    fast: Float
    _spectra: dict[int, tuple[Any, Float]] = field(default_factory=dict, init=False, repr=False)

    def spectrum(self, channel: int) -> tuple[Any, Float]:
        """Return the spectrum of a channel's fast part, so long that nothing wraps around into shifts at which a part
        of it is inside, and the power (N + 1,) before each sample.
        """
        if channel not in self._spectra:
            whole = self.fast[:, channel]
            power = np.concatenate([[0.0], np.cumsum(whole**2)])
            self._spectra[channel] = np.fft.rfft(whole, 1 << (whole.size - 1).bit_length()), power
        return self._spectra[channel]


def overlap(first: Recording, second: Recording, known: dict[Recording, _Even] | None = None) -> Overlap | None:
    """Return the overlap of two recordings, the samples of `second` that are in `first` too; None where there are none.

    What is `known` of recordings is used again, and added to.
    """
    if min(len(first), len(second)) < LEAST:
        return None
    rows = _shared_rows(first, second, {} if known is None else known)
    if not rows.any():
        return None
    return Overlap(_name(first), _name(second), rows, float(rows.sum() / second.rate))


def _shared_rows(first: Recording, second: Recording, known: dict[Recording, _Even]) -> Mask:
    """Return a mask (N,) of the samples of `second` that are in `first`: as they stand, every n-th of the faster, or
    resampled.
    """
    slow, quick = sorted((first.rate, second.rate))
    for item in (first, second):
        if item not in known:
            known[item] = _even(item)
    a, b = known[first], known[second]
    rows = _match(a, b, SAME)[1]
    if rows.any():
        return rows
    if quick >= 1.02 * slow:
        rows = _resampled_rows(first, second, a, b)
    return rows if rows.any() else _noisy_rows(first, second, a.values, b.values)


def _resampled_rows(first: Recording, second: Recording, a: _Even, b: _Even) -> Mask:
    """Return a mask (N,) of the samples of `second` that are in `first`, sampled at another rate; `a` and `b` are their
    samples.
    """
    slow, quick = sorted((first.rate, second.rate))
    factor = round(quick / slow)
    if 2 <= factor <= MOST_THINNED and abs(quick / slow - factor) < 0.02 * factor:
        for phase in range(factor):
            if first.rate > second.rate:
                rows = _match(_even(_thinned(first, phase, factor)), b, SAME)[1]
            else:
                rows = np.zeros(len(second), bool)
                rows[phase::factor] = _match(a, _even(_thinned(second, phase, factor)), SAME)[1]
            if rows.any():
                return rows if first.rate > second.rate else _filled(rows, factor)
    rows = _match(_even(first, quick, slow), _even(second, quick, slow), RESAMPLED)[1]
    place = np.round((second.t - second.t[0]) * quick).astype(int)
    return np.asarray(rows[np.clip(place, 0, rows.size - 1)])


def _noisy_rows(first: Recording, second: Recording, a: Float, b: Float) -> Mask:
    """Return a mask (N,) of the samples of `second` that are in `first` with noise added, or the other way round; `a`
    and `b` are their values. Asked of the times, and sample by sample where the clocks may differ.
    """
    rows = np.zeros(len(b), bool)
    clocks = [(first.t, second.t)]
    if abs(first.rate / second.rate - 1.0) > SAME_CLOCK:
        clocks.append((np.arange(len(a), dtype=float), np.arange(len(b), dtype=float)))
    for t, other in clocks:
        offset = offset_of(t, a, other, b)
        if offset is None:
            continue
        copied = noisy_copy(t, a, other, b, offset)
        if copied is not None:
            rows[copied] = True
            return rows
        copied = noisy_copy(other, b, t, a, -offset)
        if copied is not None:
            inside = t[copied] - offset
            return np.asarray((other >= inside[0]) & (other <= inside[-1]))
    return rows


def _thinned(recording: Recording, phase: int, factor: int) -> Recording:
    """Return every `factor`-th row from the row `phase` on."""
    rows = slice(phase, None, factor)
    columns = recording.t[rows], recording.q[rows], recording.tau[rows]
    return Recording(recording.name, *columns, joints=recording.joints)


def _filled(rows: Mask, factor: int) -> Mask:
    """Return `rows` (N,) with the rows between those every `factor`-th of which is marked."""
    return np.asarray(np.convolve(rows, np.ones(2 * factor - 1), mode="same") > 0)


def held_apart(
    fitted: Sequence[Recording], unseen: Sequence[Recording]
) -> tuple[tuple[Recording, ...], tuple[Recording, ...], tuple[Finding, ...]]:
    """Return the recordings with every sample once, and what was found.

    Raises RecordingError where an unseen recording shares samples with a fitted one: what was fitted cannot show how
    well unseen motion is predicted.
    """
    known: dict[Recording, _Even] = {}
    for held in unseen:
        for item in fitted:
            found = overlap(item, held, known)
            if found is not None:
                raise RecordingError(
                    f"this recording is held out, but shares samples with a fitted one: {found.sentence}",
                    where=_name(held),
                    remedy="hold out a recording of its own, or fit without the other one; motion simulated twice "
                    "without noise is the same samples twice",
                )
    kept, doubled = _once(fitted, known)
    kept_unseen, doubled_unseen = _once(unseen, known)
    return kept, kept_unseen, (*doubled, *doubled_unseen)


def _once(
    recordings: Sequence[Recording], known: dict[Recording, _Even]
) -> tuple[tuple[Recording, ...], tuple[Finding, ...]]:
    """Return `recordings` without the samples that one before them has already, longest first."""
    kept: dict[int, Recording] = {}
    findings = []
    for k in sorted(range(len(recordings)), key=lambda k: (-len(recordings[k]), k)):
        recording = recordings[k]
        for other in kept.values():
            found = overlap(other, recording, known)
            if found is None:
                continue
            whole = found.share > WHOLE
            what = f"{found.sentence}; {'it is' if whole else 'these samples are'} left out, so that each counts once"
            remedy, consequence = "name every recording once", "samples counted twice fake certainty"
            findings.append(
                Finding("overlap", "warning", what, _name(recording), found.share, 0.0, remedy, consequence)
            )
            if whole:
                break
            recording = replace(recording, valid=recording.valid & ~found.rows)
        else:
            kept[k] = recording
    return tuple(kept[k] for k in sorted(kept)), tuple(findings)


def _name(recording: Recording) -> str:
    return recording.source.path or recording.name


def _even(recording: Recording, rate: float | None = None, slow: float | None = None) -> _Even:
    """Return the samples one after the other, or at `rate` Hz; fast is relative to their own rate, or to `slow` Hz."""
    values = np.column_stack([recording.q, recording.tau])
    if rate is not None:
        t = recording.t - recording.t[0]
        grid = np.arange(0.0, t[-1], 1.0 / rate)
        values = np.column_stack([np.interp(grid, t, column) for column in values.T])
    band = 2.0 * np.array(BAND) * (1.0 if rate is None or slow is None else slow / rate)
    # the mean first: a filter's start must not depend on where a copy was cut
    fast = both_ways(band_pass_filter(2, *map(float, band)), values - values.mean(axis=0), 0)
    return _Even(values, fast)


def _match(a: _Even, b: _Even, same: float) -> tuple[Mask, Mask]:
    """Return masks of the samples of `a` and of `b` that are the same."""
    short, long = (a, b) if len(a.fast) <= len(b.fast) else (b, a)
    in_short, in_long = np.zeros(len(short.fast), bool), np.zeros(len(long.fast), bool)
    joints = a.values.shape[1] // 2
    torques_first = (*range(joints, 2 * joints), *range(joints))
    channels = [c for c in torques_first if _moves(short, c) and _moves(long, c)]
    size = min(STRETCH, len(short.fast))
    edge = min(16, (len(short.fast) - size) // 2)
    starts = np.unique(np.linspace(edge, len(short.fast) - size - edge, STRETCHES).astype(int))
    tried: set[int] = set()
    for start in starts:
        if in_short[start : start + size].any():
            continue
        for channel in channels[:2]:
            shift = _shift(short.fast[start : start + size, channel], long, channel, same)
            if shift is None:
                continue
            shift -= int(start)
            if shift in tried:
                break
            tried.add(shift)
            for first, last in _agreeing(short, long, shift, channels, same):
                in_short[first:last] = True
                in_long[first + shift : last + shift] = True
    return (in_short, in_long) if short is a else (in_long, in_short)


def _moves(one: _Even, channel: int) -> bool:
    values = one.values[:, channel]
    return bool(np.std(one.fast[:, channel]) > 1e-9 * max(float(np.max(np.abs(values))), 1e-12))


def _shift(part: Float, long: _Even, channel: int, same: float) -> int | None:
    """Return the index in a channel of `long` at which the stretch `part` (S,) stands, up to scale; None where it is
    not there.
    """
    spectrum, power = long.spectrum(channel)
    length = 2 * (spectrum.size - 1)
    product = np.fft.irfft(spectrum * np.conj(np.fft.rfft(part, length)), length)
    product = product[: power.size - part.size]
    energy = (power[part.size :] - power[: -part.size]) * float(part @ part)
    likeness = np.abs(product) / np.sqrt(np.maximum(energy, 1e-12 * max(float(energy.max()), 1e-300)))
    best = index_of_greatest(likeness, 1.0)
    return best if likeness[best] >= same - 0.05 else None


def _agreeing(short: _Even, long: _Even, shift: int, channels: Sequence[int], same: float) -> list[tuple[int, int]]:
    """Return (first, last) of the stretches of `short` in which all `channels` are those of `long`, `shift` later.

    A few may agree where a jolt or a tone comes again with the motion.
    """
    first, last = max(0, -shift), min(len(short.fast), len(long.fast) - shift)
    pieces, plain = [], []
    size = min(LEAST, last - first)
    for start in range(first, last - size + 1, size) if size > 16 else ():
        # the last piece takes what is left over
        stop = last if last - (start + size) < size else start + size
        x, y = slice(start, stop), slice(start + shift, stop + shift)
        likes = [_alike(short, long, x, y, channel, same) for channel in channels]
        pieces.append((start, stop) if likes and all(like > 0 for like in likes) and max(likes) == 2 else None)
        plain.append(not all(_is_tone(short.fast[x, c]) for c, like in zip(channels, likes, strict=True) if like == 2))
    agreeing = [piece is not None for piece in pieces]
    told = sum(agree and more for agree, more in zip(agreeing, plain, strict=True))
    enough = told >= min(len(pieces), max(LEAST_PIECES, LEAST_SHARE * len(pieces)))
    return [piece for piece in pieces if piece is not None] if enough else []


def _is_tone(fast: Float) -> bool:
    """True if a fast part (N,) repeats itself: a grid of angles crossed at one speed sounds alike in any recording."""
    lags = np.fft.irfft(np.abs(np.fft.rfft(fast, 2 * fast.size)) ** 2)[: fast.size // 2 + 1]
    overlapping = 1.0 - np.arange(lags.size) / fast.size
    return bool(np.max(np.abs(lags[TONE_LAG:] / overlapping[TONE_LAG:]), initial=0.0) > TONE * lags[0])


def likeness(a: Float, b: Float) -> float:
    """Return the likeness of two fast parts (N,), up to scale and sign: the median correlation of their BLOCKs.

    Each block counts alike: where friction jolts at a reversal, motion made again agrees, and between the jolts, where
    only noise is left, it does not.
    """
    count = len(a) // BLOCK
    if not count:
        return 0.0
    x, y = (item[: count * BLOCK].reshape(count, BLOCK) for item in (a, b))
    power = np.sqrt(np.sum(x**2, axis=1) * np.sum(y**2, axis=1))
    each = np.sum(x * y, axis=1) / np.where(power > 0.0, power, 1.0)
    return abs(float(np.median(each)))


def _alike(short: _Even, long: _Even, x: slice, y: slice, channel: int, same: float) -> int:
    """Return 2 where a channel's fast parts are the same, 1 where the digits explain the difference, else 0."""
    if likeness(short.fast[x, channel], long.fast[y, channel]) >= same:
        return 2
    a, b = short.values[x, channel], long.values[y, channel]
    steps = step_of(a), step_of(b)
    a, b = a - a.mean(), b - b.mean()
    slope = float(a @ b) / max(float(a @ a), 1e-300)
    left = float(np.sqrt(np.mean((b - slope * a) ** 2)))
    return int(left <= DIGITS * max(abs(slope) * steps[0], steps[1]) and left <= 0.2 * float(np.std(b)))
