"""Run a plan on an engine: what is there already is kept, every answer is written as it comes, the page follows."""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from exoid.apps.campaign.copies import describe_copies
from exoid.apps.campaign.engines.cell import in_cell
from exoid.apps.campaign.plan import Job, Plan
from exoid.apps.campaign.store import FINAL, AwayError, CampaignError, JobStore, job_file_name, task_of
from exoid.apps.campaign.work import FUNCTION
from exoid.ground.engines.engine import Engine, EngineError, completed, engine_of
from exoid.ground.errors import refused
from exoid.ground.files import write_whole
from exoid.ground.frames import pandas
from exoid.ground.inside import refuse_links
from exoid.ground.lock import FolderHeld, FolderLock
from exoid.ground.ours import OTHERS, is_folder_of_ours
from exoid.ground.plain import AsJson
from exoid.ground.progress import Progress, silent

if TYPE_CHECKING:
    from exoid.apps.campaign.pooled import Pooled

TABLES = ("table", "parameters", "unreadable")
OWN = ("index.html", "reports", *(f"{name}.{end}" for name in TABLES for end in ("csv", "parquet")))
"""What a campaign writes beside its answers; looked at before the work starts."""
REFRESH = 5.0
"""Seconds between two versions of the page while a campaign runs, at least."""


@dataclass(frozen=True, eq=False)
class Campaign(AsJson):
    """A campaign that has ended: its plan, a row per job in the order of the plan, and what happened on the way.

    `kept` jobs were there already, `retried` were run again after their worker was lost, `seconds` it took.
    """

    plan: Plan
    rows: tuple[dict[str, Any], ...]
    kept: int
    retried: int
    seconds: float
    events: tuple[str, ...] = ()

    @property
    def counts(self) -> dict[str, int]:
        """How many jobs ended how."""
        return dict(Counter(row["status"] for row in self.rows))

    @property
    def table(self) -> list[dict[str, Any]]:
        """A flat row per job."""
        from exoid.apps.campaign.table import table_of

        return table_of(self.plan, self.rows)

    @property
    def pooled(self) -> list[Pooled]:
        """The parameters across devices."""
        from exoid.apps.campaign.pooled import pool

        return pool(self.plan, self.rows)

    def to_frame(self) -> Any:
        """Return the table of jobs as a pandas DataFrame."""
        return pandas().DataFrame(self.table)

    def __repr__(self) -> str:
        parts = ", ".join(f"{count} {status}" for status, count in sorted(self.counts.items()))
        return f"{self.plan.name}: {len(self.rows)} jobs ({parts}), {self.kept} kept from before"

    def _json(self) -> dict[str, Any]:
        return {
            "name": self.plan.name, "verb": self.plan.verb, "status": self.counts, "kept": self.kept,
            "retried": self.retried, "events": self.events, "rows": self.table, "pooled": self.pooled,
            "seconds": self.seconds,
        }  # fmt: skip


def _refuse_others(folder: Path) -> None:
    """Refuse a folder in which the campaign would write over, or remove, what exoid did not write."""
    if is_folder_of_ours(folder) or is_folder_of_ours(folder / "jobs"):
        return
    others = [name for name in OWN if (folder / name).is_file() and not (folder / name).is_symlink()]
    if others:
        what, remedy = OTHERS.format(others[0]), "choose another folder, or remove that file"
        raise CampaignError(what, where=str(folder), remedy=remedy)


def run_campaign(
    plan: Plan, folder: str | Path, engine: Engine | Executor, progress: Progress | None = None
) -> Campaign:
    """Run what is missing of `plan` on any executor, with its answers, tables and page in `folder`.

    Raises CampaignError where another campaign works in `folder`, and for workers with other versions. Interrupted at
    any moment, it goes on where it was when it is called again.
    """
    from exoid.apps.campaign.page import write_page
    from exoid.apps.campaign.table import write_tables
    from exoid.ground.version import versions

    began, report = time.perf_counter(), progress or silent
    folder, engine = Path(folder), engine_of(engine)
    here = dict(versions())
    _refuse_others(folder)
    with _alone(folder):
        store = JobStore(folder, here)
        report(0.0, "looking at what is there already")
        for name in OWN:
            with refused(CampaignError, "cannot be written: {}", folder / name, "remove it"):
                refuse_links(folder / name, folder)
        keys, rows, bases = _at_hand(plan, store, here)
        kept, retried = sum(row is not None and row["status"] in FINAL for row in rows), 0
        missing = [k for k, row in enumerate(rows) if keys[k] and (row is None or row["status"] not in FINAL)]
        events = describe_copies(bases, plan.device)
        root = _root(plan)
        drawn = 0.0  # when the page is due

        def call(k: int) -> tuple[Any, ...]:
            task = task_of(plan.jobs[k], ships=engine.ships, report=plan.reports, versions=here, store=store)
            return FUNCTION, task, plan.timeout

        def written(running: bool) -> None:
            done = [row for row in rows if row is not None]
            if not running:
                write_tables(folder, plan, done)
            write_page(folder, plan, rows, events, running=running)

        for number, (k, future, lost) in enumerate(_answers(engine, missing, call, written), start=1):
            job = plan.jobs[k]
            row, page, note = _row(job, bases[k], future, root)
            if page is not None:
                file = folder / "reports" / f"{job_file_name(job.name, keys[k])}.html"
                write_whole(file, page, at_once=True, inside=folder)
            store.write(job, keys[k], row)
            rows[k] = row
            retried += note != ""
            for event in (note, *lost):
                if event:
                    events.append(event)
                    report(number / len(missing), event)
            report(number / len(missing), f"{job.name}: {row['status']}")
            if time.perf_counter() > drawn:
                start = time.perf_counter()
                written(True)
                took = time.perf_counter() - start
                drawn = start + max(REFRESH, 20 * took)  # a large page costs at most a twentieth of the time
        written(False)
    done, seconds = tuple(row for row in rows if row is not None), time.perf_counter() - began
    return Campaign(plan, done, kept, retried, seconds, tuple(events))


