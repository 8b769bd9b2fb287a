"""Model against measurement: how large the error is, and where it is.

The share of a joint's error that follows a variable is what a smooth curve in it predicts on blocks the curve has not
seen, so that chance explains nothing (and may come out negative, which is reported as zero). What a variable says
beyond one curve, near which values and at reversals, is measured on the residual itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from diagnosis.evidence.channels import channel_findings
from diagnosis.evidence.fitted import FittedModel, fitted_model
from diagnosis.evidence.remainder import Remainder, remainders, split_variable, variables
from diagnosis.plots import against, over_time
from ground.html import table
from ground.plain import AsJson, plain_dict
from measurement.finding import Finding
from measurement.recording import Recording
from measurement.signals.derivatives import BUTTERWORTH
from optimisation.fitting.fit import Fit
from optimisation.fitting.identify import identify
from optimisation.fitting.thigh_length import ThighLength, wanted_thigh_length
from optimisation.preparation.prepare import Prepared, prepare
from symbolic.model import Model
from symbolic.motion import Float

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

LEAST_SHARE = 0.01
"""Smallest share worth a line."""
SLOW = 0.1
"""Velocity in rad/s below which a joint counts as slow."""
AT_LIMIT = 0.05
"""Share of the joint's range at either end that counts as near the end."""


@dataclass(frozen=True)
class Where(AsJson):
    """One place the error sits at: `share` of the joint's squared error, said in `sentence`; `caution` if any."""

    joint: str
    variable: str
    share: float
    sentence: str
    caution: str = ""


