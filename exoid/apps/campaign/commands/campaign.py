"""`exoid campaign`: many recordings or simulated legs, here, on a Dask cluster or Slurm; one table, one page."""

from __future__ import annotations

import argparse
import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from exoid.ground.output import check_folder
from exoid.workbench.command_line.files import write_json
from exoid.workbench.command_line.options import whole_number
from exoid.workbench.terminal.progress import progress
from exoid.workbench.terminal.screen import Screen, warn

if TYPE_CHECKING:
    from exoid.apps.campaign.plan import Plan
    from exoid.apps.campaign.run import Campaign
    from exoid.ground.engines.engine import Engine

GROUP = "run"
HELP = """run a command over many recordings or simulated legs: one table, one page

exoid campaign plan.toml --out fleet --dry-run     what would be run
exoid campaign plan.toml --out fleet               on all cores of this machine
exoid campaign plan.toml --out fleet --dask tcp://scheduler:8786
exoid campaign plan.toml --out fleet --slurm short
what was stopped goes on where it was: give the same command again"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("plan", metavar="PLAN.toml", help="which recordings, what to ask (docs/campaigns.md)")
    group = parser.add_argument_group("where it runs")
    engines = group.add_mutually_exclusive_group()
    engines.add_argument("--dask", metavar="ADDRESS", help="a Dask scheduler's address or file; local: started here")
    engines.add_argument("--slurm", metavar="PARTITION", help="a Slurm partition; local: submitit on this machine")
    group.add_argument("--jobs", metavar="N", type=whole_number, default=0, help="jobs at a time (0: one per core)")
    group.add_argument("--dry-run", action="store_true", help="print the jobs and run none")
    group = parser.add_argument_group("output")
    group.add_argument("--out", metavar="DIR", required=True, help="folder of answers, tables and page; also read")
    group.add_argument("--json", metavar="FILE", help="write the result as JSON to FILE; - means standard output")
    group.add_argument("--seed", metavar="N", type=whole_number, default=None, help="seed of every job (the plan's)")
    group.add_argument("--quiet", action="store_true", help="no progress and no tables, only warnings and errors")


def run(args: argparse.Namespace) -> int:
    """Run and show; status 1 where jobs crashed, were late, or were refused."""
    from exoid.apps.campaign.plan import read_plan

    plan = read_plan(args.plan)
    if args.seed is not None:
        plan = replace(plan, jobs=tuple(replace(job, seed=args.seed) for job in plan.jobs))
    screen = Screen.of(args)
    for note in plan.notes:
        screen.say(note, "warn")
    if args.dry_run:
        rows = [(job.name, job.verb, len(job.recordings), len(job.verify), job.model or "") for job in plan.jobs]
        screen.table(f"{len(rows)} jobs", ("job", "command", "to fit", "held out", "model"), rows)
        if args.json:
            write_json(args.json, {"schema": "exoid.campaign_plan/1", "jobs": plan.jobs})
        return 0
    check_folder(args.out)
    from exoid.apps.campaign.run import run_campaign

    with _engine(args, plan) as engine, progress(engine.name, quiet=args.quiet) as report:
        found = run_campaign(plan, args.out, engine, report)
    _show(screen, found, engine, Path(args.out))
    if args.json:
        write_json(args.json, {"schema": "exoid.campaign/1", "jobs": len(found.rows), **found.to_json()})
    return 0 if set(found.counts) <= {"done"} else 1


def _engine(args: argparse.Namespace, plan: Plan) -> Engine:
    if args.dask:
        from exoid.apps.campaign.engines.dask import dask

        return dask(args.dask, args.jobs)
    if args.slurm:
        from exoid.apps.campaign.engines.slurm import slurm

        return slurm(args.slurm, Path(os.path.realpath(args.out)) / "slurm", args.jobs, plan.timeout)
    from exoid.apps.campaign.engines.local import local

    return local(args.jobs)


def _show(screen: Screen, found: Campaign, engine: Engine, folder: Path) -> None:
    from exoid.apps.campaign.plan import BLIND
    from exoid.apps.campaign.pooled import has_statsmodels
    from exoid.apps.campaign.table import blind_lines, has_parquet, unreadable

    rows = found.table
    if len(rows) <= 60:
        heads = ("job", "status", "verdict", "effects", "reason")
        screen.table("", heads, [[str(row[head])[:200] for head in heads] for row in rows])
    if found.plan.verb == BLIND:
        from exoid.apps.campaign.trials.count import HEADS, counted, describe_miss, right

        lines = blind_lines(found.rows)
        screen.table("", HEADS, counted(lines))
        for line in lines:
            if not right(line):
                screen.say(describe_miss(line))
    parts = ", ".join(f"{count} {status}" for status, count in sorted(found.counts.items()))
    kept = f", {found.kept} of them from before" if found.kept else ""
    screen.say(f"{len(rows)} jobs: {parts}{kept}; {engine.name}, {found.seconds:.0f} s")
    for event in found.events:
        warn(event)
    if away := found.counts.get("away"):
        what = "recordings that could not be reached: give the same command again when they are there"
        warn(f"{away} jobs wait for {what}" if away > 1 else f"1 job waits for {what}")
    if unread := unreadable(found.rows):
        screen.say(f"left out, since they cannot be read: {len(unread)}; why: {folder / 'unreadable.csv'}", "warn")
    if found.plan.device and not has_statsmodels():
        screen.say("numbers across devices need statsmodels: pip install 'exoid[campaign]'", "faint")
    if not has_parquet():
        screen.say("tables are CSV only; Parquet needs pyarrow: pip install 'exoid[parquet]'", "faint")
    screen.say(f"table: {folder / 'table.csv'}")
    screen.say(f"page: {folder / 'index.html'}")
