"""Recordings that are not of what the others are of: a torque that was stuck, another machine or load, other columns.

A model fitted to the others explains each of them, and of the odd one leaves a large part of the torque, several times
what it leaves of any other. An effect that the model lacks is in all recordings, more or less, and raises what is left
of each. The oddest are taken away one after the other, as many as all stand out together: one bad file spoils
a fit to all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.errors import NotEnoughDataError
from exoid.ground.plain import AsJson
from exoid.ground.ties import index_of_least
from exoid.measurement.finding import Finding
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.symbolic.motion import Float

OTHERS = 3
"""Recordings that must agree with each other, at least."""
MOST = 1 / 3
"""Part of the recordings that may be apart: beyond, nobody knows which of them are right."""


@dataclass(frozen=True)
class Apart(AsJson):
    """A recording that was left out of an answer, and why in words."""

    recording: str
    sentence: str


def apart(base: FittedModel, rules: Rules = RULES) -> tuple[int, ...]:
    """Indices of the recordings, fitted ones first, that are apart from the others; () where none or too many are."""
    grams = _Grams(base)
    count = len(base.prepared.all)
    out: list[int] = []
    plain: tuple[int, ...] = ()
    while len(out) + 1 <= MOST * count and count - len(out) - 1 >= OTHERS:
        rest = [k for k in range(count) if k not in out]
        without = [grams.errors([j for j in rest if j != k], [j for j in rest if j != k]) for k in rest]
        worst = rest[index_of_least([float(np.nansum(item)) for item in without])]
        out.append(worst)
        rest.remove(worst)
        left = grams.errors(rest, [*rest, *out])
        if all(_plain(own, np.nan_to_num(left[: len(rest)]).max(axis=0), rules).any() for own in left[len(rest) :]):
            plain = tuple(sorted(out))
    return plain


def still_apart(base: FittedModel, found: Fit, odd: Sequence[int], rules: Rules = RULES) -> tuple[int, ...]:
    """Those of the recordings `odd` (indices) that the model found for the others does not explain either."""
    left = _left_by(base, found, odd)
    others = np.nan_to_num(left[: -len(odd)]).max(axis=0)
    return tuple(k for k, own in zip(odd, left[-len(odd) :], strict=True) if _plain(own, others, rules).any())


def why_apart(base: FittedModel, found: Fit, odd: Sequence[int], rules: Rules = RULES) -> tuple[Apart, ...]:
    """Reasons to leave out the recordings `odd`, which the model found for the others does not explain, one each."""
    left, power = _left_by(base, found, odd), _power(base)
    others = np.nan_to_num(left[: -len(odd)]).max(axis=0)
    out = []
    for k, own in zip(odd, left[-len(odd) :], strict=True):
        plain = _plain(own, others, rules)
        errors = ", ".join(
            f"{np.sqrt(own[j] * power[j]):.3g} {joint.unit('tau')} at the {joint.name} "
            f"({np.sqrt(own[j] / max(others[j], 1e-12)):.2g} times as much as of any other)"
            for j, joint in enumerate(base.model.joints)
            if plain[j]
        )
        out.append(_why(base, found, base.prepared.all[k], own, errors, rules))
    return tuple(out)


def _why(
    base: FittedModel, found: Fit, one: PreparedRecording, shares: Float, errors: str, rules: Rules
) -> Apart:
    text = f"{one.name} is left out: what explains the others leaves {errors}"
    read = next((f for f in base.prepared.misread if _is_of(f, one.name)), None)
    if read is not None:
        return Apart(one.name, f"{text}; {read.what} ({read.remedy})")
    own = _alone(base, found, one)
    if own is None:
        return Apart(one.name, text)
    alone, left = own
    if left > rules.little * np.nansum(shares):
        return Apart(one.name, f"{text}, and fitted alone it is not explained either: look at its columns and sensors")
    moved = ", ".join(moved_numbers(found, alone)[:4])
    numbers = f" ({moved})" if moved else ""
    text += f", and fitted alone it is explained, with numbers of its own{numbers}"
    return Apart(one.name, f"{text}: another machine, a load (--payload) or gain of a sensor")


def explained_alone(base: FittedModel, found: Fit, odd: Sequence[int]) -> float:
    """Share that numbers of their own explain of what a model found for the others leaves of the recordings `odd`, of
    the one of which that is least.
    """
    left = [float(np.nansum(item)) for item in _left_by(base, found, odd)[-len(odd) :]]
    own = [_alone(base, found, base.prepared.all[k]) for k in odd]
    return min(0.0 if entry is None else 1.0 - entry[1] / whole for entry, whole in zip(own, left, strict=True))


def _alone(base: FittedModel, found: Fit, one: PreparedRecording) -> tuple[Fit, float] | None:
    """Return a fit of the model found to one recording alone, and what it leaves of its torques, in parts of their
    usual variance, all joints together; None where one is not enough.
    """
    try:
        alone = identify(found.model, (one,), optimisers=())
    except NotEnoughDataError:
        return None
    fitted = fitted_model(alone, replace(base.prepared, train=(one,), verify=()))
    return alone, float(np.nansum(_shares(fitted)[0]))


def moved_numbers(first: Fit, second: Fit) -> list[str]:
    """Return the numbers of two fits that differ by more than both intervals allow, in words."""
    own = {e.name: e for e in second.estimates}
    return [
        f"{e.name} {e.value:.3g} and {own[e.name].value:.3g} {e.unit}".rstrip()
        for e in first.estimates
        if e.name in own and (e.high < own[e.name].low or own[e.name].high < e.low)
    ]


def _left_by(base: FittedModel, found: Fit, odd: Sequence[int]) -> Float:
    """Shares (R, J) of the torques that a model found without the recordings `odd` leaves of the others, and of these,
    which come last.
    """
    count, every = len(base.prepared.train), base.prepared.all
    train, held = ([every[k] for k in part if k not in odd] for part in (range(count), range(count, len(every))))
    return _shares(
        fitted_model(found, replace(base.prepared, train=tuple(train), verify=(*held, *(every[k] for k in odd))))
    )


def _is_of(finding: Finding, name: str) -> bool:
    return finding.where == name or finding.where.endswith((f"/{name}", f"/{name}.csv"))


def _plain(own: Float, others: Float, rules: Rules) -> NDArray[np.bool_]:
    """Return at which joints (J,) far more is left of one recording, `own`, than of any other, `others`."""
    known = np.nan_to_num(own)
    return np.asarray((known > rules.worth_telling) & (known > rules.near_noise**2 * others))


def _power(base: FittedModel) -> Float:
    """Return the variance (J,) of the torque of each joint, the median of the recordings; NaN for one without drive."""
    rows = [
        [tau[use].var() if driven and use.any() else np.nan for tau, use, driven in zip(*parts, strict=True)]
        for parts in ((item.torque, item.used, item.driven) for item in base.prepared.all)
    ]
    known = np.array(rows)
    known[~(known > 0.0)] = np.nan
    out = [float(np.nanmedian(row)) if np.isfinite(row).any() else np.nan for row in known.T]
    return np.array(out)


def _shares(fitted: FittedModel) -> Float:
    """Return the share (R, J) of the usual variance of a torque that is left of each recording."""
    power = _power(fitted)
    out = np.full((len(fitted.prepared.all), len(power)), np.nan)
    for k, (item, residual) in enumerate(zip(fitted.prepared.all, fitted.residuals, strict=True)):
        for j in range(len(power)):
            if item.driven[j] and item.used[j].any():
                out[k, j] = np.mean(residual[j, item.used[j]] ** 2) / power[j]
    return out


class _Grams:
    """Sums over each recording and joint, from which a fit to any of the recordings and what it leaves follow."""

    def __init__(self, base: FittedModel) -> None:
        power, model = _power(base), base.model
        self.gram, self.slope, self.square, self.count = [], [], [], []
        for item, shape in zip(base.prepared.all, base.shapes, strict=True):
            raw = model.columns(item.motion, shape, base.linear if model.needs_reference else None)
            columns = item.smooth_columns(raw)
            known = (item.used & item.driven[:, None]) / np.sqrt(power)[:, None]
            known = np.nan_to_num(known)
            rows, tau = columns * known[:, :, None], item.torque * known
            self.gram.append(rows.swapaxes(1, 2) @ rows)
            self.slope.append((rows.swapaxes(1, 2) @ tau[:, :, None])[:, :, 0])
            self.square.append(np.sum(tau**2, axis=1))
            self.count.append(np.count_nonzero(known, axis=1))

    def errors(self, fitted: Sequence[int], asked: Sequence[int]) -> Float:
        """Return the share (A, J) of the torques' variance that a fit to some recordings leaves of those `asked`."""
        gram = sum(self.gram[k].sum(axis=0) for k in fitted)
        slope = sum(self.slope[k].sum(axis=0) for k in fitted)
        size = np.sqrt(np.maximum(np.diagonal(gram), 1e-300))
        x = np.linalg.lstsq(gram / np.outer(size, size), slope / size, rcond=1e-10)[0] / size
        out = []
        for k in asked:
            left = self.square[k] - 2.0 * self.slope[k] @ x + np.einsum("p,jpq,q->j", x, self.gram[k], x)
            out.append(np.where(self.count[k] > 0, np.maximum(left, 0.0) / np.maximum(self.count[k], 1), np.nan))
        return np.array(out)
