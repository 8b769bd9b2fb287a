"""Can the channels be what they say? If not, nothing is accepted: an effect named on top of them is nonsense.

Asked before the search: whether the encoders' noise leaves accelerations worth the name, and whether the torque would
fit far better if it were read earlier, or as what a slow filter made of it. Asked of the best model that the search
finds: whether it leaves more of the torque than a third, and whether the held-out recordings are of the same machine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.evidence.fitted import FittedModel, fitted_model
from diagnosis.rules import RULES, Rules
from ground.errors import NotEnoughDataError
from measurement.finding import Finding
from measurement.signals.butterworth import lag_filter
from optimisation.fitting.identify import identify
from optimisation.fitting.thigh_length import wanted_thigh_length
from optimisation.preparation.filtering import PreparedRecording
from optimisation.preparation.prepare import Prepared
from symbolic.motion import Float

DELAYS = (-0.5, -0.35, -0.25, -0.18, -0.13, -0.1, 0.1, 0.13, 0.18, 0.25, 0.35, 0.5)
"""Delays of the torque that are tried, s; smaller ones are left to the catalogue."""
LAGS = (0.05, 0.08, 0.12, 0.18, 0.28, 0.45)
"""Time constants of a filter of first order on the torque that are tried, s."""


@dataclass(frozen=True)
class Doubt:
    """Why the channels cannot be what they say: the rule that fired, the sentence, and what to do."""

    rule: str
    sentence: str
    remedy: str


def doubts_before(base: FittedModel, rules: Rules = RULES) -> Doubt | None:
    """Return what makes a search pointless, judged with the model that is there; None where nothing does."""
    return _noisy_angles(base, rules) or _late_torque(base, rules)


def doubts_after(base: FittedModel, last: FittedModel, rules: Rules = RULES) -> Doubt | None:
    """Return what makes the best model that was found (`last`) no answer; `base` is the model the search began with."""
    return (
        _wrong_length(base, last, rules)
        or _unexplained_torque(base, last, rules)
        or _impossible_base(base, rules)
        or _another_machine(base if last.model.shapes else last, rules)
    )


def channel_findings(fitted: FittedModel, rules: Rules = RULES) -> tuple[Finding, ...]:
    """Return as a warning what makes a model that was only fitted, not searched, no answer; () where nothing does."""
    if fitted.prepared.misread:
        return ()
    doubt = doubts_before(fitted, rules) or _another_machine(fitted, rules)
    share = left_share(fitted)
    if doubt is None and np.nanmax(share, initial=0.0) > rules.unexplained_share:
        parts = ", ".join(f"{joint} {100 * x:.0f} %" for joint, x in _finite(share, fitted.model.joint_names))
        text = f"This model leaves {parts} of the torque's variance: channels are wrong, or something large is missing"
        doubt = Doubt("unexplained", text, f"{_COLUMNS}; `exoid discover` finds which of the two it is")
    if doubt is None:
        return ()
    return (Finding("channels", "warning", doubt.sentence.rstrip("."), "all recordings", remedy=doubt.remedy),)


def left_share(fitted: FittedModel) -> Float:
    """Return the share (J,) of the variance of the torque that a model leaves, the larger of fitted and held out.

    The variance is that of all recordings: a held-out one that happens to need hardly any torque is no wrong channel.
    NaN for a joint that has no torque of its own to explain: undriven, or without a usable sample.
    """
    count = len(fitted.prepared.train)
    parts = [slice(0, count)] + ([slice(count, None)] if fitted.verified else [])
    joints = len(fitted.model.joints)
    out = np.full((len(parts), joints), np.nan)
    for joint in range(joints):
        known = [p.tau[p.use[:, joint], joint] for p in fitted.prepared.all if p.driven[joint]]
        whole = float(np.concatenate(known).var()) if sum(t.size for t in known) else 0.0
        for row, part in enumerate(parts):
            pairs = zip(fitted.residuals[part], fitted.prepared.all[part], strict=True)
            left = [r[joint][p.use[:, joint]] for r, p in pairs if p.driven[joint]]
            if whole > 0.0 and sum(r.size for r in left):
                out[row, joint] = np.mean(np.concatenate(left) ** 2) / whole
    seen = np.isfinite(out).any(axis=0)
    return np.where(seen, np.max(np.where(np.isfinite(out), out, -np.inf), axis=0), np.nan)


def _noisy_angles(base: FittedModel, rules: Rules) -> Doubt | None:
    share = base.prepared.acceleration_noise
    if not share > rules.angle_noise:
        return None
    density = np.max([one.angle_noise * 0.5 * one.full_rate for one in base.prepared.train], axis=0)
    size = " and ".join(f"{x:.2g}" for x in np.sqrt(density)) + f" rad at {' and '.join(base.model.joint_names)}"
    return Doubt(
        f"noise of the angles makes {100 * share:.0f} % of the accelerations, at {base.prepared.choice.cutoff:g} Hz",
        f"The angles are too noisy for their accelerations ({size}): at the slowest useful cut-off "
        f"noise makes {100 * share:.0f} % of them, so every inertia comes out too small by about that part, and "
        "whatever smooths the model looks like an effect.",
        "check the encoders and the columns of the angles; record faster motion, or repeat one periodic motion many "
        "times and use --derivative fourier",
    )


def _late_torque(base: FittedModel, rules: Rules) -> Doubt | None:
    """Return whether the torque of both joints is late, early, or behind a slow filter, by more than a drive can be."""
    share = left_share(base)
    if not np.nanmax(share, initial=0.0) > rules.late_least or np.all(
        base.judged_rms < 3.0 * base.prepared.noise_floor
    ):
        return None
    model, train = base.model, base.prepared.train
    reference = base.linear if model.needs_reference else None
    raw = [model.columns(p.motion, s, reference) for p, s in zip(train, base.shapes, strict=False)]
    still = _Readings(train, raw)
    now = still.left(lambda x, rate: x)
    tried: list[tuple[float, str, float]] = []
    for kind, values in (("delay", DELAYS), ("lag", LAGS)):
        losses = [(still.left(_change(kind, value)), value) for value in values]
        lowest, best = min(losses)
        # What is no better than the torque as it stands lies in no valley that is worth a closer look.
        near = [best * factor for factor in (0.8, 0.87, 0.93, 1.07, 1.15, 1.25)] if lowest < now else []
        least, value = min([*losses, *((still.left(_change(kind, v)), v) for v in near)])
        tried.append((least, kind, value))
    least, kind, value = min(tried)
    if least > rules.late_gain * now:
        return None
    what = (
        f"comes {abs(value):.2g} s {'after' if value > 0 else 'before'} the motion it belongs to"
        if kind == "delay"
        else f"is what a filter of first order with {1.0 / (2.0 * np.pi * value):.2g} Hz leaves of the true one"
    )
    mend = (
        f"shift the torque columns by {abs(value):.2g} s, or find out why the logger is late"
        if kind == "delay"
        else "log the torque before this filter, or take the filter off the sensor's or drive's settings"
    )
    return Doubt(
        f"the squared error falls to {100 * least / now:.0f} % of itself if the torque {what}",
        f"The torque does not belong to the motion as it is logged: it looks as if it {what}; read so, the model "
        f"leaves {100 * least / now:.0f} % of the squared error it leaves now.",
        mend,
    )


def _change(kind: str, value: float) -> Callable[[Float, float], Float]:
    return (
        (lambda x, rate: _delayed(x, value * rate))
        if kind == "delay"
        else (lambda x, rate: lag_filter(value * rate).run(x))
    )


def _delayed(x: Float, samples: float) -> Float:
    """Return `x` (M, N) as it was so many samples before, its ends held."""
    last = x.shape[1] - 1
    at = np.clip(np.arange(last + 1) - samples, 0, last)
    low = np.minimum(at.astype(int), last - 1)
    part = at - low
    return np.asarray((1.0 - part) * x[:, low] + part * x[:, low + 1])


class _Readings:
    """Columns (J, N, P) of a model on recordings, to be read with other dynamics between torque and motion."""

    def __init__(self, prepared: Sequence[PreparedRecording], raw: Sequence[Float]) -> None:
        self.prepared = prepared
        self.width = raw[0].shape[2]
        # Of each recording and joint which columns are not zero, and these (M, N).
        told = [[np.flatnonzero(joint.any(axis=0)) for joint in one] for one in raw]
        self.rows = [
            [(places, np.ascontiguousarray(joint[:, places].T)) for places, joint in zip(some, one, strict=True)]
            for some, one in zip(told, raw, strict=True)
        ]
        used = [np.concatenate(parts) for parts in zip(*(self._used(one) for one in prepared), strict=True)]
        self.size = [float(tau.var() * tau.size) if tau.size else 0.0 for tau in used]

    @staticmethod
    def _used(one: PreparedRecording) -> list[Float]:
        return [tau[use] for tau, use in zip(one.tau.T, one.use.T, strict=True)]

    def left(self, change: Callable[[Float, float], Float]) -> float:
        """Return what a fit leaves of the torque if the columns are changed, the sum of the shares of the joints."""
        gram, slope = np.zeros((self.width, self.width)), np.zeros(self.width)
        parts = []
        for one, rows in zip(self.prepared, self.rows, strict=True):
            for joint, (places, columns) in enumerate(rows):
                changed = np.array(change(columns, one.rate))  # a copy: it is bridged in place
                smooth = one.smooth_rows(changed[None], (joint,), 0)[0] * one.use[:, joint]
                tau = one.tau[:, joint] * one.use[:, joint]
                gram[np.ix_(places, places)] += smooth @ smooth.T
                slope[places] += smooth @ tau
                parts.append((joint, tau, places, smooth))
        length = np.sqrt(np.diagonal(gram))
        scale = np.where(length > 0.0, length, 1.0)
        linear = np.linalg.lstsq(gram / np.outer(scale, scale), slope / scale, rcond=1e-13)[0] / scale
        square = np.zeros(len(self.size))
        for joint, tau, places, smooth in parts:
            square[joint] += np.sum((tau - linear[places] @ smooth) ** 2)
        return float(sum(x / size for x, size in zip(square, self.size, strict=True) if size > 0.0))


def _wrong_length(base: FittedModel, last: FittedModel, rules: Rules) -> Doubt | None:
    """Return whether another thigh length explains far more than everything that was found."""
    length = wanted_thigh_length(base.fit, base.prepared)
    if length is None or not length.wrong:
        return None
    seen = base.train_rms > 0.0
    reached = np.mean((last.train_rms[seen] / base.train_rms[seen]) ** 2)
    with_length = np.mean(1.0 - np.array(length.gain)[seen])
    if with_length > rules.own_length * reached:
        return None
    return Doubt(
        f"with a thigh length of {length.value:.3g} m the squared error falls to {100 * with_length:.0f} %, with what "
        f"the catalogue has to {100 * reached:.0f} %",
        f"The thigh length contradicts the recordings: {length.sentence}. No effect is named on top of a wrong length.",
        f"measure the thigh; the recordings want [geometry] thigh_length = {length.value:.3g} in a model file",
    )


def _unexplained_torque(base: FittedModel, last: FittedModel, rules: Rules) -> Doubt | None:
    share = left_share(last)
    if not np.nanmax(share, initial=0.0) > rules.unexplained_share:
        return None
    parts = ", ".join(f"{joint} {100 * x:.0f} %" for joint, x in _finite(share, last.model.joint_names))
    odd = _odd_recordings(base, rules)
    files = " and ".join(odd)
    which = f" Fitted alone, {files} cannot be explained either, and the other recordings can." if odd else ""
    return Doubt(
        f"the best model leaves more than {100 * rules.unexplained_share:.0f} % of the variance of a torque: {parts}",
        f"The torque is not that of this leg in this motion: the best model that was found leaves {parts} of its "
        f"variance unexplained.{which} Nothing is named on top of that.",
        f"begin with {files}: {_COLUMNS}" if odd else _COLUMNS,
    )


def _odd_recordings(base: FittedModel, rules: Rules) -> list[str]:
    """Return the names of recordings of which the model leaves much of the torque even if it is fitted to one alone,
    where it explains the others so; [] where they are alike, or most of them odd.
    """
    odd, known = [], 0
    for one in base.prepared.all:
        try:
            alone = identify(base.model, (one,), optimisers=())
        except NotEnoughDataError:
            continue
        known += 1
        share = left_share(fitted_model(alone, replace(base.prepared, train=(one,), verify=())))
        if np.nanmax(share, initial=0.0) > rules.unexplained_share:
            odd.append(one.name)
    return odd if 2 * len(odd) < known else []


_COLUMNS = (
    "check the columns and their order (--map), units (--units), the signs and zeros of angles and torques, and "
    "whether torque and motion are of the same run; draw them over time, or start with a slow motion of one joint"
)


def _impossible_base(base: FittedModel, rules: Rules) -> Doubt | None:
    """Return whether an effect had to rescue a rigid leg that explains little and could not exist."""
    share = left_share(base)
    wrong = [
        f for f in base.fit.plausibility if f.severity == "warning" and f.check in ("bounds", "inertia", "realisable")
    ]
    if not np.nanmax(share, initial=0.0) > rules.base_share or not wrong:
        return None
    parts = ", ".join(f"{joint} {100 * x:.0f} %" for joint, x in _finite(share, base.model.joint_names))
    return Doubt(
        f"the rigid leg leaves {parts} of the torque's variance, and its numbers are impossible ({wrong[0].what})",
        f"The channels do not fit a leg: weight, inertia and friction together leave {parts} of the torque's variance "
        "unexplained, with numbers that no leg has. What then explains the rest only makes up for a wrong sign, zero "
        "or column.",
        _COLUMNS,
    )


def _another_machine(last: FittedModel, rules: Rules) -> Doubt | None:
    """Return whether held-out recordings are well explained by numbers of their own, and badly by those fitted."""
    unseen = last.verify_rms
    if unseen is None:
        return None
    used = [any(p.use[:, j].any() for p in last.prepared.verify) for j in range(len(unseen))]
    known = (last.train_rms > 0.0) & np.array(used)
    if not known.any():
        return None
    worse = unseen[known] / last.train_rms[known]
    if worse.max() < rules.another_machine or worse.min() < 2.0:
        return None
    swapped: Prepared = replace(last.prepared, train=last.prepared.verify, verify=())
    alone = fitted_model(identify(last.model, swapped.train, optimisers=()), swapped)
    if np.mean((alone.train_rms[known] / unseen[known]) ** 2) > rules.own_machine:
        return None
    own = {e.name: e for e in alone.fit.estimates}
    moved = [
        f"{e.name} {e.value:.3g} and {own[e.name].value:.3g} {e.unit}"
        for e in last.fit.estimates
        if e.name in own and (e.high < own[e.name].low or own[e.name].high < e.low)
    ]
    errors = ", ".join(
        f"{joint.name} {a:.3g} {joint.unit('tau')} on fitted and {b:.3g} {joint.unit('tau')} on held-out motion"
        for joint, a, b, k in zip(last.model.joints, last.train_rms, unseen, known, strict=True)
        if k
    )
    return Doubt(
        f"the held-out error is {worse.max():.0f} times the fitted one, and a fit of the held-out recordings alone "
        "leaves little of it",
        f"The held-out recordings are not of the machine that was fitted: the model leaves {errors}, yet fitted alone "
        f"they are explained. Fitted and held out want: {'; '.join(moved[:4])}.",
        "verify with recordings of the same leg, with the same load (--payload) and the same zeros",
    )


def _finite(share: Float, joints: Sequence[str]) -> Iterator[tuple[str, float]]:
    return ((joint, float(x)) for joint, x in zip(joints, share, strict=True) if np.isfinite(x))
