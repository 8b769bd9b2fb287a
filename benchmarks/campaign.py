"""What an engine costs per job, and what a second worker gains.

    python benchmarks/campaign.py                 overhead of each engine; efficiency of two workers on blind trials
    python benchmarks/campaign.py --trials 12

Overhead: jobs that do next to nothing, so that what is left is the engine, the process of the worker, and the answer on
disk. Efficiency: the same blind trials by one worker and by two, as time of one over twice the time of two.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from exoid.apps.campaign.engines.cell import in_cell  # noqa: E402 - the repository must be on the path first
from exoid.apps.campaign.engines.dask import dask  # noqa: E402
from exoid.apps.campaign.engines.local import local  # noqa: E402
from exoid.apps.campaign.engines.slurm import slurm  # noqa: E402
from exoid.apps.campaign.plan import read_plan  # noqa: E402
from exoid.apps.campaign.run import run_campaign  # noqa: E402
from exoid.ground.engines.engine import Engine, completed  # noqa: E402


def overhead(engine: Engine, jobs: int) -> float:
    """Return the seconds per job that does nothing, after one job for each worker to start it."""
    list(completed(engine, in_cell, range(2 * engine.workers()), lambda k: ("math:fsum", [k])))
    began = time.perf_counter()
    answers = completed(engine, in_cell, range(jobs), lambda k: ("math:fsum", [k]))
    assert all(future.result()["status"] == "done" for _, future in answers)
    return (time.perf_counter() - began) / jobs


def trials(count: int, workers: int, folder: Path) -> float:
    """Return the seconds that `workers` need for `count` blind trials, started and compiled before."""
    plan = folder / "plan.toml"
    plan.write_text(f'verb = "blind"\n[blind]\nkinds = ["none"]\nseeds = {-(-count // 6)}\nfirst = 100\n', "utf-8")
    engine = local(workers)
    trial = "exoid.apps.campaign.trials.trial:run_case"
    warm = completed(engine, in_cell, range(workers), lambda k: (trial, f"none/nothing/{k}"))
    assert all(future.result()["status"] == "done" for _, future in warm)
    began = time.perf_counter()
    found = run_campaign(read_plan(plan), folder / str(workers), engine)
    seconds = time.perf_counter() - began
    engine.close(True)
    assert set(found.counts) == {"done"}
    return seconds / len(found.rows)


def main() -> int:
    text, _, rest = (__doc__ or "").partition("\n\n")
    parser = argparse.ArgumentParser(
        description=text, epilog=rest, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--jobs", type=int, default=2000, help="jobs that do nothing")
    parser.add_argument("--trials", type=int, default=6, help="blind trials for the efficiency; 0: none")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        engines = (lambda: local(2), lambda: dask("local", 2), lambda: slurm("local", Path(place) / "slurm", 2))
        for make, jobs in zip(engines, (given.jobs, given.jobs, min(given.jobs, 20)), strict=True):
            engine = make()
            before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            cost = overhead(engine, jobs)
            grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
            engine.close(True)
            print(f"{engine.name}: {1e3 * cost:.2f} ms per job, peak memory +{grown / 1024:.0f} MB over {jobs} jobs")
        if given.trials:
            one, two = (trials(given.trials, workers, Path(place)) for workers in (1, 2))
            print(f"blind trials: {one:.1f} s each with one worker, {two:.1f} s with two: {one / two:.2f} times faster")
            print(f"{3600 / two:.0f} an hour")
    return 0


if __name__ == "__main__":
    sys.exit(main())