def _at_hand(
    plan: Plan, store: JobStore, here: Mapping[str, str]
) -> tuple[list[str], list[dict[str, Any] | None], list[dict[str, Any]]]:
    """Return of every job its key ("" where a recording is away), its row where there is one, and what any row of it
    says.
    """
    keys, rows, bases = list[str](), list[dict[str, Any] | None](), list[dict[str, Any]]()
    for job in plan.jobs:
        names = {role: [Path(p).name for p in getattr(job, role)] for role in ("recordings", "verify")}
        base = {"name": job.name, "key": "", "fields": dict(job.fields), "seed": job.seed, **names}
        base["versions"] = dict(here)
        try:
            key = store.key(job)
            row, base = store.read(job, key), base | {"key": key[:16]} | store.labels(job)
        except AwayError as error:
            key, row = "", base | {"status": "away", "reason": str(error).replace("\n", " ")}
        keys.append(key)
        rows.append(row)
        bases.append(base)
    return keys, rows, bases


def _answers(
    engine: Engine, missing: Sequence[int], call: Callable[[int], tuple[Any, ...]], written: Callable[[bool], object]
) -> Iterator[tuple[int, Any, list[str]]]:
    """Yield jobs with their futures and what was lost meanwhile; where the engine itself is, write what is there and
    say how to go on.
    """
    try:
        for k, future in completed(engine, in_cell, missing, call):
            yield k, future, engine.lost()  # first: what a scheduler that has gone says of a job is no answer
    except EngineError as error:
        written(False)
        remedy = "what was answered is kept: start it again, then give the same command, which goes on from there"
        raise EngineError(error.what, where=error.where, remedy=remedy) from error


def _root(plan: Plan) -> str:
    """Return the folder that all recordings of `plan` share, with its separator: no page names the folders above it."""
    folders = {os.path.dirname(os.path.realpath(path)) for job in plan.jobs for path in (*job.recordings, *job.verify)}
    try:
        return os.path.join(os.path.commonpath(folders), "")
    except ValueError:  # no recordings, or on several drives
        return ""


def _row(job: Job, base: dict[str, Any], future: Any, root: str) -> tuple[dict[str, Any], str | None, str]:
    """Return the row of a job that ended, its report, and what is to be said of how it went; paths are below `root`."""
    try:
        answer = future.result()
    except Exception as error:  # noqa: BLE001 - a worker was lost too often: that is a row, not an end
        return base | {"status": "crashed", "reason": f"{type(error).__name__}: {error}"}, None, ""
    note = "" if answer["attempts"] == 1 else f"{job.name}: its worker was lost, so it was run again"
    if answer["status"] != "done":
        status = "crashed" if answer["status"] == "failed" else answer["status"]
        return base | {"status": status, "reason": answer["reason"]}, None, note
    value = answer["value"]
    if root:
        value = json.loads(json.dumps(value).replace(json.dumps(root)[1:-1], ""))
    value = dict(value)
    if value["status"] == "versions":
        remedy = "install the same versions there (constraints.txt), then give the same command again"
        raise CampaignError(f"the worker {answer['worker']} has other versions: {value['reason']}", remedy=remedy)
    page = value.pop("report", None)
    return base | value | {"report": page is not None}, page, note


@contextlib.contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Hold `folder` for one campaign at a time."""
    other = "another campaign is running in this folder"
    with (
        refused(CampaignError, "cannot be written ({})", folder, "name a folder you may write to"),
        refused(CampaignError, other, folder, "wait for it, or give another --out", (FolderHeld,)),
    ):
        folder.mkdir(parents=True, exist_ok=True)
        lock = FolderLock(folder)
    try:
        yield
    finally:
        lock.release()
