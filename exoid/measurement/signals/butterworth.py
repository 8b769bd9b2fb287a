"""Butterworth filters that run forwards and backwards, so that nothing is delayed.

A filter is kept as a sum of its modes, H(z) = d + Σ r / (z - p) over its poles p: then a stretch of samples is one
matrix product, and only the few states at the ends of stretches are carried on. That is as exact as the usual
recursion, serves hundreds of columns at once, and gives any samples of the result without the others. (SciPy's filters
are the check on it in the tests. Importing them takes 0.5 s, and `discover` 1.4 s in all on the demo's recordings;
every fourth of 3000 samples of 200 rows takes `sosfiltfilt` 10.7 ms, matrix products 1.8 ms, C 0.4 ms.)
"""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import c_double, c_long, c_void_p
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from exoid.measurement.signals.compiled import FEWEST, BridgeInC, row_library
from exoid.symbolic.codegen.cache import CompiledLibrary
from exoid.symbolic.motion import Float
from exoid.symbolic.waves import RENEWED, Waves, spacing, turned

STRETCH = 64
"""Samples that one matrix product filters."""
KEPT = 32
"""Kept samples that one matrix product gives."""
TOGETHER = 25_000
"""Values that are filtered at once: more do not stay in the cache of a processor."""
FORGOTTEN = 1e-15
"""What is left of a state that no longer counts."""


