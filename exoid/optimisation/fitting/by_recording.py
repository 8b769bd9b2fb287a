"""Trust in numbers: every parameter from every recording alone, with intervals, and whether they agree.

A recording that excites a parameter gives it a short interval. Where the intervals of several contradict each other the
model is wrong in a way that differs between recordings, and the interval of the joint fit, which only knows noise, is
too short: `scatter` is what the recordings say of it. Agreement is tested by Cochran's Q against chi-squared, with the
variances that are valid under autocorrelated residuals; the scatter between recordings is that of DerSimonian and Laird
(1986).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.ground.errors import ExoidError
from exoid.ground.figures import figure_style, new_figure
from exoid.ground.frames import pandas
from exoid.ground.html import picture, table
from exoid.ground.thresholds import Threshold
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.solve import solve_huber
from exoid.optimisation.linear.uncertainty import covariance
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

STRICT: Threshold = 0.01
"""probability, shared out over all parameters: recordings that contradict each other by chance"""
USEFUL: Threshold = 1.0
"""half-interval of a recording over the joint value: one that says nothing would be compared"""
NORMAL = 1.96
ADVICE = {
    "Phi": "faster motion of both joints, over more of the range, in every recording",
    "coulomb": "slow motion in both directions, with few reversals",
    "viscous": "constant speeds in both directions, slow and fast",
}
"""What settles a parameter, by the beginning of its name."""


@dataclass(frozen=True)
class Row:
    """One parameter: its `unit`, `together` (value, half-width) of the joint fit, `alone` (R, 2) of each recording (NaN
    where it cannot tell), `p_value` of agreement (None where fewer than two recordings can tell), `scatter` between
    recordings as a standard deviation, and what to record (`advice`, empty where nothing is in doubt).
    """

    name: str
    unit: str
    together: tuple[float, float]
    alone: tuple[tuple[float, float], ...]
    p_value: float | None
    scatter: float
    verdict: str
    advice: str


@dataclass(frozen=True, eq=False)
class ByRecording:
    """Parameter times recording: `rows`, one per parameter, over the `recordings`."""

    recordings: tuple[str, ...]
    rows: tuple[Row, ...]

    def trusted(self) -> tuple[str, ...]:
        """Return the names of the parameters on which the recordings agree."""
        return tuple(row.name for row in self.rows if row.verdict == "agree")

    def __repr__(self) -> str:
        head = ("parameter", "unit", "together", *self.recordings, "verdict")
        cells = [head, *(self.cells(row) for row in self.rows)]
        widths = [max(len(line[k]) for line in cells) for k in range(len(head))]
        return "\n".join("  ".join(cell.ljust(w) for cell, w in zip(line, widths, strict=True)) for line in cells)

    def _repr_html_(self) -> str:
        rows = table(("parameter", "unit", "together", *self.recordings, "verdict"), map(self.cells, self.rows))
        return rows + picture(self.plot(), "Every parameter from every recording alone, with its interval")

    def cells(self, row: Row) -> tuple[str, ...]:
        """Return one line of the table as texts."""
        said = row.verdict if row.p_value is None else f"{row.verdict} (p = {row.p_value:.2g})"
        return (row.name, row.unit, _interval(row.together), *map(_interval, row.alone), said)

    def to_frame(self) -> pd.DataFrame:
        """Return one row per parameter: value and 95 % half-width together and of each recording, p-value, verdict."""
        out = {}
        for row in self.rows:
            cells: dict[tuple[str, str], Any] = {
                ("together", "value"): row.together[0],
                ("together", "±"): row.together[1],
            }
            for name, (value, half) in zip(self.recordings, row.alone, strict=True):
                cells[name, "value"], cells[name, "±"] = value, half
            cells["agreement", "p"], cells["agreement", "scatter"] = row.p_value, row.scatter
            cells["agreement", "verdict"] = row.verdict
            out[row.name] = cells
        return pandas().DataFrame.from_dict(out, orient="index")

    def to_json(self) -> dict[str, Any]:
        """Return everything in plain types; what a recording cannot tell is None."""
        return {
            row.name: {
                "unit": row.unit,
                "together": _json(row.together),
                "recordings": {n: _json(x) for n, x in zip(self.recordings, row.alone, strict=True)},
                "p_value": row.p_value,
                "scatter": row.scatter,
                "verdict": row.verdict,
                "advice": row.advice,
            }
            for row in self.rows
        }

    def plot(self) -> Figure:
        """Draw each parameter with the intervals of every recording."""
        names = ["together", *self.recordings]
        with figure_style():
            figure = new_figure(7.0, len(self.rows) * (0.9 + 0.2 * len(names)))
            for axes, row in zip(np.ravel(figure.subplots(len(self.rows), 1)), self.rows, strict=True):
                for place, (value, half) in enumerate((row.together, *row.alone)):
                    if math.isfinite(half) and math.isfinite(value):
                        axes.errorbar(value, -place, xerr=half, fmt="o" if place else "s", color=f"C{int(place > 0)}")
                axes.set_yticks([-k for k in range(len(names))], names)
                axes.set_title(f"{row.name} [{row.unit}]: {row.verdict}")
        return figure


def by_recording(fit: Fit) -> ByRecording:
    """Return every linear parameter of `fit` from every recording alone, at the shape parameters of the joint fit."""
    data = fit.data
    groups = [np.flatnonzero(data.groups == k) for k in range(len(fit.recordings))]
    alone = [_alone(fit, group) for group in groups]
    level = STRICT / len(data.names)
    rows = []
    for k, (name, unit) in enumerate(zip(data.names, data.units, strict=True)):
        estimate = fit.estimates[k]
        together = float(estimate.value), 0.5 * float(estimate.high - estimate.low)
        rows.append(_row(name, unit, together, [(float(v[k]), float(h[k])) for v, h in alone], level))
    return ByRecording(fit.recordings, tuple(rows))


def _alone(fit: Fit, at: np.ndarray) -> tuple[Float, Float]:
    """Return values and 95 % half-widths (P,) from the samples `at` alone; NaN and infinite where they cannot tell."""
    data = fit.data
    part = LinearData(
        data.columns[:, at], data.tau[:, at], np.zeros(at.size, int), data.names, data.units, data.use[:, at]
    ).weighted(fit.weight)
    nothing = np.full(len(data.names), np.nan), np.full(len(data.names), np.inf)
    if int(part.use.sum()) <= 2 * len(data.names):
        return nothing
    try:
        value = solve_huber(part, fit.limits)
        half = covariance(part.columns, part.residual(value), fit.limits, part.groups, factor=part.factor).half_widths()
    except (ExoidError, np.linalg.LinAlgError):
        return nothing
    return np.where(np.isfinite(half), value, np.nan), half


def _row(
    name: str, unit: str, together: tuple[float, float], alone: Sequence[tuple[float, float]], level: float
) -> Row:
    from scipy.stats import chi2

    useful = [(v, h) for v, h in alone if math.isfinite(h) and h <= USEFUL * max(abs(together[0]), together[1])]
    advice = next((text for start, text in ADVICE.items() if name.startswith(start)), "more motion of that joint")
    if len(useful) < 2:
        told = "one recording determines it" if useful else "no recording determines it alone"
        return Row(name, unit, together, tuple(alone), None, 0.0, told, f"record more: {advice}")
    value, half = np.array(useful).T
    weight = (NORMAL / np.maximum(half, 1e-300)) ** 2
    mean = float(weight @ value / weight.sum())
    q = float(weight @ (value - mean) ** 2)
    free = value.size - 1
    p = float(chi2.sf(q, free))
    between = max(0.0, q - free) / max(float(weight.sum() - (weight**2).sum() / weight.sum()), 1e-300)
    agree = p >= level
    said = "agree" if agree else "contradict"
    odd = f"trust no more digits than the scatter of {math.sqrt(between):.2g} {unit} leaves; "
    remedy = (
        "" if agree else f"{odd}a missing effect or a change between recordings moves it: exoid discover; then {advice}"
    )
    return Row(name, unit, together, tuple(alone), p, math.sqrt(between), said, remedy)


def _interval(pair: tuple[float, float]) -> str:
    value, half = pair
    return f"{value:.4g} ± {half:.2g}" if math.isfinite(half) and math.isfinite(value) else "-"


def _json(pair: tuple[float, float]) -> dict[str, float] | None:
    value, half = pair
    return {"value": value, "low": value - half, "high": value + half} if math.isfinite(half) else None