@dataclass(frozen=True, eq=False)
class Comparison:
    """A fitted model held against recordings; all RMS (J,) in N·m after the common filter.

    `rms` on the fitted recordings, `verify_rms` on unseen ones (None without any), `signal_rms` of the torque itself,
    `noise_floor` estimated without a model. `where` is ranked, the largest share first. `curves` are behind it.
    """

    fit: Fit
    rms: Float
    verify_rms: Float | None
    signal_rms: Float
    noise_floor: Float
    sse_verify_rms: Float | None
    where: tuple[Where, ...]
    per_recording: tuple[tuple[str, Float], ...]
    cutoff: str
    audit: tuple[Finding, ...]
    now: FittedModel = field(repr=False)
    curves: tuple[Remainder, ...] = field(repr=False)
    thigh_length: ThighLength | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints (J,), in the order of every list per joint."""
        return self.now.model.joint_names

    @property
    def misread(self) -> tuple[Finding, ...]:
        """What says that the recordings keep another convention."""
        return self.now.prepared.misread

    def to_json(self) -> dict[str, Any]:
        """Return the comparison in plain types."""
        return plain_dict({
            "joints": list(self.joints),
            "rms": self.rms,
            "verify_rms": self.verify_rms,
            "signal_rms": self.signal_rms,
            "noise_floor": self.noise_floor,
            "sse_verify_rms": self.sse_verify_rms,
            "where": self.where,
            "per_recording": {name: rms.tolist() for name, rms in self.per_recording},
            "filter": self.cutoff,
            "parameters": {e.name: e for e in self.fit.estimates},
            "thigh_length": None if self.thigh_length is None else self.thigh_length.to_json(),
            "audit": self.audit,
        })

    def to_frame(self) -> pd.DataFrame:
        """Return where the error is, one row each."""
        import pandas as pd

        return pd.DataFrame([w.to_json() for w in self.where], columns=["joint", "variable", "share", "sentence"])

    def plot(self) -> Figure:
        """Draw measured and modelled torque over time, with what is left."""
        index = len(self.now.prepared.train) if self.now.prepared.verify else 0
        one = self.now.prepared.all[index]
        model = self.now.torque(index).T
        left = np.where(one.use, self.now.residuals[index].T, np.nan)
        return over_time(one.name, one.t, one.tau, model, left, self.joints)

    def figures(self) -> list[tuple[str, str, Figure]]:
        """Return (title, alternative text, figure) of everything there is to see."""
        alt = f"Torque of {' and '.join(self.joints)} over time, measured and modelled, with the difference below each."
        out = [("Measured and modelled torque", alt, self.plot())]
        sentences: dict[tuple[str, str], str] = {}
        for one in self.where:
            if one.variable != "load":
                sentences.setdefault((one.joint, one.variable), one.sentence)
        for (joint, variable), sentence in list(sentences.items())[:4]:
            words = variables(self.now.model.joints)[variable]
            drawn = against(joint, words, *_samples(self.now, self.joints.index(joint), variable))
            out.append((f"{joint}: error against {words[0]}", sentence, drawn))
        return out

    def __repr__(self) -> str:
        shown = self.rms if self.verify_rms is None else self.verify_rms
        kind = "fitted motion (nothing is held out)" if self.verify_rms is None else "unseen motion"
        numbers = ", ".join(
            f"{joint} {e:.3g} of {s:.3g} N·m (noise floor {n:.2g})"
            for joint, e, s, n in zip(self.joints, shown, self.signal_rms, self.noise_floor, strict=True)
        )
        doubts = [f"  {finding}" for finding in self.misread]
        return "\n".join([f"error on {kind}: {numbers}", *doubts, *(f"  {w.sentence}" for w in self.where[:6])])

    def _repr_html_(self) -> str:
        unseen = [None] * len(self.joints) if self.verify_rms is None else self.verify_rms.tolist()
        size = [
            (joint, float(self.signal_rms[j]), float(self.rms[j]), unseen[j], float(self.noise_floor[j]))
            for j, joint in enumerate(self.joints)
        ]
        where = [(f"{100 * w.share:.0f} %", w.sentence, w.caution) for w in self.where[:6]]
        return table(("RMS [N·m]", "torque", "error, fitted", "error, unseen", "noise floor"), size) + (
            table(("share", "where the error sits", "caution"), where) if where else ""
        )


def compare(
    model: Model | Fit,
    recordings: Sequence[Recording],
    verify: Sequence[Recording] = (),
    *,
    cutoff: float | None = None,
    derivative: str = BUTTERWORTH,
) -> Comparison:
    """Fit `model` to `recordings` (or take a Fit as it is) and hold it against them and `verify`.

    Refuses recordings that are too short or do not determine the model.
    """
    leg: Model = model.model if isinstance(model, Fit) else model  # type: ignore[assignment]
    prepared = prepare(leg, recordings, verify, cutoff=cutoff, derivative=derivative)
    fit = model if isinstance(model, Fit) else identify(leg, prepared.train, optimisers=())
    return compare_prepared(fit, prepared)


def compare_prepared(fit: Fit, prepared: Prepared) -> Comparison:
    """Hold a Fit against recordings that are prepared already."""
    now = fitted_model(fit, prepared)
    unseen = verification(fit, prepared)
    length = wanted_thigh_length(fit, prepared)
    curves = remainders(now, now.evidence(seed=0, draws=1), placebos=0, each_joint=True)
    shown = prepared.verify or prepared.train
    square = np.sum([np.sum(np.where(p.use, p.tau, 0.0) ** 2, axis=0) for p in shown], axis=0)
    count = np.maximum(np.sum([p.use.sum(axis=0) for p in shown], axis=0), 1)
    return Comparison(
        fit=fit,
        rms=now.train_rms,
        verify_rms=now.verify_rms,
        signal_rms=np.sqrt(square / count),
        noise_floor=prepared.noise_floor,
        sse_verify_rms=None if unseen is None else unseen.sse,
        where=_where(now, curves),
        per_recording=tuple(now.per_recording),
        cutoff=prepared.choice.reason,
        audit=(*prepared.findings, *channel_findings(now), *(() if length is None else (length.finding(),))),
        thigh_length=length,
        now=now,
        curves=tuple(curves),
    )


@dataclass(frozen=True, eq=False)
class Verification:
    """RMS error (J,) in N·m on unseen recordings of the Huber and of the SSE parameters: the paper's check."""

    huber: Float
    sse: Float

    def to_json(self) -> dict[str, Any]:
        """Return both in plain types."""
        return plain_dict({"verify_rms": self.huber, "sse_verify_rms": self.sse})


