"""Runs written in the format of IOHprofiler, which IOHanalyzer and `iohinspector` read.

    <folder>/<optimiser>/IOHprofiler_f1_huber.json            what was run, the best of each run
    <folder>/<optimiser>/data_f1_huber/IOHprofiler_f1_DIM8.dat    evaluations and best so far, one block per run

(of motions the criterion stands in the place of huber). `raw_y` is the relative distance above the certified optimum,
or above the best motion known, so that targets mean the same on every problem. Source:
Doerr, Wang, Ye, van Rijn, Bäck, "IOHprofiler", arXiv:1810.05281; the format is described at iohprofiler.github.io.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.ground.extras import version_of
from exoid.ground.files import write_whole

if TYPE_CHECKING:
    from exoid.optimisation.contest.problem import Outcome
    from exoid.optimisation.contest.subject import ContestSubject
    from exoid.optimisation.fitting.settings import Search

LARGEST = 1e308
"""Stands for a fitness that was infinite, which the format cannot say."""


def write_logs(
    contest: ContestSubject, searches: Mapping[str, Search], outcomes: Mapping[str, Iterable[Outcome]],
    folder: str | Path,
) -> Path:  # fmt: skip
    """Write every run of `outcomes` {name of the search: runs} on `contest` below `folder` and return it."""
    target = Path(folder)
    size, function = contest.size, contest.function
    for name, runs in outcomes.items():
        data = f"data_f1_{function}/IOHprofiler_f1_DIM{size}.dat"
        blocks = "".join(_block(run) for run in runs)
        write_whole(target / name / data, blocks)
        about = _about(contest, name, searches[name], runs, size, data)
        write_whole(target / name / f"IOHprofiler_f1_{function}.json", json.dumps(about, indent=1))
    return target


def _block(run: Outcome) -> str:
    """Return the lines of one run: a head, every improvement, and the last evaluation."""
    rows = list(zip(run.found_at.astype(int), np.minimum(run.gaps, LARGEST), strict=True))
    if rows[-1][0] < run.evaluations:
        rows.append((run.evaluations, rows[-1][1]))
    return "evaluations raw_y\n" + "".join(f"{count} {gap:.17g}\n" for count, gap in rows)


def _about(
    contest: ContestSubject, name: str, search: Search, runs: Iterable[Outcome], size: int, data: str
) -> dict[str, Any]:
    return {
        "version": "0.3.5",
        "suite": "exoid",
        "function_id": 1,
        "function_name": contest.function,
        "maximization": False,
        "algorithm": {"name": name, "info": repr(search)},
        "experiment_attributes": [
            {"problem": contest.name},
            {"exoid": _exoid()},
            {"individuals": str(contest.individuals)},
            {"generations": str(contest.generations)},
            {"optimum": repr(contest.best)},
        ],
        "attributes": ["evaluations", "raw_y"],
        "scenarios": [
            {
                "dimension": size,
                "path": data,
                "runs": [
                    {
                        "instance": 1,
                        "evals": run.evaluations,
                        "best": {
                            "evals": int(run.found_at[-1]),
                            "y": min(run.gap, LARGEST),
                            "x": run.x.tolist(),
                        },
                    }
                    for run in runs
                ],
            }
        ],
    }


def _exoid() -> str:
    return version_of("exoid") or "not installed"
