"""Recordings that are not of what the others are of: a torque that was stuck, another machine or load, other columns.

A model fitted to the others explains each of them, and of the odd one leaves a large part of the torque, several times
what it leaves of any other. An effect that the model lacks is in all recordings, more or less, and raises what is left
of each. The oddest are taken away one after the other, as many as all stand out together: one bad file spoils
a fit to all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath

import numpy as np
from numpy.typing import NDArray

from exoid.diagnosis.evidence.channel_doubt import variance_known
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.errors import NotEnoughDataError
from exoid.ground.plain import AsJson
from exoid.ground.ties import index_of_least
from exoid.measurement.auditing.checks.units import CHECK as UNITS
from exoid.measurement.finding import Finding
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.filtering import PreparedRecording, driven_joints
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


def odd_ones(base: FittedModel, rules: Rules = RULES) -> tuple[int, ...]:
    """Indices of the recordings, fitted ones first, that are apart from the others; () where none or too many are."""
    evidence, count = base.evidence(seed=0, draws=0, rules=rules), len(base.prepared.all)
    units = evidence.of == np.arange(count)[:, None]
    samples = np.array([np.count_nonzero(item.used) for item in base.prepared.all])
    out: list[int] = []
    plain: tuple[int, ...] = ()
    while len(out) + 1 <= MOST * count and count - len(out) - 1 >= OTHERS:
        rest = np.setdiff1d(np.arange(count), out)
        without = units[rest].any(axis=0) & ~units[rest]
        fits = evidence.fits(without)
        losses = evidence.held_out(without).loss(fits.step[:, :, None])[:, 0]
        worst = index_of_least(losses / np.maximum(samples[rest].sum() - samples[rest], 1))
        out.append(int(rest[worst]))
        left = _shares(replace(base, residuals=tuple(evidence.left(k, fits.step[worst]) for k in range(count))))
        others = np.nan_to_num(left[np.delete(rest, worst)]).max(axis=0)
        if all(_plain(left[k], others, rules).any() for k in out):
            plain = tuple(sorted(out))
    return plain


def left_out(base: FittedModel, found: Fit, odd: Sequence[int], rules: Rules = RULES) -> tuple[dict[int, Apart], float]:
    """Those of the recordings `odd` (indices) that the model found for the others does not explain either, with the
    reason to leave them out; and the share that numbers of their own explain, of the one of which that is least.
    """
    count, every, power = len(base.prepared.train), base.prepared.all, _power(base)
    train, held = ([every[k] for k in part if k not in odd] for part in (range(count), range(count, len(every))))
    others_first = replace(base.prepared, train=tuple(train), verify=(*held, *(every[k] for k in odd)))
    judged = fitted_model(found, others_first)
    left, first = _shares(judged), len(every) - len(odd)
    out: dict[int, Apart] = {}
    least = 1.0
    others = np.nan_to_num(left[:first]).max(axis=0)
    for index, k in enumerate(odd, first):
        own = left[index]
        plain = _plain(own, others, rules)
        if not plain.any():
            continue
        errors = ", ".join(
            f"{np.sqrt(own[j] * power[j]):.3g} {joint.unit('tau')} at the {joint.name} "
            f"({np.sqrt(own[j] / max(others[j], 1e-12)):.2g} times as much as of any other)"
            for j, joint in enumerate(base.model.joints)
            if plain[j]
        )
        alone, share = _alone(base, found, every[k], float(np.nansum(own)))
        text = f"{every[k].name} is left out: what explains the others leaves {errors}"
        text += _why(judged, index, alone, share, rules)
        out[k], least = Apart(every[k].name, text), min(least, share)
    return out, least


def _why(judged: FittedModel, index: int, alone: Fit | None, share: float, rules: Rules) -> str:
    prepared, name = judged.prepared, judged.prepared.all[index].name
    driven, others = prepared.all[index].driven, driven_joints(prepared.all)
    if dead := [joint.name for joint, none in zip(judged.model.joints, others & ~driven, strict=True) if none]:
        return f"; the torque of the {' and the '.join(dead)} is zero throughout: a dead channel, or something held it"
    for finding in prepared.misread:
        if _is_of(finding, name):
            return f"; {finding.what} ({finding.remedy})"
    for finding in prepared.findings:
        if finding.check == UNITS and finding.severity == "warning" and _is_of(finding, name):
            return f"; {finding.what} (write the unit into the header of that file)"
    if alone is None:
        return ""
    if share < 1.0 - rules.little:
        return ", and fitted alone it is not explained either: look at its columns and sensors"
    own = {e.name: e for e in alone.estimates}
    pairs = [(e, own[e.name]) for e in judged.fit.estimates if e.name in own]
    moved = [
        f"{e.name} {e.value:.3g} and {its.value:.3g} {e.unit}".rstrip()
        for e, its in pairs
        if e.high < its.low or its.high < e.low  # by more than both intervals allow
    ]
    numbers = f" ({', '.join(moved[:4])})" if moved else ""
    text = f", and fitted alone it is explained, with numbers of its own{numbers}"
    return f"{text}: another machine, a load (--payload), or a unit or gain of a sensor"


def _alone(base: FittedModel, found: Fit, one: PreparedRecording, whole: float) -> tuple[Fit | None, float]:
    """Return a fit of the model found to one recording alone, and the share that it explains of what is left (`whole`)
    of its torques; None and nothing where one is not enough.
    """
    try:
        alone = identify(found.model, (one,), optimisers=())
    except NotEnoughDataError:
        return None, 0.0
    fitted = fitted_model(alone, replace(base.prepared, train=(one,), verify=()))
    return alone, 1.0 - float(np.nansum(_shares(fitted)[0])) / whole


def _is_of(finding: Finding, name: str) -> bool:
    file = finding.where.partition(", ")[0]
    return f"/{PurePath(file).with_suffix('')}".endswith(f"/{name}") or file == name


def _plain(own: Float, others: Float, rules: Rules) -> NDArray[np.bool_]:
    """Return at which joints (J,) far more is left of one recording, `own`, than of any other, `others`."""
    left = np.nan_to_num(own)
    return np.asarray((left > rules.worth_telling) & (left > rules.near_noise**2 * others))


def _power(base: FittedModel) -> Float:
    """Return the variance (J,) of the torque of each joint, the median of the recordings; NaN for one without drive."""
    each = np.array([variance_known([item]) for item in base.prepared.all]).T
    known = [row[np.isfinite(row)] for row in each]
    return np.array([np.median(row) if row.size else np.nan for row in known])


def _shares(fitted: FittedModel) -> Float:
    """Return the share (R, J) of the usual variance of a torque that is left of each recording. A torque that is zero
    throughout counts as zero, as it does in the fit: where the channel is dead, much is left.
    """
    pairs = zip(fitted.residuals, fitted.prepared.all, strict=True)
    left = [np.sum(r**2, axis=1, where=item.used) / np.maximum(item.used.sum(axis=1), 1) for r, item in pairs]
    return np.array(left) / _power(fitted)
