"""A swing at one frequency in every recording, whatever the motion: a base that oscillates, an engine, a fan.

Where its phase differs from recording to recording, no function of motion and common clock can describe it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.ground.ties import index_of_greatest, least_of
from exoid.symbolic.motion import Float

SLOWEST = 0.3
"""Hz; below, drifts and the motion itself."""
LOBE = 2.0
"""Half the width of a line behind a Hann window, in reciprocal durations."""
FINE = 4
"""Frequencies per reciprocal duration."""
LEAST, MOST = 0.25, 0.05
"""Share of the power that is left in one line in every recording, at least, and of the torque's own there, at most."""
SHORTEST = 8.0
"""Periods that the shortest recording must hold."""


@dataclass(frozen=True)
class Swing:
    """A line at `hertz` in what is left at `joint`: its least `share` of the power in any recording."""

    joint: str
    hertz: float
    share: float

    @property
    def sentence(self) -> str:
        """The swing in words: its share, joint and frequency."""
        return (
            f"at least {100 * self.share:.0f} % of what is left at the {self.joint} swings at {self.hertz:.2g} Hz in "
            "every recording, whatever the motion: does the base oscillate, each time with another phase?"
        )

    @property
    def advice(self) -> str:
        """Advice to the person who measures."""
        return (
            f"clamp the base, or find what moves at {self.hertz:.2g} Hz; if it cannot be stopped, "
            "measure the motion of the base; base_motion describes a sway of the same size in every recording"
        )


def swinging(last: FittedModel) -> Swing | None:
    """Return the clearest line that all recordings have in what `last` leaves; None where there is none."""
    found = [
        Swing(joint, *line)
        for j, joint in enumerate(last.model.joint_names)
        if (
            line := common_line(
                [np.where(item.used[j], r[j], 0.0) for r, item in zip(last.residuals, last.prepared.all, strict=True)],
                [entry.torque[j] for entry in last.prepared.all],
                [element.kept_rate for element in last.prepared.all],
            )
        )
    ]
    return least_of(found, lambda one: -one.share, 1.0) if found else None


def common_line(left: Sequence[Float], torque: Sequence[Float], rates: Sequence[float]) -> tuple[float, float] | None:
    """Return frequency (Hz) and least share of the line that all of `left` have and their `torque` has not."""
    if len(left) < 2:
        return None
    lasts = [len(x) / rate for x, rate in zip(left, rates, strict=True)]
    step, first = 1.0 / (FINE * max(lasts)), max(SLOWEST, SHORTEST / min(lasts))
    top = 0.4 * min(rates)
    if top <= first:
        return None
    grid = np.arange(first, top, step)
    rest, own = (
        np.array([_shares(x, rate, step, grid) for x, rate in zip(some, rates, strict=True)]) for some in (left, torque)
    )
    least = np.where(own.max(axis=0) < MOST, rest.min(axis=0), 0.0)
    best = index_of_greatest(least, 1.0)
    return (float(grid[best]), float(least[best])) if least[best] >= LEAST else None


def _shares(x: Float, rate: float, step: float, grid: Float) -> Float:
    """Return for each frequency of `grid` (Hz) the share of the power of `x` in a line there."""
    count = round(rate / step)
    power = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x)), count)) ** 2
    upto = np.concatenate([[0.0], np.cumsum(power)])
    half = LOBE * rate / len(x)
    places = np.arange(len(power)) * rate / count
    low, high = np.searchsorted(places, grid - half), np.searchsorted(places, grid + half, side="right")
    return np.asarray((upto[high] - upto[low]) / max(upto[-1], 1e-300))
