"""The answer to a question about before and after."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.diagnosis.against.questions import Acting
from exoid.diagnosis.evidence.model_error import LEAST_NOISE
from exoid.diagnosis.rules import RULES
from exoid.ground.figures import figure_style, new_figure
from exoid.ground.frames import pandas
from exoid.ground.html import bullets, lines, picture, table
from exoid.ground.plain import AsJson, by_name
from exoid.ground.text import digits
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate
from exoid.symbolic.wording import the_joint

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Course:
    """The course of a difference: at times `t` (K,) in s, how much of the whole change (1) stretches of the recordings
    want (`wants`, (K,)), and how much they can tell (`power`, (K,)).
    """

    t: Float
    wants: Float
    power: Float


@dataclass(frozen=True, eq=False)
class ChangeFound(AsJson):
    """One thing that differs: `name` is that of an effect ("load_friction:knee"), of a number of the model
    ("coulomb:knee") or of a load ("payload:shank"); `kind` is "effect", one that was not there, "number" of the model,
    "load", put on or taken off, or "sensor", one that reads otherwise.

    `before` and `after` are the same numbers before and after, `change` what they differ by, each with its 95 %
    interval (valid under autocorrelation). `look_alikes` explain these data as well. `share` is the part of the
    loss that it explains, held out; `p_value` how rarely chance does, among all that is asked. Of a load, `place` is
    how far down its link it is, which is looked for with the mass: the interval of either holds for any value of the
    other.
    """

    name: str
    kind: str
    before: tuple[Estimate, ...]
    after: tuple[Estimate, ...]
    change: tuple[Estimate, ...]
    shape: Mapping[str, float]
    look_alikes: tuple[str, ...]
    share: float
    p_value: float
    course: Course | None = field(default=None, repr=False)
    place: Estimate | None = None
    acting: Acting | None = field(default=None, repr=False)

    @property
    def sentence(self) -> str:
        """The difference in words."""
        parts = [f"{_said(new)} after, {_said(old)} before" for old, new in zip(self.before, self.after, strict=True)]
        if self.kind == "load":  # what was carried all along is in the model's own numbers
            parts = [f"{_said(item)} more" for item in self.change]
        shape = "".join(f", {key} = {value:.3g}" for key, value in self.shape.items())
        if self.place is not None:
            shape = f", {_said(self.place)} down the {self.joint}"
        alike = f"; these data cannot distinguish it from {', '.join(self.look_alikes)}" if self.look_alikes else ""
        return f"{self.name}: {'; '.join(parts)}{shape}{alike}"

    @property
    def effect(self) -> str | None:
        """The effect that it is, where it is one."""
        return self.name.partition(":")[0] if self.kind in ("effect", "sensor") else None

    @property
    def joint(self) -> str | None:
        """The joint or link that it is at, where there is one."""
        return self.name.partition(":")[2] or None

    def _json(self) -> dict[str, Any]:
        return {
            "name": self.name, "kind": self.kind, "effect": self.effect, "joint": self.joint,
            "before": by_name(self.before), "after": by_name(self.after), "change": by_name(self.change),
            "shape": self.shape, "place": self.place, "look_alikes": self.look_alikes, "explained_share": self.share,
            "p_value": self.p_value, "sentence": self.sentence,
        }  # fmt: skip


def _said(estimate: Estimate) -> str:
    unit = "" if estimate.unit in ("", "1") else f" {estimate.unit}"
    return f"{estimate.value:.3g} [{estimate.low:.3g}, {estimate.high:.3g}]{unit}"


@dataclass(frozen=True, eq=False)
class Differences(AsJson):
    """Differences between recordings made `before` and `after`; nothing is a result as well.

    `old` are errors of the model that were there all along and that these recordings show; `rms_before` and
    `rms_after` (J,) in `units` (J,) are those of the model fitted before, `rms_named` that of after with what is named.
    """

    found: tuple[ChangeFound, ...]
    old: tuple[str, ...]
    before: tuple[str, ...]
    after: tuple[str, ...]
    joints: tuple[str, ...]
    rms_before: tuple[float, ...]
    rms_after: tuple[float, ...]
    rms_named: tuple[float, ...]
    units: tuple[str, ...]
    seconds: float = 0.0
    audit: tuple[Any, ...] = field(default=(), repr=False)

    @property
    def differs(self) -> bool:
        """True if anything differs."""
        return bool(self.found)

    @property
    def sentence(self) -> str:
        """The answer in words."""
        each = zip(self.joints, self.rms_before, self.rms_named, self.units, strict=True)
        grown = [
            f"the error of {the_joint(joint)} grew from {digits(before)} to {digits(after)} {unit}"
            for joint, before, after, unit in each
            if after > RULES.near_noise * max(before, LEAST_NOISE)
        ]
        beside = ", and ".join(grown)
        if not self.found and not beside:
            return "Nothing differs between before and after that these recordings could show."
        if not self.found:
            return f"Nothing that was asked about explains it, but {beside}: look at the channels of those after."
        text = "Different afterwards: " + "; ".join(item.name for item in self.found) + "."
        return f"{text} That is not all: beside it, {beside}." if beside else text

    def __repr__(self) -> str:
        return "\n".join([self.sentence, *(f"  {item.sentence}" for item in self.found), *self._old()])

    def _old(self) -> list[str]:
        return [f"  no change, but missing in the model before and after: {name}" for name in self.old]

    def _numbers(self) -> list[tuple[ChangeFound, Estimate, Estimate]]:
        """Every number that differs, before and after."""
        return [(d, b, a) for d in self.found for b, a in zip(d.before, d.after, strict=True)]

    def _repr_html_(self) -> str:
        rows = [(d.name, d.kind, str(b), str(a), ", ".join(d.look_alikes)) for d, b, a in self._numbers()]
        head = ("what", "kind", "before", "after", "look-alikes")
        named = table(head, rows) if rows else ""
        return lines(strong=self.sentence) + picture(self.plot(), self.sentence) + named + bullets(self._old())

    def to_frame(self) -> Any:
        """Return one row per number that differs."""
        rows = [
            {
                "name": d.name, "kind": d.kind, "number": a.name, "unit": a.unit,
                "before": b.value, "before_low": b.low, "before_high": b.high,
                "after": a.value, "after_low": a.low, "after_high": a.high,
            }
            for d, b, a in self._numbers()
        ]  # fmt: skip
        return pandas().DataFrame(rows)

    def figures(self) -> list[tuple[str, str, Figure]]:
        """Return (title, alternative text, figure)."""
        return [("The error before and after", self.sentence, self.plot())]

    def plot(self) -> Figure:
        """Draw the error of the model fitted before: before, after, and after with what is named."""
        errors = {"before": self.rms_before, "after": self.rms_after, "after, with what is named": self.rms_named}
        with figure_style():
            figure = new_figure(6.0, 3.2)
            axes = figure.subplots()
            place = np.arange(len(self.joints))
            for k, (label, values) in enumerate(errors.items()):
                axes.bar(place + 0.27 * (k - 1), values, 0.25, label=label)
            axes.set_xticks(place, self.joints)
            axes.set_ylabel(f"error of the model [{', '.join(dict.fromkeys(self.units))}]")
            axes.legend()
        return figure

    def _json(self) -> dict[str, Any]:
        return {
            "differs": self.differs, "sentence": self.sentence, "differences": self.found,
            "missing_all_along": self.old, "before": self.before, "after": self.after, "joints": self.joints,
            "units": self.units, "rms_before": self.rms_before, "rms_after": self.rms_after,
            "rms_after_named": self.rms_named, "audit": self.audit, "seconds": self.seconds,
        }  # fmt: skip
