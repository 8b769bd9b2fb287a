"""The words of the torque language that have a memory. Each works on one recording, on its own clock `t` (N,).

The signal x is (N,), or (V, N) where it differs between V trials; the parameter is a number, or (V, 1).

play(x, h)      what follows x through a gap of half-width h (backlash)
dahl(x, σ)      friction state z with dz/dx = σ (1 - z sgn dx), between -1 and 1 (Dahl, 1968)
delay(x, d)     x(t - d); before the first and after the last sample the edge value is held
lag(x, T)       what a filter of first order with the time constant T makes of x, from its first value
slow(x, f)      x without what is faster than f (Hz), without delay: a Gaussian, half the power at f
ddt(x)          derivative with respect to time, of second order for non-uniform sampling too
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from exoid.ground.errors import EffectError
from exoid.symbolic.motion import Float

FORGOTTEN = 1e-30
"""What is left of a state that no longer counts."""
SAME_TIME = 1e-9
"""Share of a sampling step that two times may differ by and be the same but for rounding."""


def play(t: Float, x: Float, h: Float | float) -> Float:
    """Return the play (backlash) operator of x: at rest until x leaves [w - h, w + h]; w starts at x[0].

    EffectError for a negative h.
    """
    _not_negative("play", "the half-width h", h)
    low, high = x - h, x + h
    low[..., 0] = high[..., 0] = x[..., 0]
    # Every sample confines w to [x - h, x + h], and confined twice is confined once: after each pass a sample knows
    # what twice as many have done.
    reach = 1
    while reach < x.shape[-1] and not np.array_equal(low, high):
        own = low[..., reach:].copy(), high[..., reach:].copy()
        for side in (low, high):
            side[..., reach:] = np.minimum(np.maximum(side[..., :-reach], own[0]), own[1])
        reach *= 2
    return np.asarray(low)


def dahl(t: Float, x: Float, sigma: Float | float) -> Float:
    """Return the Dahl friction state z along x of stiffness `sigma` (1/unit of x), from z = 0.

    Between two samples x is taken to move one way, for which the equation is solved exactly:
    z -> s + (z - s) exp(-σ |Δx|), s = sgn Δx. EffectError for a negative sigma.
    """
    _not_negative("dahl", "the stiffness sigma", sigma)
    step = np.diff(x)
    path = sigma * np.abs(step)
    keep = np.exp(-path)
    z = -np.sign(step) * np.expm1(-path)
    _accumulate(z, keep)
    return np.concatenate([np.zeros((*z.shape[:-1], 1)), z], axis=-1)


def delay(t: Float, x: Float, d: Float | float) -> Float:
    """Return x as it was `d` seconds before (a negative d looks ahead)."""
    at, rows = np.broadcast_arrays(t - d, x)
    if rows.ndim == 1:
        return np.asarray(np.interp(at, t, rows))
    return np.stack([np.interp(when, t, row) for when, row in zip(at, rows, strict=True)])


def lag(t: Float, x: Float, constant: Float | float) -> Float:
    """Return x behind a filter of first order with a time `constant` T (s): T y' = x - y, from y = x.

    Between two samples x is taken to be what it is at the later one. EffectError for a negative constant.
    """
    _not_negative("lag", "the time constant T", constant)
    steps = np.diff(t) / np.maximum(constant, FORGOTTEN)
    first = np.zeros((*steps.shape[:-1], 1))
    keep = np.concatenate([first, np.exp(-steps)], axis=-1) * np.ones(x.shape)
    y = np.concatenate([first + 1.0, -np.expm1(-steps)], axis=-1) * x
    _accumulate(y, keep)
    return np.asarray(y)


def ddt(t: Float, x: Float) -> Float:
    """Return dx/dt by parabolas through three neighbours; zero where there is only one sample."""
    if len(t) < 2:
        return np.zeros(x.shape)
    return np.asarray(np.gradient(x, t, edge_order=2 if len(t) > 2 else 1, axis=-1))


def slow(t: Float, x: Float, f: Float | float) -> Float:
    """Return x smoothed by a Gaussian that halves the power at `f` Hz, for non-uniform sampling too.

    Beyond the ends x is continued by its odd reflection. EffectError where f is not positive.
    """
    if np.ndim(f) or np.ndim(x) > 1:
        rows = np.broadcast_arrays(x, np.asarray(f, dtype=float))
        return np.stack([slow(t, row, float(each[0])) for row, each in zip(*rows, strict=True)])
    if not f > 0.0:
        raise EffectError(f"the frequency f is {f!r}", where="slow", remedy="give a positive number of Hz")
    step = (t[-1] - t[0]) / max(len(t) - 1, 1)
    if step <= 0.0:
        return np.array(x, dtype=float)
    even = t[0] + step * np.arange(len(t))
    width = np.sqrt(np.log(2.0)) / (2.0 * np.pi * f) / step
    reach = min(int(np.ceil(4.0 * width)), len(t) - 1)
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    uneven = bool(np.abs(even - t).max() > SAME_TIME * step)
    y = np.interp(even, t, x) if uneven else x
    y = np.concatenate([2.0 * y[0] - y[reach:0:-1], y, 2.0 * y[-1] - y[-2 : -reach - 2 : -1]])
    smooth = np.convolve(y, weight / weight.sum(), mode="valid")
    return np.interp(t, even, smooth) if uneven else smooth


MEMORY: Mapping[str, Callable[..., Float]] = {
    "play": play, "dahl": dahl, "delay": delay, "lag": lag, "slow": slow, "ddt": ddt
}  # fmt: skip
"""Word of the language -> function of (t, x, parameter)."""


def _accumulate(state: Float, keep: Float) -> None:
    """Add to each entry of `state` (..., N), in place, the one before it times the part of that which `keep` says."""
    reach = 1
    while reach < state.shape[-1] and keep.any():
        state[..., reach:] += keep[..., reach:] * state[..., :-reach]
        keep[..., reach:] *= keep[..., :-reach].copy()
        keep[keep < FORGOTTEN] = 0.0
        reach *= 2


def _not_negative(word: str, what: str, value: Float | float) -> None:
    if not np.all(np.asarray(value) >= 0.0):
        raise EffectError(f"{what} is {value!r}", where=word, remedy="give a number that is not negative")
