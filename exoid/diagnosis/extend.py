"""Add an effect and watch the error: the same samples, the same filter, one model after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.diagnosis.evidence.fitted import fitted_model, places_pay
from exoid.diagnosis.report.material import Material, pictures_of
from exoid.diagnosis.report.page import Reported
from exoid.diagnosis.results import Falling, Step
from exoid.diagnosis.rules import RULES
from exoid.diagnosis.verdict import biased_parameters, sentence_of
from exoid.ground.errors import ExoidError
from exoid.ground.files import MODEL_FILES
from exoid.ground.frames import pandas
from exoid.ground.html import bullets, lines, picture
from exoid.ground.plain import by_name
from exoid.measurement.forces import pushed_model
from exoid.measurement.reading.given import Given, machine_of, model_of, question_of
from exoid.measurement.signals.methods import BUTTERWORTH
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import Prepared, prepare
from exoid.symbolic.codegen.kernel import compiled
from exoid.symbolic.effect import Effect
from exoid.symbolic.model import Model
from exoid.symbolic.wording import added_said, title_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Waterfall(Falling):
    """The error from model to model, and the fits behind it."""

    stopped_because: str
    fits: tuple[Fit, ...] = field(repr=False, default=())

    @property
    def fit(self) -> Fit:
        """The fit of the last model."""
        return self.fits[-1]

    def to_frame(self) -> Any:
        """Return one row per step."""
        rows = [s.to_json() for s in self.steps]
        return pandas().DataFrame(rows, columns=["model", "train_rms", "verify_rms"])

    def figures(self) -> list[tuple[str, str, Figure]]:
        """Return (title, alternative text, figure)."""
        return [("The error falling", repr(self), self.plot())]

    def material(self) -> Material:
        """Material that the report draws on, the recordings apart."""
        return Material(
            title="The error from model to model", answer=self.stopped_because, model=self.model, fit=self.fit,
            fall=self, pictures=pictures_of(self),
        )  # fmt: skip

    def __repr__(self) -> str:
        lines = []
        for step in self.steps:
            numbers = ", ".join(f"{joint} {x:.3f}" for joint, x in zip(self.joints, step.evaluation_rms, strict=True))
            lines.append(f"{added_said(step.label)}: {step.judged} error [{self.unit}] {numbers}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        return self._table() + picture(self.plot(), repr(self))

    def _json(self) -> dict[str, Any]:
        return {"steps": self.steps, "noise_floor": self.noise_floor, "stopped_because": self.stopped_because}


@dataclass(frozen=True, eq=False)
class Addition(Reported):
    """One effect added: the extended `model`, the fits `before` and `after`, and whether unseen motion gained."""

    model: Model
    before: Fit
    after: Fit
    waterfall: Waterfall
    sentence: str
    helped: bool
    backend: str
    biased: tuple[str, ...] = ()

    def figures(self) -> list[tuple[str, str, Figure]]:
        """Return (title, alternative text, figure)."""
        return self.waterfall.figures()

    def to_frame(self) -> Any:
        """Return one row per step."""
        return self.waterfall.to_frame()

    def plot(self) -> Figure:
        """Draw the falling error."""
        return self.waterfall.plot()

    def material(self) -> Material:
        """Material that the report draws on, the recordings apart."""
        added = self.model.terms[-1]
        return Material(
            title=f"{title_of(added.effect, added.joint)}, added", answer=self.sentence, model=self.model,
            fit=self.after, fall=self.waterfall, pictures=pictures_of(self),
        )  # fmt: skip

    def __repr__(self) -> str:
        return f"{self.sentence}\n{self.waterfall!r}"

    def _repr_html_(self) -> str:
        return lines(strong=self.sentence) + self.waterfall._repr_html_() + bullets(self.biased)

    def _json(self) -> dict[str, Any]:
        return {
            "helped": self.helped, "sentence": self.sentence, "backend": self.backend, "biased": self.biased,
            "parameters": by_name(self.after.estimates), "steps": self.waterfall.steps,
            "noise_floor": self.waterfall.noise_floor, "stopped_because": self.waterfall.stopped_because,
        }  # fmt: skip


def fit_in_turn(
    models: Sequence[Model],
    recordings: Given,
    verify: Given = (),
    *,
    cutoff: float | None = None,
    derivative: str = BUTTERWORTH,
) -> Waterfall:
    """Fit one model after the other to the same samples and return how the error falls."""
    if not models:
        raise ValueError("watch needs at least one model")
    _, recordings, verify = question_of(models[0], recordings, verify)
    models = [pushed_model(model, (*recordings, *verify)) for model in models]
    prepared = prepare(models[0], recordings, verify, cutoff=cutoff, derivative=derivative)
    fits = [identify(model, prepared.train, optimisers=()) for model in models]
    return _waterfall(fits, prepared)


def add(
    model: Any,
    effect: Any,
    recordings: Given | None = None,
    verify: Given = (),
    *,
    joint: str | None = None,
    cutoff: float | None = None,
    derivative: str = BUTTERWORTH,
) -> Addition:
    """Extend `model` by `effect` ("stribeck:hip", or an Effect at `joint`), generate and compile its code, refit, and
    compare.

    Recordings are what `exoid.measurement.reading.given` takes. Without a model, `add("stribeck:hip", recordings,
    verify)`, they are of the standard leg. Refuses effects that do not exist there or that the model has already.
    """
    if isinstance(model, Effect) or (isinstance(model, str) and Path(model).suffix.lower() not in MODEL_FILES):
        verify = recordings if recordings is not None else verify
        model, effect, recordings = Model.standard(), model, effect
    own = machine_of(model_of(model))
    if recordings is None or (isinstance(recordings, str) and recordings in own.joint_names):
        raise ExoidError(
            f"{recordings!r} is a joint and no recording",
            remedy=f"add(model, 'stribeck:{recordings or own.joint_names[0]}', recordings, verify)",
        )
    model, recordings, verify = question_of(own, recordings, verify)
    model = pushed_model(model, (*recordings, *verify))
    extended = model.with_effect(effect, joint)
    prepared = prepare(model, recordings, verify, cutoff=cutoff, derivative=derivative)
    found = identify(extended, prepared.train, optimisers=())
    if extended.terms[-1].may_move:
        each = identify(model.with_effect(effect, joint, own_places=True), prepared.train, optimisers=())
        if places_pay(fitted_model(found, prepared), fitted_model(each, prepared)):
            extended, found = each.model, each
    code = compiled(extended)
    judged = fitted_model(found, prepared).judged_anew()
    before = identify(model, judged.train, optimisers=())
    after = found if judged is prepared else identify(extended, judged.train, optimisers=())
    waterfall = _waterfall([before, after], judged)
    term = extended.terms[-1]
    prefix = f"{term.name}."
    numbers = {e.name.removeprefix(prefix): e for e in after.estimates if e.name.startswith(prefix)}
    first, last = (step.evaluation_rms for step in waterfall.steps)
    change = (first - last) / np.maximum(first, 1e-300)
    # At the joint that gains most; where the others lose more than it gains, at the one that loses most.
    fall = float(change.max() if change.sum() > 0.0 else change.min())
    inside = _admissible(extended, after, prefix)
    helped = fall > RULES.negligible and not inside
    kind = "unseen" if verify else "fitted"
    text = f"{sentence_of(term, numbers)}: the {kind} error falls by {100 * fall:.1f} % at the joint that gains most."
    if fall <= RULES.negligible:
        text = f"{sentence_of(term, numbers)} does not lower the {kind} error; the model is better without it."
    elif inside:
        text += f" But {inside}: it is not this effect that is missing."
    if not verify:
        text += " No recording was held out (verify), so nothing shows that it holds on other motion."
    return Addition(extended, before, after, waterfall, text, helped, code.backend, biased_parameters(before, after))


def _waterfall(fits: Sequence[Fit], prepared: Prepared) -> Waterfall:
    steps: list[Step] = []
    known: set[str] = set()
    for fit in fits:
        now = fitted_model(fit, prepared)
        new = [t for t in now.model.terms if t.name not in known]
        known |= {t.name for t in now.model.terms}
        if steps and new:
            label = " ".join(f"+ {t.name}" for t in new)
        else:
            label = "base" if not now.model.terms else now.model.name
        steps.append(Step(label, now.train_rms, now.verify_rms))
    return Waterfall(tuple(steps), prepared.noise_floor, fits[-1].model, "these were the models given", tuple(fits))


def _admissible(model: Model, fit: Fit, prefix: str) -> str:
    """Return "" or, in words, which coefficient of the new term has a value it physically cannot have."""
    for parameter in model.parameters:
        if not parameter.name.startswith(prefix):
            continue
        value = fit.estimate(parameter.name).value
        if parameter.min is not None and value < parameter.min:
            return f"{parameter.name} = {value:.3g} {parameter.unit}, which cannot be below {parameter.min:g}"
        if parameter.max is not None and value > parameter.max:
            return f"{parameter.name} = {value:.3g} {parameter.unit}, which cannot be above {parameter.max:g}"
    return ""