def verification(fit: Fit, prepared: Prepared) -> Verification | None:
    """Return the errors on the verification recordings; None without any."""
    if not prepared.verify:
        return None
    shapes = np.broadcast_to(fit.sse.shape, np.shape(fit.shapes))
    first = replace(fit, linear=fit.sse.linear, shape=fit.sse.shape, shapes=shapes)
    pair = [fitted_model(one, prepared).verify_rms for one in (fit, first)]
    return Verification(np.asarray(pair[0]), np.asarray(pair[1]))


def _where(now: FittedModel, curves: Sequence[Remainder]) -> tuple[Where, ...]:
    """Return the ranked list: curves that predict unseen error, and the regions in which the error gathers."""
    found = []
    for joint in now.model.joint_names:
        mine = [c for c in curves if c.joint == joint and c.share >= LEAST_SHARE]
        seen: set[str] = set()
        for one in mine:
            if one.variable in seen:
                continue
            seen.add(one.variable)
            words, _ = variables(now.model.joints)[one.variable]
            direction = " and the direction of motion" if one.directed else ""
            moved = ", at a place that differs between recordings" if one.own else ""
            # A curve helps other joints a little too, through the parameters they share: never say above 100 %.
            share = min(1.0, one.share)
            text = f"{joint}: {100 * share:.0f} % of the squared error follows the {words}{direction}{moved}"
            caution = "" if one.unseen > 0.0 else "not so on the verification recordings"
            found.append(Where(joint, one.variable, share, text, caution))
        found += _regions(now, joint)
    return tuple(sorted(found, key=lambda w: -w.share))


def _samples(now: FittedModel, j: int, variable: str) -> tuple[Float, Float, Float]:
    """Return `variable` and the residual at joint `j` in every usable sample, and which block of 2 s it belongs to."""
    xs, ys, blocks = [], [], []
    for number, (one, residual) in enumerate(zip(now.prepared.all, now.residuals, strict=True)):
        used, motion = one.use[:, j], one.motion
        from_start = motion.t - motion.t[0]
        stem, index = split_variable(variable)
        signal = from_start if variable == "t" else getattr(motion, stem)[:, index]
        xs.append(signal[one.kept][used])
        ys.append(residual[j][used])
        blocks.append((1000 * number + np.arange(len(one.t)) // max(1, int(2.0 * one.kept_rate)))[used])
    return np.concatenate(xs), np.concatenate(ys), np.concatenate(blocks)


def _regions(now: FittedModel, joint: str) -> list[Where]:
    """Return the regions (slow motion, the ends of the range) that hold much more error than time."""
    j = now.model.joint_names.index(joint)
    train = now.prepared.train
    used = [p.use[:, j] for p in train]
    error = np.concatenate([r[j][u] ** 2 for r, u in zip(now.residuals[: len(train)], used, strict=True)])
    q = np.concatenate([p.motion.q[p.kept, j][u] for p, u in zip(train, used, strict=True)])
    dq = np.concatenate([p.motion.dq[p.kept, j][u] for p, u in zip(train, used, strict=True)])
    if error.size == 0:
        return []
    span = float(np.ptp(q))
    total = float(error.sum()) or 1.0
    high, low = q.max() - AT_LIMIT * span, q.min() + AT_LIMIT * span
    regions = (
        (f"dq{j + 1}", np.abs(dq) < SLOW, f"within ±{SLOW:g} rad/s, where it creeps or reverses"),
        (f"q{j + 1}", q > high, f"above {high:.2f} rad, at the upper end"),
        (f"q{j + 1}", q < low, f"below {low:.2f} rad, at the lower end"),
    )
    out = []
    for variable, mask, words in regions:
        share, time = float(error[mask].sum()) / total, float(mask.mean())
        if share > 2.0 * time and share > 0.15:
            text = f"{joint}: {100 * share:.0f} % of the squared error sits {words}, in {100 * time:.0f} % of the time"
            out.append(Where(joint, variable, share, text))
    return out
