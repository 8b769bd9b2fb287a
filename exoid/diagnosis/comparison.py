"""Model against measurement: how large the error is, and where it is.

The share of a joint's error that follows a variable is what a smooth curve in it predicts on blocks the curve has not
seen, so that chance explains nothing (and may come out negative, which is reported as zero).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.diagnosis.cautions import OUTSIDE, cautions
from exoid.diagnosis.evidence.best_effects import as_given
from exoid.diagnosis.evidence.curves import variables
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model, pooled_rms
from exoid.diagnosis.evidence.model_error import is_near_noise
from exoid.diagnosis.evidence.remainder import Remainder, remainders
from exoid.diagnosis.evidence.strides import Strides, strides_of
from exoid.diagnosis.outside import ForceUse, force_uses
from exoid.diagnosis.plots import against, torques_over_time
from exoid.diagnosis.report.material import NOTHING_HELD_OUT, Material, pictures_of
from exoid.diagnosis.report.page import Reported
from exoid.diagnosis.where import Where, samples_of, where_it_sits
from exoid.ground.frames import pandas
from exoid.ground.html import picture, table
from exoid.ground.plain import by_name
from exoid.ground.text import digits
from exoid.measurement.finding import Finding
from exoid.measurement.forces import pushed_model
from exoid.measurement.reading.given import Given, question_of
from exoid.measurement.signals.methods import BUTTERWORTH
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.fitting.thigh_length import ThighLength, wanted_thigh_length
from exoid.optimisation.preparation.prepare import Prepared, prepare
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float
from exoid.symbolic.wording import per_joint

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

MOST_FIGURES = 4
"""Places of the error that are drawn, the largest first."""


@dataclass(frozen=True, eq=False)
class Comparison(Reported):
    """A fitted model compared with recordings; all RMS (J,) in N·m after the common filter.

    `rms` on the fitted recordings, `verify_rms` on unseen ones (None without any), `signal_rms` of the torque itself,
    `noise_floor` estimated without a model. `where` is ranked, the largest share first. `curves` are behind it.
    `forces` are the measured ones of the model: where each acts, and what it makes. `strides` are those of the shown
    recordings, None where the motion has none.
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
    forces: tuple[ForceUse, ...] = ()
    strides: Strides | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints (J,), in the order of every list per joint."""
        return self.now.model.joint_names

    @property
    def unit(self) -> str:
        """Unit of the torques, in words."""
        return self.now.model.torque_unit

    @property
    def misread(self) -> tuple[Finding, ...]:
        """Findings that the recordings keep another convention."""
        return self.now.prepared.misread

    def to_frame(self) -> pd.DataFrame:
        """Table of where the error is, one row each."""
        return pandas().DataFrame([w.to_json() for w in self.where], columns=["joint", "variable", "share", "sentence"])

    def plot(self) -> Figure:
        """Draw measured and modelled torque over time, with what is left."""
        return torques_over_time({"model": self.now})

    def before_and_after(self, after: FittedModel) -> tuple[str, str, Figure]:
        """Return (title, alternative text, figure): the measured torque, this model and the one that came of it, which
        may be beside what belongs to recordings.

        On the first recording that is held out, or the first of all.
        """
        pairs = zip(self.joints, self.now.evaluation_rms, after.evaluation_rms, strict=True)
        text = "; ".join(f"{joint}: error {digits(b)} before, {digits(a)} {self.unit} after" for joint, b, a in pairs)
        kind = "the fitted motion" if self.verify_rms is None else "unseen motion"
        figure = torques_over_time({"before": self.now, "after": after})
        return f"Measured, before and after, on {kind}", text, figure

    def figures(self) -> list[tuple[str, str, Figure]]:
        """Return (title, alternative text, figure) of everything there is to see."""
        alt = f"Torque of {' and '.join(self.joints)} over time, measured and modelled, with the difference below each."
        out = [("Measured and modelled torque", alt, self.plot())]
        if self.strides is not None:
            out.append(("Torque and error over the stride", self.strides.sentence, self.strides.plot()))
        drawn: dict[tuple[str, str], Where] = {}
        for item in self.where:
            drawn.setdefault((item.joint, item.variable), item)
        for entry in list(drawn.values())[:MOST_FIGURES]:
            words = variables(self.now.model.joints)[entry.variable]
            at = samples_of(self.now, entry.joint, entry.variable)
            names = [recording.name for recording in self.now.prepared.all]
            groups = {
                "direction": {"moving up": at.speed > 0.0, "moving down": at.speed < 0.0},
                "recording": {name: at.recording == k for k, name in enumerate(names)},
            }.get(entry.split, {})
            unit = self.now.model.joints[self.joints.index(entry.joint)].unit("tau")
            picture = against(entry.joint, words, at.x, at.y, at.block, groups, self.joints, unit)
            out.append((f"{entry.joint}: error against {words[0]}", entry.sentence, picture))
        return out

    def material(self) -> Material:
        """Material that the report draws on, the recordings apart."""
        kind, rms, held_out = "motion the fit has not seen", self.verify_rms, ""
        if rms is None:
            kind, rms, held_out = "the fitted motion", self.rms, f" {NOTHING_HELD_OUT}"
        error = per_joint(rms, self.joints, self.unit)
        return Material(
            title="Model against measurement", model=self.fit.model, fit=self.fit, comparison=self,
            answer=f"The model's torque misses the measured one by {error} (RMS) on {kind}.{held_out}",
            pictures=pictures_of(self, section="where"),
        )  # fmt: skip

    def __repr__(self) -> str:
        shown = self.rms if self.verify_rms is None else self.verify_rms
        kind = "fitted motion (nothing is held out)" if self.verify_rms is None else "unseen motion"
        numbers = ", ".join(
            f"{joint} {digits(e)} of {digits(s)} {self.unit} (noise floor {n:.2g})"
            for joint, e, s, n in zip(self.joints, shown, self.signal_rms, self.noise_floor, strict=True)
        )
        doubts = [f"  {finding}" for finding in self.misread]
        return "\n".join([f"error on {kind}: {numbers}", *doubts, *(f"  {w.sentence}" for w in self.where[:6])])

    def _repr_html_(self) -> str:
        unseen = [None] * len(self.joints) if self.verify_rms is None else self.verify_rms.tolist()
        known, fitted, floor = (x.tolist() for x in (self.signal_rms, self.rms, self.noise_floor))
        size = [*zip(self.joints, known, fitted, unseen, floor, strict=True)]
        where = [(f"{100 * w.share:.0f} %", w.sentence, w.caution) for w in self.where[:6]]
        return (
            table((f"RMS [{self.unit}]", "torque", "error, fitted", "error, unseen", "noise floor"), size)
            + picture(self.plot(), "Torque over time, measured and modelled, with what is left")
            + (table(("share", "where the error sits", "caution"), where) if where else "")
        )

    def _json(self) -> dict[str, Any]:
        return {
            "joints": self.joints, "rms": self.rms, "verify_rms": self.verify_rms, "signal_rms": self.signal_rms,
            "noise_floor": self.noise_floor, "sse_verify_rms": self.sse_verify_rms, "where": self.where,
            "per_recording": dict(self.per_recording), "filter": self.cutoff, "parameters": by_name(self.fit.estimates),
            "forces": self.forces, "strides": self.strides, "thigh_length": self.thigh_length, "audit": self.audit,
        }  # fmt: skip


def compare(
    model: Model | Fit | Given | None = None,
    recordings: Given | None = None,
    verify: Given = (),
    *,
    cutoff: float | None = None,
    derivative: str = BUTTERWORTH,
) -> Comparison:
    """Fit `model` to `recordings` (or take a Fit as it is) and hold it against them and `verify`.

    Both are what `exoid.measurement.reading.given` takes: recordings, paths, tables, one or many; alone they are of the
    standard leg. Refuses recordings that are too short or do not determine the model.
    """
    asked, recordings, verify = question_of(model, recordings, verify)
    leg: Model = asked.model if isinstance(asked, Fit) else pushed_model(asked, (*recordings, *verify))
    prepared = prepare(leg, recordings, verify, cutoff=cutoff, derivative=derivative)
    fit = asked if isinstance(asked, Fit) else identify(leg, prepared.train, optimisers=())
    return compare_prepared(fit, prepared)


def compare_prepared(fit: Fit, prepared: Prepared) -> Comparison:
    """Hold a Fit against recordings that are prepared already."""
    now = fitted_model(fit, prepared)
    if prepared.misread and is_near_noise(now):
        now = as_given(now)  # a model that leaves about the noise reads the channels rightly
        prepared = now.prepared
    unseen = verification(fit, prepared)
    doubts = cautions(now)
    length = None if any(doubt.check == OUTSIDE for doubt in doubts) else wanted_thigh_length(fit, prepared)
    curves = remainders(now, now.evidence(seed=0, draws=1), placebos=0)
    shown = prepared.verify or prepared.train
    return Comparison(
        fit=fit,
        rms=now.train_rms,
        verify_rms=now.verify_rms,
        signal_rms=pooled_rms([item.torque for item in shown], shown),
        noise_floor=prepared.noise_floor,
        sse_verify_rms=None if unseen is None else unseen[1],
        where=() if now.prepared.misread else where_it_sits(now, curves),
        per_recording=tuple(now.per_recording),
        cutoff=prepared.choice.reason,
        audit=(*prepared.findings, *doubts, *(() if length is None else (length.finding(),))),
        thigh_length=length,
        now=now,
        curves=tuple(curves),
        forces=force_uses(now),
        strides=strides_of(now),
    )


def verification(fit: Fit, prepared: Prepared) -> tuple[Float, Float] | None:
    """RMS errors (J,) in N·m on the verification recordings, None without any, of the Huber and of the SSE parameters:
    the paper's check.
    """
    if not prepared.verify:
        return None
    shapes = np.broadcast_to(fit.sse.shape, np.shape(fit.shapes))
    first = replace(fit, linear=fit.sse.linear, shape=fit.sse.shape, shapes=shapes)
    huber, squares = (fitted_model(item, prepared).evaluation_rms for item in (fit, first))
    return huber, squares
