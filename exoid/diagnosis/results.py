"""Results of a diagnosis. The JSON of `exoid diagnose` and `discover` is these fields written out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from exoid.diagnosis.comparison import Comparison, compare_prepared
from exoid.diagnosis.evidence.agreement import Agreement
from exoid.diagnosis.evidence.apart import Apart
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model
from exoid.diagnosis.evidence.model_error import ModelError
from exoid.diagnosis.evidence.power import Power
from exoid.diagnosis.evidence.remainder import Remainder
from exoid.diagnosis.outside import ForceUse
from exoid.diagnosis.own_numbers.numbers import Belonging
from exoid.diagnosis.plots import falling_error, torques_over_time
from exoid.diagnosis.report.material import Material, Picture, pictures_of
from exoid.diagnosis.report.page import Reported
from exoid.diagnosis.rules import RULES, Rules
from exoid.diagnosis.sureness import FAIRLY, MEANINGS, UNSURE, least_sure, meanings_of, sureness
from exoid.ground.frames import pandas
from exoid.ground.html import Bar, bullets, fold, lines, picture, table
from exoid.ground.plain import AsJson, by_name
from exoid.ground.text import digits
from exoid.measurement.finding import Finding
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.fitting.thigh_length import ThighLength
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate
from exoid.symbolic.wording import added_said, called, number_of, the_joint

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

SCHEMA = "exoid.discovery/1"
HEADLINES: Mapping[str, str] = MappingProxyType(
    {
        "adequate": "Nothing is missing that these recordings can tell from noise",
        "unexplained": "Something is left that no known effect explains",
        "check_channels": "Check the channels: they cannot be what they say",
    }
)
"""The answer in a line where no effect was found."""


@dataclass(frozen=True, eq=False)
class Entry(AsJson):
    """An effect at a joint; None for one of no joint alone."""

    effect: str
    joint: str | None

    @property
    def name(self) -> str:
        """Full name, e.g. "stribeck:knee"."""
        return self.effect if self.joint is None else f"{self.effect}:{self.joint}"


@dataclass(frozen=True)
class Suspect(Entry):
    """A catalogue entry with its evidence.

    `explained_share`: of the weighted error of the joints it acts on, on motion it was not fitted to.
    """

    explained_share: float
    p_value: float | None
    look_alikes: tuple[str, ...] = ()
    caution: str = ""
    sureness: str = ""
    """How sure it is that it is missing (`exoid.diagnosis.sureness`); "" where it was not accepted."""


@dataclass(frozen=True, eq=False)
class Accepted(Entry):
    """An effect that was added, its parameters as fitted in the last model, and what it changed (RMS in N·m).

    Of its `look_alikes` some are `never_separable` by any motion, and some are `outside` the catalogue. `left` is how
    many times the noise is left at its joints in the last model, `share` what it takes of their squared error.
    """

    parameters: Mapping[str, Estimate]
    look_alikes: tuple[str, ...]
    never_separable: tuple[str, ...]
    p_value: float
    rms_before: Float
    rms_after: Float
    sentence: str
    agreement: Agreement = field(default_factory=Agreement)
    against: tuple[str, ...] = ()
    outside: tuple[str, ...] = ()
    left: float = 0.0
    share: float = 0.0
    doubted: bool = False
    """Doubt that comes from no other effect: angles that were filtered."""

    @property
    def fall(self) -> float:
        """By what share of itself the squared error of unseen motion fell with it, the mean of the joints it shows."""
        seen = np.asarray(self.rms_before) > 0.0
        return float(1.0 - np.mean((self.rms_after[seen] / self.rms_before[seen]) ** 2)) if seen.any() else 0.0

    @property
    def sureness(self) -> str:
        """Certainty that it is missing, in one word (`exoid.diagnosis.sureness`)."""
        doubted = bool(self.look_alikes) or self.doubted
        return sureness(self.p_value, self.agreement, doubted=doubted, left=self.left)

    @property
    def stability(self) -> str:
        """In how many splits of the recordings it is accepted, with which values; "" where none can tell."""
        units = {name: e.unit for name, e in self.parameters.items()}
        unknown = {name for name, e in self.parameters.items() if e.is_unknown}
        known = {name: ends for name, ends in self.agreement.ranges.items() if name not in unknown}
        agreement = replace(self.agreement, ranges=known)
        return stability_of(agreement, units, self.against, lambda key: number_of(f"{self.effect}.{key}"))

    def _json(self) -> dict[str, Any]:
        return {
            "effect": self.effect, "joint": self.joint, "parameters": self.parameters, "look_alikes": self.look_alikes,
            "never_separable": self.never_separable, "p_value": self.p_value, "rms_before": self.rms_before,
            "rms_after": self.rms_after, "sentence": self.sentence, "accepted_in": self.agreement.share,
            "splits": self.agreement.of, "ranges": self.agreement.ranges, "against": self.against,
            "stability": self.stability, "sureness": self.sureness, "times_noise_left": self.left,
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class Possible(Entry):
    """An effect that helps but is not accepted: only some splits support it, or `reason` says what speaks against it.

    `parameters` have the range over the splits as `low` and `high`; `early`: its torque would come before its motion.
    """

    agreement: Agreement
    parameters: Mapping[str, Estimate]
    explained_share: float
    reason: str
    early: bool = False

    @property
    def sentence(self) -> str:
        """The effect and why it is only possible, in words."""
        return f"{called(self.name)}: {self.reason}"

    def _json(self) -> dict[str, Any]:
        return {
            "effect": self.effect, "joint": self.joint, "accepted_in": self.agreement.share,
            "splits": self.agreement.of, "parameters": self.parameters, "explained_share": self.explained_share,
            "reason": self.reason,
        }  # fmt: skip


def stability_of(
    agreement: Agreement, units: Mapping[str, str], against: Sequence[str] = (), said: Callable[[str], str] = str
) -> str:
    """Return e.g. "accepted in 83 of 84 splits, c 0.0031 to 0.0042 kg·m²", and who disagrees; `said` names a number."""
    if agreement.share is None:
        return ""
    text = f"accepted in {agreement.accepted} of {agreement.of} splits of the recordings"
    for name, (low, high) in agreement.ranges.items():
        if low == high:  # a choice
            continue
        unit = "" if units.get(name, "1") in ("1", "") else f" {units[name]}"
        text += f", {said(name)} {low:.3g} to {high:.3g}{unit}"
    if against and agreement.accepted < agreement.of:
        text += f"; it loses where {', '.join(against)} {'are' if against[1:] else 'is'} held out"
    return text


@dataclass(frozen=True, eq=False)
class Step(AsJson):
    """One model on the way down: RMS (J,) in N·m after the common filter, on the same samples at every step."""

    label: str
    train_rms: Float
    verify_rms: Float | None
    sentence: str = ""

    @property
    def judged(self) -> str:
        """On which motion a reader is shown the error: "unseen" where there are verification recordings."""
        return "fitted" if self.verify_rms is None else "unseen"

    @property
    def evaluation_rms(self) -> Float:
        """The error (J,) on that motion, N·m."""
        return self.train_rms if self.verify_rms is None else self.verify_rms

    def _json(self) -> dict[str, Any]:
        return {
            "model": self.label, "train_rms": self.train_rms, "verify_rms": self.verify_rms, "sentence": self.sentence,
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class Falling(Reported):
    """A result with `steps` from model to model, the last of which is `model`, down to the `noise_floor` (J,) N·m."""

    steps: tuple[Step, ...]
    noise_floor: Float
    model: Model

    @property
    def unit(self) -> str:
        """Unit of the torques, in words."""
        return self.model.torque_unit

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints (J,), in the order of every list per joint."""
        return self.model.joint_names

    def plot(self) -> Figure:
        """Draw the falling error."""
        unseen = [step.verify_rms for step in self.steps if step.verify_rms is not None]
        fitted = np.array([step.train_rms for step in self.steps])
        names = [added_said(step.label) for step in self.steps]
        seen = np.array(unseen) if unseen else None
        return falling_error(names, fitted, seen, self.noise_floor, self.joints, self.unit)

    def _table(self) -> str:
        """Return the falling error as an HTML table with bars, the noise floor as its last row."""
        longest = np.max([step.evaluation_rms for step in self.steps], axis=0)

        def cell(values: Float | None, j: int, shown: bool) -> Any:
            value = None if values is None else float(values[j])
            return Bar(value, value / longest[j]) if shown and value is not None and longest[j] > 0.0 else value

        rows: list[tuple[Any, ...]] = []
        for step in self.steps:
            pairs = ((step.train_rms, step.verify_rms is None), (step.verify_rms, True))
            cells = (cell(values, j, shown) for j in range(len(self.joints)) for values, shown in pairs)
            rows.append((added_said(step.label), *cells))
        rows.append(("noise floor", *np.repeat(self.noise_floor, 2).tolist()))
        kinds = (f"{joint}, {kind}" for joint in self.joints for kind in ("fitted", "unseen"))
        return table((f"RMS error [{self.unit}]", *kinds), rows)


