"""Objections to a term after the refit, however much it gains: its parameters, and what it leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from exoid.diagnosis.evidence.enough_motion import little_motion
from exoid.diagnosis.evidence.fitted import FittedModel, lag
from exoid.diagnosis.evidence.model_error import repeats, sensor_noise
from exoid.diagnosis.hypotheses.readings import is_reading, reading_objection
from exoid.diagnosis.rules import Rules
from exoid.diagnosis.search.state import Extension
from exoid.ground.ties import index_of_greatest, least_of
from exoid.measurement.signals.masks import widen
from exoid.optimisation.fitting.shapes import to_unit
from exoid.symbolic.language.torque import is_transform
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate

BESIDE = 0.05
"""Seconds beside samples that are left out, since a joint may stick there, in which slow friction still shows."""
DELAY = "time_delay"
"""The entry that has torque come at another moment."""


@dataclass(frozen=True)
class Objection:
    """Reason why a term must not be accepted, in words; `early`: because its torque would come before its motion."""

    reason: str
    early: bool = False


def doubt(before: Extension, after: Extension, floor: Float, rules: Rules) -> Objection | None:
    """Reason why the term that `after` adds must not be accepted; None where nothing speaks against it.

    `floor` (J,) is the noise in N·m, of the sensors or of what does not repeat.
    """
    name = after.score.name
    reason = (
        too_little_motion(before, after, rules)
        or on_bound(after.fitted, name, rules)
        or undetermined(after.fitted, name)
        or made_by_the_filter(before, after, rules)
        or explains_noise(before, after, rules)
        or explains_nothing(before, after, rules)
        or reading_objection(after.fitted.fit, name, before.explained(after, rules), rules)
        or beside_standstill(before, after, rules)
        or less_than_chance(before, after, rules)
    )
    early = "" if reason else torque_before_motion(before, after, floor, rules)
    return Objection(reason or early, early=bool(early)) if reason or early else None


def too_little_motion(before: Extension, after: Extension, rules: Rules) -> str:
    """Objection to anything but a reading that explains nearly all, where fitted motion is too little; "" for none."""
    if is_reading(after.score.name) and before.explained(after, rules) >= rules.most:
        return ""
    return little_motion(after.fitted.prepared, rules, after.score.candidate.joints)


def refuted(extensions: Sequence[Extension], rules: Rules) -> tuple[str, Objection] | None:
    """The term that explains least of those to which the numbers of the last model object, and the objection; None
    where they object to none. What came later, or other spikes, may have taken its place: it then explains nothing,
    and each of its coefficients may be zero, its shape not known either.
    """
    last, found = extensions[-1].fitted, []
    for before, after in pairwise(extensions):
        name, share = after.score.name, before.explained(after, rules)
        reason = on_bound(last, name, rules) or undetermined(last, name)
        own = [] if reason or share > 0.0 else _coefficients(last, name)
        if own and all(map(_around_zero, own)):
            reason = "it explains nothing, and its numbers may be nothing"
        if reason:
            found.append((share, name, Objection(f"in the last fit, {reason}")))
    return least_of(found, lambda item: item[0], 1.0)[1:] if found else None


def on_bound(fitted: FittedModel, name: str, rules: Rules) -> str:
    """Parameter of the term `name` that sits on a bound, and what that would mean, in words; "" where none does."""
    for entry, value in zip(fitted.model.shapes, fitted.shape, strict=True):
        shape = entry.shape
        if entry.term != name or shape.choices or shape.per_recording:
            continue
        unit = to_unit(shape, float(value))
        if min(1.0 if shape.sharp else unit, 1.0 - unit) < rules.negligible:
            side, limit = ("lowest", shape.min) if unit < 0.5 else ("highest", shape.max)
            return (
                f"{entry.name} = {value:.3g} {shape.unit} is the {side} value this effect can have ({limit:g}): "
                "these data cannot distinguish it from something slower, wider or stronger, so it is not this effect"
            )
    for k, entry in enumerate(fitted.model.shapes):
        if entry.term != name or not entry.shape.is_own:
            continue
        own = [to_unit(entry.shape, float(value)) for value in fitted.shapes[:, k]]
        if all(min(unit, 1.0 - unit) < rules.negligible for unit in own):
            return f"{entry.name} is at a limit of what this effect can be in every recording"
    for parameter, value in zip(fitted.model.parameters, fitted.linear, strict=True):
        if parameter.term != name:
            continue
        low = parameter.min is not None and value <= parameter.min
        high = parameter.max is not None and value >= parameter.max
        if low or high:
            return f"{parameter.name} = {value:.3g} {parameter.unit} is at a limit of what this effect can be"
    return ""


def undetermined(fitted: FittedModel, name: str) -> str:
    """Return that the interval of every coefficient of the term `name` contains zero: the data do not show it.

    Intervals are those at the shape found, since without the torque there is no shape: of a peak of which only the
    flank shows neither height nor width is known, and it is there all the same. Of a term without coefficients it is
    the interval of its first number, where zero is one of its values.
    """
    found = _coefficients(fitted, name)
    if not found:
        first = next((s for s in fitted.model.shapes if s.term == name), None)
        wanted = first.name if first is not None and first.shape.min <= 0.0 <= first.shape.max else None
        found = [e for e in fitted.fit.estimates if e.name == wanted]
    if not found or not all(_around_zero(e, _at_its_shape(fitted, name, e.name)) for e in found):
        return ""
    text = ", ".join(f"{e.name} = {e.value:.3g} [{e.low:.3g}, {e.high:.3g}] {e.unit}".rstrip() for e in found)
    return f"{text}: the interval contains zero"


def known_with_shape(fitted: FittedModel, name: str) -> frozenset[str]:
    """Names in full of the coefficients of the term `name` that are known only together with its shape: beside one that
    is known their intervals would not contain zero.
    """
    found = (e for e in _coefficients(fitted, name) if np.isfinite([e.low, e.high]).all() and _around_zero(e))
    return frozenset(e.name for e in found if not _around_zero(e, _at_its_shape(fitted, name, e.name)))


def _coefficients(fitted: FittedModel, name: str) -> list[Estimate]:
    """Estimates of the coefficients of the term `name`, in the order of the model."""
    known = {e.name: e for e in fitted.fit.estimates}
    return [known[p.name] for p in fitted.model.parameters if p.term == name]


def _around_zero(one: Estimate, narrower: float = 1.0) -> bool:
    """True if an interval contains zero, or is not known, also where it is `narrower` times as wide."""
    low, high = (one.value + narrower * (end - one.value) for end in (one.low, one.high))
    return bool(not np.isfinite([low, high]).all() or low <= 0.0 <= high)


def _at_its_shape(fitted: FittedModel, name: str, coefficient: str) -> float:
    """Return the standard error of a coefficient of the term `name` at known shape values, of that at unknown ones."""
    model, spread = fitted.model, fitted.fit.covariance
    names = [*(p.name for p in model.parameters), *(s.name for s in model.shapes)]
    own, count = names.index(coefficient), len(model.parameters)
    shapes = [count + i for i, s in enumerate(model.shapes) if s.term == name and count + i != own]
    shapes = [k for k in shapes if 0.0 < spread[k, k] < np.inf]
    if not shapes or not 0.0 < spread[own, own] < np.inf:
        return 1.0
    across = spread[own, shapes]
    taken = across @ np.linalg.pinv(spread[np.ix_(shapes, shapes)]) @ across / spread[own, own]
    return float(np.sqrt(np.clip(1.0 - taken, 0.0, 1.0)))


def made_by_the_filter(before: Extension, after: Extension, rules: Rules) -> str:
    """Return that the term takes no more off the unseen error than filter and derivatives get wrong by themselves.

    What they get wrong looks like a drive that is flexible or late, where a heavy slide moves fast.
    """
    wrong = after.fitted.prepared.filter_error
    taken = np.sqrt(np.maximum(before.fitted.evaluation_rms**2 - after.fitted.evaluation_rms**2, 0.0))
    if after.score.repeats(rules):  # whichever recordings are held out
        taken = np.maximum(taken, np.sqrt(np.maximum(before.fitted.train_rms**2 - after.fitted.train_rms**2, 0.0)))
    if np.any(taken > rules.artefact * wrong) or not np.any(wrong > 0.0):
        return ""
    j = index_of_greatest(taken / np.maximum(wrong, 1e-300))
    joint = after.fitted.model.joints[j]
    return (
        f"takes {taken[j]:.2g} {joint.unit('tau')} off the error of the {joint.name}, where filter and derivatives "
        f"alone get {wrong[j]:.2g} {joint.unit('tau')} wrong"
    )


def explains_noise(before: Extension, after: Extension, rules: Rules) -> str:
    """Objection to a term that takes an error from near the noise floor to far below it, at every joint where it falls:
    no model of the machine can, but one that follows errors of the angles may, as where an encoder has coarse steps.
    """
    floor, joints, tell = after.fitted.prepared.noise_floor, after.fitted.model.joints, rules.worth_telling
    seen = before.fitted.evaluation_rms, after.fitted.evaluation_rms
    fitted = before.fitted.train_rms, after.fitted.train_rms
    below = [(then < (1.0 - tell) * floor) & (floor - then > once - floor) for once, then in (seen, fitted)]
    falls = np.flatnonzero(seen[1] < (1.0 - tell) * seen[0])
    if not falls.size or not np.all(np.logical_and(*below)[falls]):
        return ""
    j = int(falls[0])
    unit = joints[j].unit("tau")
    return (
        f"takes the error of the {joints[j].name} from {seen[0][j]:.2g} to {seen[1][j]:.2g} {unit}, further below the "
        f"noise floor of {floor[j]:.2g} {unit} than it was above: what it follows is noise"
    )


def explains_nothing(before: Extension, after: Extension, rules: Rules) -> str:
    """Return that the squared error of motion it was not fitted to does not fall at the joints where the effect shows.

    A wrong length may hide in the numbers that were fitted with it and leave next to no error: it is no effect.
    """
    share = before.explained(after, rules)
    if share >= rules.least_share or is_reading(after.score.name):
        return ""
    return f"explains {100 * share:.1g} % of the squared error at its own joints, on motion it was not fitted to"


def beside_standstill(before: Extension, after: Extension, rules: Rules) -> str:
    """Return that a term which follows the model's own torque gains little, and nothing clear as blocks scatter, but
    where its joint has just stood still, or is about to.

    An elastic or late torque shows wherever torque varies, friction at low speed there.
    """
    if not is_transform(after.score.candidate.term):
        return ""
    everywhere, blocks = 0.0, []
    recordings = after.fitted.prepared.all
    for j in after.score.candidate.term.reaches:
        for recording, old, new in zip(recordings, before.fitted.residuals, after.fitted.residuals, strict=True):
            gained = np.where(recording.used[j], old[j] ** 2 - new[j] ** 2, 0.0)
            far = ~widen(recording.stuck[:, j], int(np.ceil(BESIDE * recording.rate)))[recording.kept]
            everywhere += float(gained.sum())
            blocks.append(np.add.reduceat(np.where(far, gained, 0.0), recording.starts(rules.block_seconds)))
    beyond = np.concatenate(blocks)
    if beyond.sum() > rules.little * everywhere or lag(beyond, np.zeros(1)) >= rules.clear:
        return ""
    return (
        f"explains nothing clear further than {BESIDE:g} s from where the joint stands still: friction at low speed, "
        "or its direction, may be what is missing, and this only takes up part of it"
    )


def less_than_chance(before: Extension, after: Extension, rules: Rules) -> str:
    """Return that the term explains less, at each of its joints, than is left there and does not come again when the
    motion does, where that is no noise of the sensors.

    A person who pushes slowly is alike to any effect for a while, and to shifts in time of it less so; but not in
    nearly all splits of many recordings.
    """
    if after.score.agrees(rules) or (again := repeats(after.fitted)) is None:
        return ""
    at, noise = list(after.score.candidate.joints), sensor_noise(after.fitted.prepared)
    taken = np.sqrt(np.maximum(before.fitted.evaluation_rms**2 - after.fitted.evaluation_rms**2, 0.0))
    if np.any(again.noise[at] <= np.maximum(rules.near_noise * noise, taken)[at]):
        return ""
    joint = after.fitted.model.joints[at[0]]
    return (
        f"takes {taken[at[0]]:.2g} {joint.unit('tau')} off the error of the {joint.name}, where "
        f"{again.noise[at[0]]:.2g} {joint.unit('tau')} do not come again {again.what}: what acts from outside the "
        "model is larger, and resembles any effect for a while"
    )


def torque_before_motion(before: Extension, after: Extension, floor: Float, rules: Rules) -> str:
    """Return that the term has torque come before its motion, yet leaves much of what is more than noise, `floor` (J,).

    Loggers, buses and filters make torque late; early it hardly is, but what swings behind its drive looks so.
    """
    term = after.score.candidate.term
    if term.effect.id != DELAY:
        return ""
    own = [k for k, entry in enumerate(after.fitted.model.shapes) if entry.term == term.name]
    early = -float(np.median(after.fitted.fit.shapes[:, own]))
    at = list(term.reaches)
    whole, left = (
        float(np.sum(np.maximum(item.fitted.evaluation_rms[at] ** 2 - floor[at] ** 2, 0.0))) for item in (before, after)
    )
    if early <= 0.0 or left <= (1.0 - rules.half) * whole:
        return ""
    return (
        f"the torque would come {early:.2g} s before the motion it belongs to, which hardly happens, and that explains "
        f"{100 * max(0.0, 1.0 - left / whole):.0f} % of what is more than noise"
    )
