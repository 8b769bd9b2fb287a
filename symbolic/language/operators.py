"""The words of the torque language that have a memory. Each works on one recording, on its own clock.

play(x, h)      what follows x through a gap of half-width h (backlash)
dahl(x, σ)      friction state z with dz/dx = σ (1 - z sgn dx), between -1 and 1 (Dahl, 1968)
delay(x, d)     x(t - d); before the first and after the last sample the edge value is held
slow(x, f)      x without what is faster than f (Hz), without delay: a Gaussian, half the power at f
ddt(x)          derivative with respect to time, of second order on an uneven clock too
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import accumulate

import numpy as np

from ground.errors import EffectError
from symbolic.motion import Float


def play(t: Float, x: Float, h: float) -> Float:
    """Return the play (backlash) operator (N,) of x (N,): at rest until x leaves [w - h, w + h]; w starts at
    x[0].

    EffectError for a negative h.
    """
    _not_negative("play", "the half-width h", h)

    def follow(w: float, value: float) -> float:
        if value - h > w:
            return value - h
        return value + h if value + h < w else w

    values = x.tolist()
    return np.fromiter(accumulate(values, follow), dtype=float, count=len(values))


def dahl(t: Float, x: Float, sigma: float) -> Float:
    """Return the Dahl friction state z (N,) along x (N,) of stiffness `sigma` (1/unit of x), from z = 0.

    Between two samples x is taken to move one way, for which the equation is solved exactly:
    z -> s + (z - s) exp(-σ |Δx|), s = sgn Δx. EffectError for a negative sigma.
    """
    _not_negative("dahl", "the stiffness sigma", sigma)
    step = np.diff(x)
    path = sigma * np.abs(step)
    keep = np.exp(-path)
    gain = -np.sign(step) * np.expm1(-path)
    out = np.zeros(len(x))
    z = 0.0
    states = []
    for k, g in zip(keep.tolist(), gain.tolist(), strict=True):
        z = k * z + g
        states.append(z)
    out[1:] = states
    return out


def delay(t: Float, x: Float, d: float) -> Float:
    """Return x (N,) as it was `d` seconds before (a negative d looks ahead)."""
    return np.interp(t - d, t, x)


def ddt(t: Float, x: Float) -> Float:
    """Return dx/dt (N,) by parabolas through three neighbours; zero where there is only one sample."""
    if len(t) < 2:
        return np.zeros(len(t))
    return np.asarray(np.gradient(x, t, edge_order=2 if len(t) > 2 else 1))


def slow(t: Float, x: Float, f: float) -> Float:
    """Return x (N,) smoothed by a Gaussian that halves the power at `f` Hz, on an uneven clock too.

    Beyond the ends x is continued by its odd reflection. EffectError where f is not positive.
    """
    if not f > 0.0:
        raise EffectError(f"the frequency f is {f!r}", where="slow", remedy="give a positive number of Hz")
    step = (t[-1] - t[0]) / max(len(t) - 1, 1)
    if step <= 0.0:
        return np.array(x, dtype=float)
    even = t[0] + step * np.arange(len(t))
    width = np.sqrt(np.log(2.0)) / (2.0 * np.pi * f) / step
    reach = min(int(np.ceil(4.0 * width)), len(t) - 1)
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    y = np.interp(even, t, x)
    y = np.concatenate([2.0 * y[0] - y[reach:0:-1], y, 2.0 * y[-1] - y[-2 : -reach - 2 : -1]])
    return np.interp(t, even, np.convolve(y, weight / weight.sum(), mode="valid"))


MEMORY: Mapping[str, Callable[..., Float]] = {"play": play, "dahl": dahl, "delay": delay, "slow": slow, "ddt": ddt}
"""Word of the language -> function of (t, x, parameter)."""


def _not_negative(word: str, what: str, value: float) -> None:
    if not value >= 0.0:
        raise EffectError(f"{what} is {value!r}", where=word, remedy="give a number that is not negative")