@dataclass(frozen=True, eq=False)
class Conclusion:
    """Verdict, the rule that fired, the sentence, why it stopped, and what to measure next.

    `verdict` is "adequate", "missing", "ambiguous", "unexplained" or "check_channels"; `rule` says which rule led
    to it, `sentence` says it to a technician. `error` is what is left beside what was found.
    """

    verdict: str
    rule: str
    sentence: str
    stopped_because: str
    next_experiment: str
    error: ModelError | None = field(default=None, kw_only=True)
    outside: bool = field(default=False, kw_only=True)
    """An error that is not the machine's: something acts from outside that was not measured; nothing else is then said
    of the machine's numbers."""


@dataclass(frozen=True, eq=False)
class Diagnosis(Falling, Conclusion):
    """The answer of `diagnose` (at most one step) and `discover` (to the end).

    `fit` is that of the last of the `steps`. `of_recordings` is what belongs to recordings, a zero or a load of their
    own; `possible` are effects that help and are not accepted. `rules` are the thresholds that decided, `given` is the
    model that was asked about, fitted to all the recordings as they were prepared, `last` the one that was found, on
    them without what belongs to recordings. `forces` are the measured ones of the model, `left_out` recordings that are
    not of what the others are of, `power` what would have shown where nothing is missing.
    """

    schema: ClassVar[str] = SCHEMA
    INSTEAD: ClassVar[Mapping[str, str]] = {
        "save": "found.report('out') writes the page, found.model.save('leg.toml', found.fit) the model; "
        "found.to_json() is the whole answer",
        "summary": "print(found)",
    }

    accepted: tuple[Accepted, ...]
    suspects: tuple[Suspect, ...]
    unexplained: Remainder | None
    audit: tuple[Finding, ...]
    seconds: float
    fit: Fit = field(repr=False)
    cutoff: str = ""
    biased: tuple[str, ...] = ()
    possible: tuple[Possible, ...] = ()
    rules: Rules = field(default=RULES, repr=False)
    thigh_length: ThighLength | None = None
    given: FittedModel | None = field(default=None, repr=False)
    last: FittedModel | None = field(default=None, repr=False)
    forces: tuple[ForceUse, ...] = ()
    left_out: tuple[Apart, ...] = ()
    power: tuple[Power, ...] = ()
    of_recordings: tuple[Belonging, ...] = ()
    inside: Diagnosis | None = field(default=None, repr=False)
    """The answer of the machine alone, where that, or a doubt about what a search found, is told in its place."""

    @property
    def sureness(self) -> str:
        """Certainty of the whole answer: that of its least sure effect, and never very sure where more is missing; ""
        where nothing was accepted. Beside others those with look-alikes are told by themselves.
        """
        told, alike = self._told_apart
        words = [item.sureness for item in told or alike]
        return least_sure([*words, FAIRLY] if words and self.more_missing else words)

    @property
    def more_missing(self) -> str:
        """Error beside what was accepted, in words: where, and how many times the noise; "" for none."""
        if self.error is not None:
            return f"{the_joint(self.error.joint)} keeps {self.error.beside}"
        left = self.unexplained
        return "" if left is None else f"{the_joint(left.joint)} keeps what no known effect explains"

    @property
    def headline(self) -> str:
        """The answer in a line: "Found: end stop at the hip, 35 N·m/rad ...; very sure"."""
        if self.verdict not in ("missing", "ambiguous"):
            own = self.verdict == "adequate" and self.of_recordings
            return f"{HEADLINES[self.verdict]}, beside what belongs to recordings" if own else HEADLINES[self.verdict]
        told, alike = self._told_apart
        parts = [*(item.sentence for item in told), self.sureness] if told else []
        if alike:
            which = "which of their look-alikes they are" if len(alike) > 1 else "which of its look-alikes it is"
            parts += [*(entry.sentence for entry in alike), f"{UNSURE} {which}"]
        if more := self.more_missing:
            parts.append(f"more is missing: {more}")
        return f"Found: {'; '.join(parts)}"

    @property
    def further(self) -> str:
        """Rest of the sentence, beyond the headline."""
        named = "; ".join(effect.sentence for effect in self.accepted)
        return self.sentence.removeprefix(f"Missing: {named}. ").removeprefix("Check the channels. ")

    @property
    def _told_apart(self) -> tuple[list[Accepted], list[Accepted]]:
        """Those accepted that nothing else explains as well, and those with look-alikes."""
        return [a for a in self.accepted if not a.look_alikes], [a for a in self.accepted if a.look_alikes]

    def called(self, name: str) -> str:
        """Title in words of an effect such as "stribeck:knee"."""
        return called(name, self.model.find_effect)

    @property
    def _unexplained_json(self) -> dict[str, Any]:
        curve, error = self.unexplained, self.error if self.verdict == "unexplained" else None
        if curve is None:
            return {
                "significant": error is not None, "joint": None if error is None else error.joint, "variables": [],
                "share": 0.0 if error is None else 1.0 - error.times**-2.0, "suggested_terms": [],
            }  # fmt: skip
        return {
            "significant": True, "joint": curve.joint, "variables": curve.variables, "share": curve.joint_share,
            "p_value": curve.p_value, "suggested_terms": [s.text for s in curve.suggestions],
            "suggested_toml": [s.to_toml(curve.joint, curve.own) for s in curve.suggestions[:1]],
        }  # fmt: skip

    def to_frame(self) -> pd.DataFrame:
        """Return the suspects, one row each, best first."""
        rows = [
            (s.name, s.explained_share, s.sureness, s.p_value, ", ".join(s.look_alikes), s.caution)
            for s in self.suspects
        ]
        head = ["effect", "explained_share", "sureness", "p_value", "look_alikes", "caution"]
        return pandas().DataFrame(rows, columns=head)

    def figures(self) -> list[tuple[str, str, Figure]]:
        """Return (title, alternative text, figure) of everything there is to see."""
        first, last = self.steps[0], self.steps[-1]
        text = "; ".join(
            f"{joint}: {first.judged} error from {digits(before)} to {digits(after)} {self.unit}"
            for joint, before, after in zip(self.joints, first.evaluation_rms, last.evaluation_rms, strict=True)
        )
        out = [("The error falling", text, self.plot())]
        if self.unexplained is not None:
            out.append(("What nobody explains", self.unexplained.sentence, self.unexplained.plot()))
        return out

    def material(self, first: Comparison | None = None) -> Material:
        """Material of the report, the recordings apart; `first` is the Comparison of the model asked about."""
        if first is None and self.given is not None:
            first = compare_prepared(self.given.fit, self.given.prepared)
        seen = pictures_of(first, section="where")
        top: tuple[Picture, ...]
        if first is not None and len(self.steps) > 1:
            top = (Picture(*first.before_and_after(self.fitted_on(first.now.prepared)), "verdict"),)
        else:  # then the answer stands above measured and modelled torque
            top, seen = tuple(replace(picture, section="verdict") for picture in seen[:1]), seen[1:]
        return Material(
            title="What the model was missing", model=self.model, fit=self.fit, comparison=first, diagnosis=self,
            fall=self, pictures=top + pictures_of(self, section="suspects") + seen,
            settings={"filter": self.cutoff} if self.cutoff else {}, seconds=self.seconds,
        )  # fmt: skip

    def __repr__(self) -> str:
        lines = [f"{self.verdict}: {self.headline.removeprefix('Found: ')}", f"  {self.further}", f"  why: {self.rule}"]
        names = [added_said(step.label) for step in self.steps]
        for step, name in zip(self.steps, names, strict=True):
            numbers = ", ".join(f"{joint} {x:.3f}" for joint, x in zip(self.joints, step.evaluation_rms, strict=True))
            lines.append(f"  {name:<{max(map(len, names))}}  {step.judged} error [{self.unit}]: {numbers}")
        lines += [f"  {text}" for text in (*self._stable, *(f"possible, {p.sentence}" for p in self.possible))]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        rows = [
            (self.called(s.name), f"{100 * s.explained_share:.0f} %", s.sureness or None,
             ", ".join(map(self.called, s.look_alikes)), s.caution, s.p_value, s.name)
            for s in self.suspects[:8]
        ]  # fmt: skip
        head = ("suspect", "explains", "how sure", "look-alikes in these data", "caution", "p-value", "id")
        ranking = table(head, rows) + fold("what the words mean", bullets(meanings_of(MEANINGS)))
        return (
            lines(self.further, strong=self.headline)
            + self._table()
            + self._torques()
            + (ranking if rows else "")
            + fold("why", lines(f"{self.verdict}: {self.rule}", *self._stable))
            + lines(*(f"possible, {p.sentence}" for p in self.possible))
            + lines(self.next_experiment and f"measure next: {self.next_experiment}")
        )

    @property
    def _stable(self) -> list[str]:
        return [f"{self.called(a.name)}: {a.stability}" for a in self.accepted if a.stability]

    def fitted_on(self, prepared: Prepared) -> FittedModel:
        """Return the model that was found on all recordings, without what belongs to them unless some were left out."""
        names = [item.name for item in prepared.all]
        if self.last is not None and names == [item.name for item in self.last.prepared.all]:
            return self.last
        return fitted_model(self.fit, prepared)

    def _torques(self) -> str:
        """Return the picture of the torque before and after, where the recordings are known."""
        if self.given is None:
            return ""
        models = {"model": self.given}
        if len(self.steps) > 1:
            models = {"before": self.given, "after": self.fitted_on(self.given.prepared)}
        return picture(torques_over_time(models), f"Torque over time, measured, and of: {', '.join(models)}")

    def _json(self) -> dict[str, Any]:
        return {
            "schema": self.schema, "verdict": self.verdict, "headline": self.headline, "sureness": self.sureness,
            "joints": self.joints, "rule": self.rule, "sentence": self.sentence, "accepted": self.accepted,
            "suspects": self.suspects, "possible": self.possible, "steps": self.steps, "noise_floor": self.noise_floor,
            "unexplained": self._unexplained_json, "model_error": self.error, "next_experiment": self.next_experiment,
            "biased": self.biased, "of_recordings": self.of_recordings, "filter": self.cutoff,
            "stopped_because": self.stopped_because, "parameters": by_name(self.fit.estimates), "forces": self.forces,
            "left_out": self.left_out, "power": self.power, "thigh_length": self.thigh_length, "audit": self.audit,
            "seconds": self.seconds,
        }  # fmt: skip
