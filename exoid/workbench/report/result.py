"""The report of a result that Python has: `found.report("out")`; the commands say of the same what else they know."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from exoid.workbench.report.material import Material, before_and_after, pictures_of
from exoid.workbench.report.page import write_report
from exoid.workbench.terminal.screen import per_joint
from exoid.workbench.terminal.showing import NOTHING_HELD_OUT


def write_result(result: Any, folder: str | Path) -> Path:
    """Write the report of a Diagnosis, Comparison, Addition or Waterfall into `folder`, made where there is none, and
    return the path of the page. OutputError where it cannot be written.
    """
    return write_report(replace(material_of_result(result), payload=result.to_json()), folder)


def material_of_result(result: Any) -> Material:
    """Return what the report of a result draws on, the recordings apart."""
    return MATERIALS[type(result).__name__](result)


def material_of_answer(title: str, found: Any, comparison: Any, truth: str = "") -> Material:
    """Return what the report of a Diagnosis draws on, the recordings apart; `comparison` is of its first model."""
    changed = comparison is not None and len(found.steps) > 1
    falls = before_and_after(comparison, found.fit) if changed else ()
    return Material(
        title=title, model=found.model, fit=found.fit, comparison=comparison, diagnosis=found, fall=found,
        pictures=falls + pictures_of(found, section="suspects") + pictures_of(comparison, section="where"),
        truth=truth, settings={"filter": found.cutoff} if found.cutoff else {}, seconds=found.seconds,
    )  # fmt: skip


def _of_answer(found: Any) -> Material:
    from exoid.diagnosis.comparison import compare_prepared

    first = None if found.given is None else compare_prepared(found.given.fit, found.given.prepared)
    return material_of_answer("What the model was missing", found, first)


def material_of_comparison(found: Any) -> Material:
    """Return what the report of a Comparison draws on, the recordings apart."""
    unseen = found.verify_rms is not None
    kind = "motion the fit has not seen" if unseen else "the fitted motion"
    held_out = "" if unseen else f" {NOTHING_HELD_OUT}"
    error = per_joint(found.verify_rms if unseen else found.rms, found.joints, found.unit)
    return Material(
        title="Model against measurement", model=found.fit.model, fit=found.fit, comparison=found,
        answer=f"The model's torque misses the measured one by {error} (RMS) on {kind}.{held_out}",
        pictures=pictures_of(found, section="where"),
    )  # fmt: skip


def material_of_addition(found: Any, name: str = "") -> Material:
    """Return what the report of an Addition draws on, the recordings apart; `name` is what was added."""
    return Material(
        title=f"Adding {name or found.model.terms[-1].name}", answer=str(found.sentence), model=found.model,
        fit=found.after, fall=found.waterfall, pictures=pictures_of(found),
    )  # fmt: skip


def _of_waterfall(found: Any) -> Material:
    return Material(
        title="The error from model to model", answer=found.stopped_because, model=found.fit.model, fit=found.fit,
        fall=found, pictures=pictures_of(found),
    )  # fmt: skip


MATERIALS: Mapping[str, Callable[[Any], Material]] = MappingProxyType({
    "Diagnosis": _of_answer, "Comparison": material_of_comparison, "Addition": material_of_addition,
    "Waterfall": _of_waterfall,
})  # fmt: skip
