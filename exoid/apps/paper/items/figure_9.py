"""PSO, GA and NFO on the excitation."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from exoid.apps.paper.experiments import ENTRANTS, Experiments
from exoid.apps.paper.item import FAILS, HOLDS, ItemAnswer, PaperPicture, PaperTable
from exoid.apps.paper.pictures import condition_figure
from exoid.optimisation.contest.standings import Rivals

TITLE = "PSO, GA and NFO on the excitation"
SAYS = "NFO finds a smaller condition number than PSO and GA, and sooner."
PENALTY = "_penalty"


def answer(experiments: Experiments) -> ItemAnswer:
    """Let them and two more search from the same first motions, with the infinite penalty and with rescaling."""
    found = experiments.on_motions
    best = found.contest.best
    middle = {name: float(np.median(run_conditions(found, name))) for name in found.outcomes}
    ahead = {end: _least({name: middle[name + end] for name in ENTRANTS}) for end in (PENALTY, "")}
    first = _least(middle)
    order = sorted(found.outcomes, key=lambda name: name.endswith(PENALTY))
    lines = {written_entrant(name): condition_curve(found, name) for name in order}
    marks = {"the published coefficients": experiments.published().condition, "the best motion known": best}
    said = ", ".join(f"{name.upper()} {middle[name + PENALTY]:.1f}" for name in ENTRANTS)
    right = all(name == "nfo" for name in ahead.values())
    alt = "Best condition number over evaluations of every optimiser, rescaled (lines) and with the penalty (dashes)."
    return ItemAnswer(
        f"after 20 × 400 evaluations with ∞ outside the limits, as printed, {said} (medians); best of all is "
        f"{written_entrant(first)} with {middle[first]:.1f}, the best motion known has {best:.1f}.",
        HOLDS if right else FAILS,
        "" if right else f"of the three {ahead[PENALTY].upper()} is ahead with the penalty, and {ahead[''].upper()} "
        "where motions are rescaled into the limits; no optimum is claimed, the problem is not convex",
        tables=(_table(found),),
        pictures=(
            PaperPicture("conditions", alt, condition_figure(lines, marks)),
            PaperPicture("statistics", found.figures()[0][1], found.plot()),
        ),
    )  # fmt: skip


def _least(values: Mapping[str, float]) -> str:
    return min(values, key=lambda name: values[name])


def run_conditions(found: Rivals, name: str) -> np.ndarray:
    """Return cond(Ȳ) (R,) at the end of each run."""
    return np.asarray(found.contest.best * (1.0 + found.gaps(name)))


def condition_curve(found: Rivals, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return evaluations (G,) and the best cond(Ȳ) (R, G) of each run after them."""
    counts, gaps = found.convergence(name)
    return counts, np.asarray(found.contest.best * (1.0 + gaps))


def written_entrant(name: str) -> str:
    """Return an entrant's name as it is written: "PSO, penalty" for pso_penalty."""
    base, _, variant = name.partition(PENALTY) if name.endswith(PENALTY) else (name, "", None)
    return base.upper().replace("_", "-") + ("" if variant is None else ", ∞ outside")


def _table(found: Rivals) -> PaperTable:
    rows = []
    for name, middle, low, high, hits, runs, ert, *_ in found.rows():
        values = [found.contest.best * (1.0 + gap) for gap in (middle, low, high)]
        cells = [f"{value:.1f}" if np.isfinite(value) else "∞" for value in values]
        how = "∞ outside, ±0.2 rad" if name.endswith(PENALTY) else "rescaled, ±1 rad"
        expected = f"{ert:.0f}" if np.isfinite(ert) else "–"
        who = written_entrant(name).partition(",")[0]
        rows.append((who, how, cells[0], f"{cells[1]} to {cells[2]}", f"{hits} of {runs}", expected))
    head = ("20 × 400 evaluations", "limits", "cond(Ȳ), median", "quartiles", "runs within 1 % of the best known",
            "evaluations expected until then")  # fmt: skip
    return PaperTable(head, rows, "`exoid rivals --problem excitation` does the same for 51 seeds and other criteria:")
