"""Velocities and accelerations from angles, in three ways that can be exchanged for each other.

    butterworth   zero-phase low-pass, then central differences (what is used unless asked otherwise)
    savgol        a cubic fitted to a short window around each sample (Savitzky, Golay, Analytical Chemistry 36, 1964)
    fourier       for motion that repeats: one Fourier series for all periods, differentiated exactly; what differs from
                  period to period is noise, and is averaged away (Swevers and others, IEEE Transactions on Robotics and
                  Automation 13(5), 730-740, 1997)

All take a band in Hz. The torque is not touched here: model and measurement go through one common filter afterwards.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.ground.minimum import minimum
from exoid.measurement.signals.conditioning import UniformSignals, noise_density
from exoid.measurement.signals.methods import BUTTERWORTH, FOURIER, SAVGOL
from exoid.symbolic.motion import Float

ORDER = 3
"""Of the polynomial of Savitzky and Golay."""
ALIKE = 0.98
"""Resemblance (1: the same) of the angles to themselves one period later, from which on a motion is taken to repeat."""
SHORTEST_PERIOD = 1.0
"""s; anything faster is a vibration."""
UNLIKE, SMALL = 3.0, 1e-3
"""The angles may differ from one Fourier series for all periods by so many times the encoders' noise, or by this part
of their own standard deviation if that is more."""
SEEN = 4.0
"""Standard deviations of noise by which the amplitude of a harmonic must stand out; beyond the highest that does, a
series would only follow noise."""

Smoothed = tuple[Float, Float, Float, float]
"""Angle, velocity, acceleration (N, J), and how many periods were averaged (1 where none were)."""


def savgol(even: UniformSignals, band: float, where: str) -> Smoothed:
    """Return the angles smoothed by local cubics that halve the power near `band` Hz (Schafer 2011), and slopes."""
    from scipy.signal import savgol_filter

    half = max(ORDER, round(((ORDER + 1) / min(band / (0.5 * even.rate), 0.9) + 4.6) / 3.2))
    window = 2 * half + 1
    if window > len(even.q):
        what = f"the window of {window / even.rate:.2f} s is longer than the recording"
        raise RecordingError(what, where=where, remedy="use a faster cut-off or the butterworth derivative")
    q, dq, ddq = (
        savgol_filter(even.q, window, ORDER, deriv=order, delta=1.0 / even.rate, axis=0, mode="interp")
        for order in range(3)
    )
    return q, dq, ddq, 1.0


def fourier(even: UniformSignals, band: float, where: str) -> Smoothed:
    """Return one Fourier series up to `band` Hz fitted to all periods, and its derivatives.

    RecordingError where the motion does not repeat, or not as closely as the encoders' noise allows.
    """
    period = find_period(even)
    if period is None:
        what = "the motion does not repeat, so there are no periods to average"
        remedy = "use the butterworth derivative, or record at least two periods of a Fourier trajectory"
        raise RecordingError(what, where=where, remedy=remedy)
    harmonics = max(1, int(band * period))
    good = ~even.gap
    basis = _basis(even.t - even.t[0], period, harmonics)[0]
    weights = np.linalg.lstsq(basis[good], even.q[good], rcond=None)[0]
    deviation = np.sqrt(noise_density(even) * (even.rate / float(good.sum())))
    harmonics = _highest(np.asarray(weights, dtype=float), harmonics, np.asarray(deviation, dtype=float))
    basis = _basis(even.t - even.t[0], period, harmonics)[0]
    weights = np.linalg.lstsq(basis[good], even.q[good], rcond=None)[0]
    rest = even.q[good] - basis[good] @ weights
    # Noise is judged in its own band; slow differences between periods are what matters here.
    slow = _averaged(rest, max(1, int(even.rate / (2.0 * band))))
    wanted = np.sqrt(noise_density(even) * band)
    if np.any(slow > np.maximum(UNLIKE * wanted, SMALL * even.q.std(axis=0))):
        raise RecordingError(
            f"the motion repeats every {period:.4g} s, but periods differ by {slow.max():.2g} rad, "
            f"more than the encoders' noise of {wanted.max():.2g} rad",
            where=where,
            remedy="use the butterworth derivative: averaging would take real motion away",
        )
    series = [b @ weights for b in _basis(even.t - even.t[0], period, harmonics, 2)]
    return series[0], series[1], series[2], max(1.0, (even.t[-1] - even.t[0]) / period)


def find_period(even: UniformSignals) -> float | None:
    """Return the period in s after which both joints are where they were; None where there are not two of them."""
    step = max(1, int(even.rate // 50))
    q = even.q[::step] - even.q.mean(axis=0)
    rate = even.rate / step
    count = len(q)
    product = np.fft.irfft(np.abs(np.fft.rfft(q, 2 * count, axis=0)) ** 2, axis=0)[:count]
    power = np.cumsum(q**2, axis=0)
    # Both stretches that a lag compares, the one that starts at the beginning and the one that ends at the end.
    both = power[::-1] + (power[-1] - np.vstack([np.zeros((1, q.shape[1])), power[:-1]]))
    # A joint that is held still shows only noise, which never repeats; the others decide.
    moves = np.ptp(q, axis=0) > 0.1 * np.ptp(q, axis=0).max()
    alike = (2.0 * product / np.maximum(both, 1e-300))[:, moves].min(axis=1)
    lags = np.arange(int(SHORTEST_PERIOD * rate), count // 2 + 1)
    if lags.size < 3:
        return None
    inside = lags[1:-1]
    peak = (alike[inside] >= alike[inside - 1]) & (alike[inside] >= alike[inside + 1]) & (alike[inside] >= ALIKE)
    if not peak.any():
        return None
    first = float(inside[peak][0]) / rate
    t = even.t[::step] - even.t[0]

    def miss(period: float) -> float:
        basis = _basis(t, period, max(1, min(40, int(0.25 * rate * period))))[0]
        rest = q - basis @ np.linalg.lstsq(basis, q, rcond=None)[0]
        return float(np.sum(rest**2))

    return minimum(miss, first - 1.5 / rate, first + 1.5 / rate, 1e-6)[0]


def _highest(weights: Float, harmonics: int, deviation: Float) -> int:
    """Return the highest harmonic (at least one) whose amplitude stands out from noise of `deviation` (J,)."""
    size = np.abs(weights[1:]).reshape(2, harmonics, -1).max(axis=0)
    seen = np.flatnonzero((size > SEEN * deviation).any(axis=1))
    return int(seen[-1]) + 1 if seen.size else 1


def _basis(t: Float, period: float, harmonics: int, order: int = 0) -> list[Float]:
    """Return the columns (N, 2H + 1) of a Fourier series and of its derivatives up to `order`."""
    rate = 2.0 * np.pi / period * np.arange(1, harmonics + 1)
    phase = np.outer(t, rate)
    sine, cosine = np.sin(phase), np.cos(phase)
    ones, none = np.ones((len(t), 1)), np.zeros((len(t), 1))
    out = [np.hstack([ones, sine, cosine])]
    if order >= 1:
        out.append(np.hstack([none, rate * cosine, -rate * sine]))
    if order >= 2:
        out.append(np.hstack([none, -(rate**2) * sine, -(rate**2) * cosine]))
    return out


def _averaged(rest: Float, width: int) -> Float:
    """Return the RMS (J,) of `rest` (N, J) after means over `width` samples."""
    count = len(rest) // width
    if count == 0:
        return np.asarray(np.sqrt(np.mean(rest**2, axis=0)))
    blocks = rest[: count * width].reshape(count, width, -1).mean(axis=1)
    return np.asarray(np.sqrt(np.mean(blocks**2, axis=0)))


METHODS: Mapping[str, Callable[[UniformSignals, float, str], Smoothed] | None] = MappingProxyType(
    {BUTTERWORTH: None, SAVGOL: savgol, FOURIER: fourier}
)
"""What --derivative may name; None: low-pass and central differences, as `prepare` does them."""


def check_method(name: str) -> str:
    """Return `name`; RecordingError where there is no such derivative."""
    if name not in METHODS:
        raise RecordingError(f"there is no derivative called {name!r}", remedy=f"use {', '.join(METHODS)}")
    return name
