"""Torques that were logged by a clock of their own: recordings on one clock, and what is said of the other."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.hypotheses import hypotheses
from exoid.diagnosis.own_numbers.compared import predicts_better
from exoid.diagnosis.own_numbers.numbers import Belonging
from exoid.diagnosis.rules import Rules
from exoid.measurement.recording import Recording
from exoid.optimisation.preparation.clocks import EVERY, GROUPS, on_one_clock
from exoid.symbolic.quantity import Estimate

ROUNDS = 3
"""Times that what is left of a difference is taken out."""
Fitted = Callable[[Sequence[Recording]], FittedModel]


def on_one_clock_all(
    base: FittedModel, recordings: Sequence[Recording], fitted: Fitted, rules: Rules
) -> tuple[FittedModel, Sequence[Recording], tuple[Belonging, ...]]:
    """The model on recordings that were put on one clock, these, and what is told of their clocks; as it was and
    nothing where no clock is another's, or the model predicts no better then.

    `fitted` gives the model as it was given, fitted to other versions of the recordings.
    """
    rates = dict.fromkeys((one.name for one in recordings), 0.0)
    errors = dict(rates)
    now, moved = base, recordings
    for _ in range(ROUNDS):
        found = {name: clock for clock in now.prepared.clocks for name in rates if clock.name in (name, EVERY)}
        if not found:
            break
        for name, clock in found.items():
            rates[name] = 1.0 - (1.0 - rates[name]) * (1.0 - clock.rate)
            errors[name] = errors[name] or clock.error
        moved = [on_one_clock(one, rates[one.name]) if rates[one.name] else one for one in recordings]
        now = fitted(moved)
    if now is base or now.prepared.clocks or not predicts_better(base, now, rules):
        return base, recordings, ()
    values = {name: _estimate(rates[name], errors[name]) for name in rates if rates[name]}
    said = {name: _said(one) for name, one in values.items()}
    sentence = hypotheses()["clock_rate"].said(None, said, "", "")
    apart = max(abs(rates[one.name]) * one.duration for one in recordings)
    return now, moved, (Belonging("clock_rate", None, "1", values, f"{sentence}, up to {1e3 * apart:.2g} ms"),)


def _estimate(rate: float, error: float) -> Estimate:
    from scipy.special import stdtrit

    half = float(stdtrit(GROUPS - 1, 0.975)) * error
    return Estimate("clock_rate", rate, "1", rate - half, rate + half)


def _said(one: Estimate) -> str:
    """ "runs 0.2 % faster", with its interval."""
    low, high = sorted((100.0 * abs(one.low), 100.0 * abs(one.high)))
    way = "faster" if one.value > 0.0 else "slower"
    return f"runs {100.0 * abs(one.value):.2g} % {way} ({low:.2g} to {high:.2g} %)"
