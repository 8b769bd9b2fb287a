"""Torques that were logged by a clock of their own: recordings on one clock, and what is said of the other."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.hypotheses import hypotheses
from exoid.diagnosis.own_numbers.compared import predicts_better
from exoid.diagnosis.own_numbers.numbers import Belonging
from exoid.diagnosis.rules import Rules
from exoid.measurement.recording import Recording
from exoid.optimisation.preparation.clocks import EVERY, GROUPS, late_clocks, on_one_clock, what_is_left
from exoid.symbolic.quantity import Estimate

ROUNDS = 3
"""Times that what is left of a difference is taken out."""
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
    machine, names = base.model.base(), [one.name for one in recordings]
    clocks = late_clocks(machine, base.prepared.all) if late else base.prepared.clocks
    value, error = dict.fromkeys(names, 0.0), dict.fromkeys(names, 0.0)
    now, moved = base, recordings
    for _ in range(ROUNDS if clocks else 0):
        for name, clock in {name: one for one in clocks for name in names if one.name in (name, EVERY)}.items():
            value[name] += clock.late if late else clock.rate
            error[name] = clock.late_error if late else clock.error
        moved = [on_one_clock(one, *((0.0, value[one.name]) if late else (value[one.name],))) for one in recordings]
        now = fitted(moved)
        clocks = late_clocks(machine, now.prepared.all) if late else what_is_left(machine, now.prepared.all, clocks)
    if now is base or now.prepared.clocks or not predicts_better(base, now, rules):
        return None
    told = _told("clock_offset" if late else "clock_rate", {n: (value[n], error[n]) for n in names if value[n]})
    return OneClock(now, moved, (told,))


def _told(what: str, known: Mapping[str, tuple[float, float]]) -> Belonging:
    from scipy.special import stdtrit

    wide, unit = float(stdtrit(GROUPS - 1, 0.975)), "s" if what == "clock_offset" else "1"
    values = {name: Estimate(what, x, unit, x - wide * e, x + wide * e) for name, (x, e) in known.items()}
    factor, shown, ways = (1e3, "ms", ("later", "earlier")) if unit == "s" else (1e2, "%", ("faster", "slower"))
    said = {}
    for name, one in values.items():
        low, high = sorted((factor * abs(one.low), factor * abs(one.high)))
        way = ways[0] if one.value > 0.0 else ways[1]
        said[name] = f"{factor * abs(one.value):.2g} {shown} {way} ({low:.2g} to {high:.2g})"
    return Belonging(what, None, unit, values, hypotheses()[what].said(None, said, "", ""))
