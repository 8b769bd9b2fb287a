"""Torques that were logged by a clock of their own: recordings on one clock, and what is said of the other."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.hypotheses import Claim, nothing, sentence_on
from exoid.diagnosis.own_numbers.compared import predicts_better, total
from exoid.diagnosis.own_numbers.numbers import Belonging
from exoid.diagnosis.rules import Rules
from exoid.measurement.finding import EVERY
from exoid.measurement.recording import Recording
from exoid.optimisation.preparation.clocks import GROUPS, late_clocks, on_one_clock
from exoid.symbolic.quantity import Estimate

WIDTHS = (0.3, 0.1, 0.03)
"""Parts of a difference, known to first order, by which it is varied to find the one that predicts best."""
Fitted = Callable[[Sequence[Recording]], FittedModel]


@dataclass(frozen=True, eq=False)
class OneClock:
    """A model on `recordings` that were put on one clock, fitted to them anew, and what is `told` of their clocks."""

    fitted: FittedModel
    recordings: Sequence[Recording]
    told: tuple[Belonging, ...]


def one_clock(base: FittedModel, recordings: Sequence[Recording], fitted: Fitted, rules: Rules) -> OneClock | None:
    """Recordings on one clock; None where no clock is another's, or the model predicts no better then.

    `fitted` gives the model as it was given, fitted to other versions of the recordings. Clocks that run at another
    rate are looked for first; where none does, single recordings whose torques come later or earlier than those of the
    others.
    """
    late = not base.prepared.clocks
    if late and (base.prepared.misread or len(recordings) < 2):
        return None
    names = [recording.name for recording in recordings]
    clocks = late_clocks(base.prepared.clock_rates) if late else base.prepared.clocks
    known = {name: clock for clock in clocks for name in names if clock.name in (name, EVERY)}
    if not known:
        return None
    first = {name: (item.late, item.late_error) if late else (item.rate, item.error) for name, item in known.items()}

    def moved(factor: float) -> list[Recording]:
        """Recordings by clocks that are so many times as far apart as was found to first order."""
        apart = {name: {"late" if late else "rate": factor * value} for name, (value, _) in first.items()}
        return [on_one_clock(entry, **apart[entry.name]) if entry.name in apart else entry for entry in recordings]

    factor = 1.0
    for width in WIDTHS:
        tried = (factor - width, factor, factor + width)
        low, middle, high = (total(fitted(moved(element)).recording_losses(base.scale, rules)) for element in tried)
        bend = low - 2.0 * middle + high
        factor += float(np.clip(0.5 * width * (low - high) / bend, -width, width)) if bend > 0.0 else 0.0
    on_one = moved(factor)
    now = fitted(on_one)
    if now.prepared.clocks or not predicts_better(base, now, rules):
        return None
    told = _told(
        "clock_offset" if late else "clock_rate",
        {name: (factor * value, error) for name, (value, error) in first.items()},
    )
    return OneClock(now, on_one, (told,))


def _told(what: str, known: Mapping[str, tuple[float, float]]) -> Belonging:
    from scipy.special import stdtrit

    wide, unit = float(stdtrit(GROUPS - 1, 0.975)), "s" if what == "clock_offset" else "1"
    values = {name: Estimate(what, x, unit, x - wide * e, x + wide * e) for name, (x, e) in known.items()}
    factor, shown, ways = (1e3, "ms", ("later", "earlier")) if unit == "s" else (1e2, "%", ("faster", "slower"))
    said = {}
    for name, item in values.items():
        low, high = sorted((factor * abs(item.low), factor * abs(item.high)))
        way = ways[0] if item.value > 0.0 else ways[1]
        said[name] = f"{factor * abs(item.value):.2g} {shown} {way} ({low:.2g} to {high:.2g})"
    claim = Claim(what, None, unit, nothing, (-np.inf, np.inf))
    return Belonging(what, None, unit, values, sentence_on(claim, said))
