"""A swing at one frequency in every recording, whatever the motion: a base that oscillates, an engine, a fan.

Where its phase differs from recording to recording, no function of motion and common clock can describe it. Whoever
starts a recorder does not ask the stand for its phase. So a sway of the base is weighed with a phase of its own in each
recording: at a given frequency its torque is linear in its sine and cosine parts, which every recording shows alone,
and only the frequency is searched, near the line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate, candidate_columns
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.ties import index_of_greatest, least_of
from exoid.optimisation.fitting.phases import phases_of
from exoid.symbolic.effect_catalogue import find_effect
from exoid.symbolic.motion import Float
from exoid.symbolic.term import Term, places_of

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
ENTRY = "base_motion"
NEAR = 0.25
"""Part of a frequency about it in which that of the sway is searched: swings of the machine itself bend the line that
it leaves."""
MOST_TRIED = 100
"""Frequencies to either side of it at most, for speed: of a long recording the line is sharp."""
AT_ONCE = 32
"""Frequencies whose columns are held in memory at once."""


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
    every, found = last.prepared.all, []
    for j, joint in enumerate(last.model.joint_names):
        left = [np.where(item.used[j], r[j], 0.0) for r, item in zip(last.residuals, every, strict=True)]
        if line := common_line(left, [item.torque[j] for item in every], [item.kept_rate for item in every]):
            found.append(Swing(joint, *line))
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


def sway_nodes(last: FittedModel, noise: Float, rules: Rules = RULES) -> Float | None:
    """Node (R, 1, 2) of the sway about the clearest line of what `last` leaves: a frequency in Hz, and a phase in every
    recording; None for none, or where no more is left than a few times the `noise` (J,) in N·m.
    """
    swing = swinging(last) if np.any(last.evaluation_rms > rules.near_noise * noise) else None
    effect, model = find_effect(ENTRY), last.model
    taken = model.moving_base or any(term.effect.id == ENTRY for term in model.terms)
    if swing is None or taken or not places_of(effect, model.joints):
        return None
    step = 1.0 / (FINE * max(float(item.t[-1] - item.t[0]) for item in last.prepared.all))
    count = min(MOST_TRIED, int(NEAR * swing.hertz / step))
    allowed = effect.shape["f"]
    tried = np.clip(swing.hertz + step * np.arange(-count, count + 1), allowed.min, allowed.max)
    candidate = Candidate(Term(effect, None, model.joints), np.zeros((1, 1, 2)), False)
    evidence, every = last.evidence(seed=0, draws=0, rules=rules), last.prepared.all

    def alone(hertz: Float) -> tuple[Float, Float]:
        """Sine and cosine parts (R, 4, F) of sways that every recording shows alone, and what they take away (F,)."""
        nodes = np.column_stack([hertz, np.zeros(len(hertz))])
        columns = [candidate_columns(candidate, nodes, item, last) for item in every]
        parts, _, gain = evidence.alone.candidate(evidence.plain(columns))
        return parts, gain.sum(axis=0)

    gains = np.concatenate([alone(some)[1] for some in np.array_split(tried, len(tried) // AT_ONCE + 1)])
    hertz = tried[[index_of_greatest(gains)]]
    return np.column_stack([np.repeat(hertz, len(every)), phases_of(alone(hertz)[0][:, :, 0])])[:, None]
