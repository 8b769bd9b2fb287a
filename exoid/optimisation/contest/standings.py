"""Result of a comparison of optimisers: distance to the proven optimum, time, and certainty."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.ground.frames import pandas
from exoid.ground.html import lines, picture, table
from exoid.ground.plain import AsJson
from exoid.optimisation.contest.ioh_log import write_logs
from exoid.optimisation.contest.plots import Entrant, Goal, contest_figure
from exoid.optimisation.contest.problem import Outcome
from exoid.optimisation.contest.runtime import Difference, Runtime, differences, expected_runtime, quartiles
from exoid.optimisation.contest.subject import ContestSubject
from exoid.optimisation.fitting.settings import Search
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

ROUNDING = 1e-14
"""Gaps below this are rounding: they count as equal."""
LARGEST = 1e300
"""Stands for a gap that is infinite: two of them tie."""
REFERENCES = ("nfo_whitened", "nfo")
"""Whom the others are tested against, the first that competes."""


@dataclass(frozen=True, eq=False)
class Rivals(AsJson):
    """All runs: `outcomes` {name: one Outcome per seed}; `resumed` of them were on disk already."""

    contest: ContestSubject
    searches: Mapping[str, Search]
    outcomes: Mapping[str, tuple[Outcome, ...]] = field(repr=False)
    seconds: float
    resumed: int

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of the first populations."""
        return tuple(run.seed for run in next(iter(self.outcomes.values())))

    @property
    def reference(self) -> str:
        """Whom the others are tested against."""
        return next((name for name in REFERENCES if name in self.outcomes), next(iter(self.outcomes)))

    def gaps(self, name: str) -> Float:
        """Return the relative gap at the end of each run (R,)."""
        return np.array([run.gap for run in self.outcomes[name]])

    def hits(self, name: str, targets: Float) -> Float:
        """Return the evaluations (R, T) at which each run came to each target, ∞ where it did not."""
        return np.array([[run.hit(target) for target in targets] for run in self.outcomes[name]])

    def convergence(self, name: str) -> tuple[Float, Float]:
        """Return evaluations (G,), one per generation, and the best gap of each run after them (R, G)."""
        grid = np.arange(1, self.contest.generations + 1, dtype=np.float64) * self.contest.individuals
        return grid, np.array([run.at(grid) for run in self.outcomes[name]])

    @cached_property
    def runtimes(self) -> Mapping[str, tuple[Runtime, ...]]:
        """ERT of each optimiser to each of the contest's targets, with bootstrap intervals."""
        found = {}
        for name in self.outcomes:
            hits = self.hits(name, np.array(self.contest.targets))
            # The same resampled seeds for every optimiser and target.
            found[name] = tuple(
                expected_runtime(hits[:, k], self.contest.budget, target, np.random.default_rng(self.seeds[0]))
                for k, target in enumerate(self.contest.targets)
            )
        return found

    @cached_property
    def differences(self) -> tuple[Difference, ...]:
        """Every optimiser against `reference`: the gap at the end, and the evaluations to the last target."""
        last = np.array(self.contest.targets[-1:])
        gaps = {name: np.clip(self.gaps(name), ROUNDING, LARGEST) for name in self.outcomes}
        # A run that never came there is slower than any that did, by however much.
        slow = {n: np.minimum(self.hits(n, last)[:, 0], 2.0 * self.contest.budget) for n in self.outcomes}
        return differences(gaps, self.reference, "gap at the end") + differences(
            slow, self.reference, f"evaluations to {last[0]:.0e}"
        )

    def rows(self) -> list[tuple[Any, ...]]:
        """Return per optimiser: median gap and quartiles, success at the last target, ERT and interval, seconds, p."""
        p = {d.first: d.p_holm for d in self.differences if d.question == "gap at the end"}
        found = []
        for name, runs in self.outcomes.items():
            low, middle, high = quartiles(self.gaps(name))
            last = self.runtimes[name][-1]
            seconds = float(np.median([run.seconds for run in runs]))
            found.append(
                (name, middle, low, high, last.hits, last.runs, last.ert, last.low, last.high, seconds, p.get(name))
            )
        return sorted(found, key=lambda row: (row[6], row[1]))

    def __repr__(self) -> str:
        contest, lines_ = self.contest, []
        lines_.append(
            f"Rivals on {contest.name}: {len(self.seeds)} seeds, {contest.individuals} × {contest.generations}"
            f" evaluations, {contest.standard}"
        )
        width = max(len(name) for name in self.outcomes)
        for name, middle, low, high, hits, runs, ert, *_ in self.rows():
            near = f"{hits} of {runs} within {contest.targets[-1]:g}" + (f", ERT {ert:.0f}" if np.isfinite(ert) else "")
            lines_.append(f"  {name:<{width}}  median gap {middle:.1e} ({low:.1e} to {high:.1e}), {near}")
        return "\n".join(lines_)

    def _repr_html_(self) -> str:
        head = (
            "optimiser", "median gap", "25 %", "75 %", f"within {self.contest.targets[-1]:g}", "runs", "ERT",
            "95 % low", "95 % high", "s per run", "p (Holm)",
        )  # fmt: skip
        title = f"{self.contest.name}: {len(self.seeds)} seeds, {self.contest.budget} evaluations each"
        return table(head, self.rows(), title) + lines(self.contest.standard) + picture(self.plot(), title)

    def to_frame(self) -> pd.DataFrame:
        """Return one row per optimiser and target: ERT with interval, hits, runs, success rate."""
        rows = [
            (name, r.target, r.ert, r.low, r.high, r.hits, r.runs, r.success)
            for name, all_ in self.runtimes.items()
            for r in all_
        ]
        columns = ["optimiser", "target", "ert", "low", "high", "hits", "runs", "success"]
        return pandas().DataFrame(rows, columns=columns)

    @property
    def _about(self) -> Mapping[str, Any]:
        return self.contest.about()

    @property
    def _optimisers(self) -> dict[str, Any]:
        """JSON of each optimiser."""
        return {
            name: {
                "settings": repr(self.searches[name].optimiser),
                "whitened": self.searches[name].whitened,
                "gaps": self.gaps(name),
                "median_gap": quartiles(self.gaps(name))[1],
                "seconds": np.median([run.seconds for run in runs]),
                "runtimes": self.runtimes[name],
            }
            for name, runs in self.outcomes.items()
        }

    def write_logs(self, folder: str | Path) -> Path:
        """Write all runs into `folder` in the format of IOHprofiler; return the folder."""
        return write_logs(self.contest, self.searches, self.outcomes, folder)

    def plot(self) -> Figure:
        """Draw convergence to the optimum, the share of targets solved over time, and ERT over the target."""
        entrants = [
            Entrant(
                name,
                *self.convergence(name),
                self.hits(name, self.contest.drawn),
                self.runtimes[name],
            )
            for name in self.outcomes
        ]
        goal = Goal(self.contest.goal, self.contest.drawn, self.contest.floor)
        return contest_figure(entrants, self.contest.budget, goal)

    def figures(self) -> list[tuple[str, str, Figure]]:
        """Return the figures for a report: (title, sentence that stands for it, figure)."""
        alt = (
            f"Left: distance above the {self.contest.goal} over evaluations, median and quartiles of each optimiser. "
            "Middle: share of runs and targets solved. Right: expected running time to each target."
        )
        return [("How near, how fast", alt, self.plot())]

    def _json(self) -> dict[str, Any]:
        return {
            "problem": self.contest.name, "individuals": self.contest.individuals,
            "generations": self.contest.generations, "seeds": self.seeds, "delta": self.contest.delta,
            "optimum": self.contest.best, "goal": self.contest.goal, "certificate": self.contest.certificate,
            "about": self._about, "reference": self.reference, "optimisers": self._optimisers,
            "differences": self.differences, "resumed": self.resumed, "seconds": self.seconds,
        }  # fmt: skip
