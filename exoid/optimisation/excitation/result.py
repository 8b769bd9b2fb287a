"""Result of a design: the motion, its criterion, its distance from the limits, and the precision it promises."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from exoid.ground.frames import pandas
from exoid.ground.html import code, picture, table
from exoid.ground.plain import AsJson, by_name
from exoid.ground.ties import least_of
from exoid.measurement.trajectories.extremes import Use
from exoid.measurement.trajectories.trajectory import Fourier
from exoid.measurement.trajectories.trajectory_file import trajectory_content
from exoid.optimisation.excitation.criteria import Noise
from exoid.optimisation.excitation.plots import motion_figure
from exoid.symbolic.model import Model

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

POINTS = 601
"""Instants of one period that are drawn."""
MEANING = {
    "condition": "cond(Ȳ)",
    "d_optimal": "-log det of the information",
    "worst": "worst relative standard deviation",
}


@dataclass(frozen=True, eq=False)
class DesignedMotion(AsJson):
    """A motion that a search ended with: its criterion `value`, `evaluations` (IPOPT: iterations), its last word."""

    name: str
    trajectory: Fourier
    value: float
    evaluations: int
    seconds: float
    status: str

    def _json(self) -> dict[str, Any]:
        return {
            "name": self.name, "value": self.value, "evaluations": self.evaluations, "seconds": self.seconds,
            "status": self.status,
        }  # fmt: skip


@dataclass(frozen=True)
class Precision(AsJson):
    """Expected precision of one number: standard `deviation` in `unit`, and `relative` to its size (None: it has
    none).
    """

    name: str
    value: float
    unit: str
    deviation: float
    relative: float | None


@dataclass(frozen=True, eq=False)
class Excitation(AsJson):
    """A motion and its evaluation.

    `value` is what was minimised; `condition` is cond(Ȳ), `log_det` that of the information in `duration` s under
    `noise`. `candidates` are all that was found, best known: no optimum is claimed. `uses` are the limits with bounds
    proven for all times, `precision` the predicted standard deviations at `numbers`. `creeping` (J,) is the
    share of time in which a joint is slow enough to stick, `condition_moving` is cond(Ȳ) without it.
    """

    best_known: ClassVar[bool] = True

    model: Model
    trajectory: Fourier
    criterion: str
    value: float
    condition: float
    log_det: float
    candidates: tuple[DesignedMotion, ...]
    chosen: str
    uses: tuple[Use, ...]
    precision: tuple[Precision, ...]
    noise: Noise
    duration: float
    numbers: str
    offsets: str
    rest: bool
    backend: str
    seed: int
    creeping: tuple[float, ...] = (0.0, 0.0)
    condition_moving: float = float("nan")
    cautions: tuple[str, ...] = ()
    seconds: float = field(default=0.0, repr=False)

    @property
    def _content(self) -> dict[str, Any]:
        return trajectory_content(self.trajectory, self.model.joint_names)

    @property
    def feasible(self) -> bool:
        """True if every limit is proven to hold at all times."""
        return all(use.holds for use in self.uses)

    @property
    def informative(self) -> bool:
        """True if the motion informs about every number."""
        return all(math.isfinite(number.deviation) for number in self.precision)

    def __repr__(self) -> str:
        period, count = self.trajectory.period, self.trajectory.sine.shape[1]
        lines = [f"Motion of {period:g} s with {count} harmonics, {self.chosen}: cond(Ȳ) = {self.condition:.2f}"]
        if self.criterion != "condition":
            lines.append(f"  {MEANING[self.criterion]}: {self.value:.5g}")
        for candidate in self.candidates:
            status = f", {candidate.status}" if candidate.status else ""
            effort = f"{candidate.evaluations} steps, {candidate.seconds:.1f} s{status}"
            lines.append(f"  {candidate.name:<10} {candidate.value:10.4f}  {effort}")
        tightest = least_of(self.uses, lambda use: -use.share, 1.0)
        word = "inside all limits at all times" if self.feasible else "OUTSIDE its limits"
        lines.append(
            f"  {word}; most used: {tightest.joint} {tightest.quantity}, {100 * tightest.share:.2f} % of the limit"
        )
        known = [number for number in self.precision if number.relative is not None]
        if known:
            worst = least_of(known, lambda one: -(one.relative or 0.0))
            lines.append(
                f"  worst known after {self.duration:g} s: {worst.name}, ±{100 * (worst.relative or 0.0):.3g} % (1 σ; "
                f"noise: {self.noise})"
            )
        return "\n".join(lines + [f"  caution: {text}" for text in self.cautions])

    def _repr_html_(self) -> str:
        rows = [(p.name, p.value, p.unit, p.deviation, p.relative) for p in self.precision]
        head = ("number", "value assumed", "unit", "standard deviation", "relative")
        return code(repr(self)) + picture(self.plot(), "Angles, velocities and accelerations") + table(head, rows)

    def to_frame(self) -> pd.DataFrame:
        """Return one row per number of the model: value assumed, unit, predicted standard deviation."""
        rows = [(p.value, p.unit, p.deviation, p.relative) for p in self.precision]
        columns = ["value", "unit", "deviation", "relative"]
        return pandas().DataFrame(rows, index=[p.name for p in self.precision], columns=columns)

    def plot(self) -> Figure:
        """Draw angles, velocities and accelerations of both joints with their limits, as the paper's Fig. 4."""
        return motion_figure(
            f"cond(Ȳ) = {self.condition:.1f}, {self.chosen}",
            self.trajectory.at(np.linspace(0.0, self.trajectory.period, POINTS)),
            {(use.joint, use.quantity): use.limit for use in self.uses},
        )

    def _json(self) -> dict[str, Any]:
        return {
            "model": self.model.name, "criterion": self.criterion, "value": self.value, "condition": self.condition,
            "condition_moving": self.condition_moving, "creeping": self.creeping, "log_det": self.log_det,
            "chosen": self.chosen, "best_known": self.best_known, "feasible": self.feasible,
            "trajectory": self._content, "candidates": self.candidates, "limits": self.uses,
            "precision": by_name(self.precision), "noise": self.noise, "duration": self.duration,
            "numbers": self.numbers, "offsets": self.offsets, "rest": self.rest, "seed": self.seed,
            "cautions": self.cautions, "seconds": self.seconds,
        }  # fmt: skip