@dataclass(frozen=True, eq=False)
class Filter:
    """H(z) = `direct` + Σ `residues` / (z - `poles`), (P,) each: the upper pole of each pair, its residue doubled."""

    poles: Any
    residues: Any
    direct: float

    @property
    def steady(self) -> Any:
        """States (P,) that a constant of one settles to."""
        return 1.0 / (1.0 - self.poles)

    def response(self, count: int) -> Float:
        """Return the response (count,) to one sample, that sample included."""
        out = np.real(self.poles[:, None] ** np.arange(-1, count - 1) * self.residues[:, None]).sum(axis=0)
        out[0] = self.direct
        return np.asarray(out)

    def run(self, rows: Float) -> Float:
        """Return `rows` (C, N) filtered forwards, as if each had stood at its first value before."""
        count, samples = rows.shape
        stretches = -(-samples // STRETCH)
        x = np.zeros((count, stretches * STRETCH))
        x[:, :samples] = rows
        x = x.reshape(count, stretches, STRETCH)
        inner, entry, exit_ = self._stretch
        both = x @ inner
        states = np.empty((count, stretches, self.poles.size), dtype=complex)
        states[:, 0] = rows[:, :1] * self.steady
        states[:, 1:] = (x @ entry)[:, :-1].view(complex)
        _carry(np.moveaxis(states, 2, 0), (self.poles**STRETCH)[:, None, None])
        both += states.view(float) @ exit_
        return np.asarray(both.reshape(count, -1)[:, :samples])

    @cached_property
    def _stretch(self) -> tuple[Float, Float, Float]:
        """Return the matrices from a stretch to itself, (S, S), to the states behind it, (S, 2P), and back from them,
        (2P, S).
        """
        at = np.arange(STRETCH)
        lag = at[None, :] - at[:, None]
        inner = np.where(lag >= 0, self.response(STRETCH)[np.maximum(lag, 0)], 0.0)
        return inner, _parts(self.poles ** (STRETCH - 1 - at)[:, None]), _onto(self.residues, self.poles, at)


def _parts(values: Any) -> Float:
    """Return complex (..., P) as real (..., 2P), real and imaginary parts in turn."""
    return np.ascontiguousarray(values).view(float)


def _onto(factors: Any, poles: Any, steps: Any) -> Float:
    """Return the matrix (2P, S) from real and imaginary parts of states to Re Σ factors · poles^steps · states."""
    values = factors[:, None] * poles[:, None] ** steps
    out = np.empty((2 * poles.size, values.shape[1]))
    out[0::2], out[1::2] = values.real, -values.imag
    return out


def _carry(states: Any, step: Any) -> None:
    """Turn what each stretch adds to its states (..., S), in place, into the states: s[k] += step · s[k - 1]."""
    reach, factor = 1, step
    while reach < states.shape[-1] and np.abs(factor).max() > FORGOTTEN:
        states[..., reach:] += factor * states[..., :-reach]  # a copy, so that nothing is carried twice
        reach, factor = 2 * reach, factor**2


def _made(zeros: Any, poles: Any, gain: float) -> Filter:
    """Return gain · Π (z - zeros) / Π (z - poles), as many of one as of the other."""
    residues = np.array(
        [gain * np.prod(p - zeros) / np.prod(np.delete(p - poles, k)) for k, p in enumerate(poles)], dtype=complex
    )
    upper = poles.imag >= 0.0
    return Filter(poles[upper], np.where(poles[upper].imag > 0.0, 2.0, 1.0) * residues[upper], gain)


def _prototype(order: int) -> Any:
    """Return the poles of the analogue low-pass with a cut-off of 1 rad/s."""
    return np.exp(0.5j * np.pi * (2.0 * np.arange(order) + order + 1.0) / order)


@lru_cache(maxsize=64)
def low_pass_filter(order: int, share: float) -> Filter:
    """Return the low-pass of even `order` with its cut-off at `share` of half the sampling rate."""
    analogue = np.tan(0.5 * np.pi * share) * _prototype(order)
    poles = (1.0 + analogue) / (1.0 - analogue)
    gain = float(np.real(np.prod((1.0 - poles) / 2.0)))
    return _made(np.full(order, -1.0), poles, gain)


@lru_cache(maxsize=64)
def band_pass_filter(order: int, low: float, high: float) -> Filter:
    """Return the band-pass made of a low-pass of `order`; its edges are shares of half the sampling rate."""
    edges = np.tan(0.5 * np.pi * np.array([low, high]))
    width, centre = edges[1] - edges[0], edges[0] * edges[1]
    half = 0.5 * width * _prototype(order)
    root = np.sqrt(half**2 - centre + 0.0j)
    analogue = np.concatenate([half + root, half - root])
    poles = (1.0 + analogue) / (1.0 - analogue)
    gain = float(np.real(width**order / np.prod(1.0 - analogue)))
    return _made(np.repeat([1.0, -1.0], order), poles, gain)


def both_ways(one: Filter, x: Float, pad: int) -> Float:
    """Return `x` (N, ...) filtered forwards and backwards, continued by `pad` samples of its odd reflection."""
    rows = np.ascontiguousarray(x.reshape(len(x), -1).T, dtype=float)
    if pad:
        rows = np.concatenate([_before(rows, pad), rows, _after(rows, pad)], axis=1)
    back = one.run(np.ascontiguousarray(one.run(rows)[:, ::-1]))[:, ::-1]
    return np.ascontiguousarray(back[:, pad : pad + len(x)].T).reshape(x.shape)


def _before(rows: Float, count: int) -> Float:
    return np.asarray(2.0 * rows[:, :1] - rows[:, count:0:-1])


def _after(rows: Float, count: int) -> Float:
    return np.asarray(2.0 * rows[:, -1:] - rows[:, -2 : -count - 2 : -1])


def both_ways_at(
    one: Filter, rows: Float, first: int, step: int, count: int, reach: int, out: Float | None = None
) -> Float:
    """Return `count` samples, every `step`-th from `first` on, of `rows` (C, N) filtered both ways, as (C, K).

    What is more than `reach` samples away does not count (so many must be there); beyond the ends the rows are
    continued by their odd reflection. Written into `out` (C, K), contiguous, where that is given.
    """
    out = np.empty((len(rows), count)) if out is None else out
    library = row_library(one.poles.size) if len(rows) >= FEWEST else None
    if library is None:
        out[:] = _by_products(one, rows, first, step, count, reach)
        return out
    return _compiled(library, one, rows, first, step, reach, out)


def _compiled(
    library: CompiledLibrary, one: Filter, rows: Float, first: int, step: int, reach: int, out: Float
) -> Float:
    """Do it sample by sample, some rows side by side."""
    x = np.ascontiguousarray(rows, dtype=float)
    given, modes = _given(one, x.shape[1], first, step, out.shape[1], reach)
    data = (c_void_p(array.ctypes.data) for array in (*modes, x, out))
    if library.c.exoid_both_ways_at(c_long(len(x)), *given, *data):
        raise MemoryError("no memory for the rows that are filtered")
    return out


@lru_cache(maxsize=32)
def _given(
    one: Filter, samples: int, first: int, step: int, count: int, reach: int
) -> tuple[list[c_long | c_double], tuple[Float, Float]]:
    """Return the arguments of the C function about the samples that are kept of so many, and the poles and factors of
    the filter.
    """
    beyond = -(-count // KEPT) * KEPT * step  # as far as products reach
    before = max(0, min(samples - 1, reach - first))
    after = max(0, min(samples - 1, first + beyond + reach - samples))
    poles, factors, extra = _modes(one)
    counts = [c_long(number) for number in (samples, first, step, count, before, after)]
    own = c_double(extra - float(np.sum(factors.real)))  # both ways a sample counts itself
    return [*counts, own], (_parts(poles), _parts(factors))


@dataclass(frozen=True, eq=False)
class WaveProducts:
    """Sums over kept samples of products of filtered waves (V, m) with signals, `both` (S, V, m, Q), and with each
    other, `square` (U, V, m, m), for U weightings; and the `largest` square at each sample (V, K).
    """

    both: Float
    square: Float
    largest: Float


def filtered_wave_products(
    one: Filter, waves: Waves, numbers: Float, bridges: Sequence[BridgeInC], first: int, step: int, reach: int,
    weights: Float, signals: Float,
) -> WaveProducts | None:
    """Return the products of evenly spaced waves at `numbers` (V,), bridged joint by joint and filtered as rows of them
    are by `both_ways_at`, for `weights` (U, A, K) and weighted `signals` (S, A, K, Q); None without a compiler.
    """  # fmt: skip
    library = row_library(one.poles.size)
    if library is None:
        return None
    (pairs, joints, samples), (told, _, count, width), units = waves.carried.shape, signals.shape, len(weights)
    wide, many, whole, columns = -(-width // 4) * 4, -(-units // 4) * 4, len(numbers), 2 * pairs
    padded = np.pad(signals, ((0, 0), (0, 0), (0, 0), (0, wide - width)))
    weighted = np.ascontiguousarray(np.moveaxis(np.pad(weights, ((0, many - units), (0, 0), (0, 0))), 0, 2))
    both, square = np.empty((told, whole, columns, wide)), np.empty((many, whole, columns, columns))
    largest = np.empty((whole, count))
    given, modes = _given(one, samples, first, step, count, reach)
    turn, carried = waves.turn(spacing(numbers)), np.ascontiguousarray(waves.carried)
    across = (BridgeInC * joints)(*bridges)
    for at in range(0, whole, RENEWED):
        some, start = min(whole - at, RENEWED), turned(numbers[at] * waves.phase)
        failed = library.c.exoid_wave_products(
            *map(c_long, (some, pairs, joints)), *given,
            *(c_void_p(array.ctypes.data) for array in (*modes, start, turn, carried)), across,
            *map(c_long, (many, told, wide, whole)),
            *(c_void_p(array.ctypes.data) for array in (weighted, padded)),
            *(c_void_p(array.ctypes.data) for array in (both[:, at:], square[:, at:], largest[at:])),
        )  # fmt: skip
        if failed:
            raise MemoryError("no memory for the waves that are filtered")
    return WaveProducts(both[..., :width], square[:units], largest)


def _by_products(one: Filter, rows: Float, first: int, step: int, count: int, reach: int) -> Float:
    """Do it by matrix products."""
    inside, onto, beside = _kept(one, step)
    many, samples = rows.shape
    length, stretches, states = KEPT * step, -(-count // KEPT), 2 * one.poles.size
    begin = first - beside * length  # the sample at which a row of `x` begins
    some = max(1, min(many, TOGETHER // samples))
    x = np.zeros((some, stretches + 2 * beside, length))
    around = np.empty((some, stretches, 2 * beside, states))
    flat, out = x.reshape(some, -1), np.empty((many, stretches, KEPT))
    end = min(samples, begin + flat.shape[1])
    before = min(-begin, reach - first)
    after = min(samples - 1, begin + flat.shape[1] - samples, first + stretches * length + reach - samples)
    for at in range(0, many, some):
        part = rows[at : at + some]
        now = slice(len(part))
        flat[now, max(0, -begin) : end - begin] = part[:, max(0, begin) : end]
        if before > 0:
            flat[now, -begin - before : -begin] = _before(part, before)
        if after > 0:
            flat[now, end - begin : end - begin + after] = _after(part, after)
        # Row by row: products of all rows at once are so large that a library shares them among threads, at a loss.
        each = x[now] @ inside
        for k in range(beside):
            around[now, :, k] = each[:, k : k + stretches, KEPT : KEPT + states]
            around[now, :, beside + k] = each[:, beside + 1 + k : beside + 1 + k + stretches, KEPT + states :]
        np.add(
            each[:, beside : beside + stretches, :KEPT],
            around[now].reshape(len(part), stretches, -1) @ onto,
            out=out[at : at + some],
        )
    return out.reshape(many, -1)[:, :count]


@lru_cache(maxsize=32)
def _kept(one: Filter, step: int) -> tuple[Float, Float, int]:
    """Return the matrix from a stretch to its kept samples and to the states behind and before it, (S, K + 4P), that
    from states of the stretches beside it to its kept samples, (4P B, K), and how many of these count on either side,
    B.
    """
    length, at = KEPT * step, step * np.arange(KEPT)
    inside = np.arange(length)
    poles, factors, extra = _modes(one)
    pulse = np.real(np.sum(factors[:, None] * poles[:, None] ** np.arange(length), axis=0))
    pulse[0] += extra
    own = pulse[np.abs(at[None, :] - inside[:, None])]
    parts = [_parts(one.poles ** lag[:, None]) for lag in (length - inside, inside)]
    beside = int(np.ceil(np.log(FORGOTTEN) / (length * np.log(np.abs(one.poles).max()))))
    carried = [factors * one.poles ** (length * k) for k in range(beside)]
    onto = [_onto(each, one.poles, at) for each in reversed(carried)]
    onto += [_onto(each, one.poles, length - at) for each in carried]
    return np.concatenate([own, *parts], axis=1), np.concatenate(onto), beside


@lru_cache(maxsize=32)
def _modes(one: Filter) -> tuple[Any, Any, float]:
    """Return poles p and factors c (P,) of H(z) H(1/z) = Σ c p^|n|, and what there is besides at n = 0."""
    mirrored = [one.direct + np.sum(np.where(one.poles.imag > 0, 0.5, 1.0) * _pair(one, 1.0 / p)) for p in one.poles]
    origin = one.direct + np.sum(np.where(one.poles.imag > 0, 0.5, 1.0) * _pair(one, 0.0))
    return one.poles, one.residues * np.array(mirrored) / one.poles, float(np.real(one.direct * origin))


def _pair(one: Filter, z: Any) -> Any:
    """Return the part of each pole and its conjugate in H(z), with the residues doubled for pairs."""
    pairs = one.residues / (z - one.poles)
    return np.where(one.poles.imag > 0, pairs + np.conj(one.residues) / (z - np.conj(one.poles)), pairs)
