"""The work on one job: the command itself, in this process, on files it sees or on bytes it was sent."""

from __future__ import annotations

import base64
import contextlib
import io
import tempfile
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from exoid.apps.campaign.store import CHANGED, AwayError
from exoid.apps.campaign.verb import verb_of
from exoid.ground.errors import refused
from exoid.ground.files import sha256_file
from exoid.measurement.reading.sources import noting

ROLES = ("recordings", "verify")
ATTEMPTS, PAUSE = 3, 1.0
"""Times a job is tried whose recordings cannot be reached, and seconds in between: a network folder comes back."""


class WorkError(RuntimeError):
    """A command that broke down: its traceback, for the row of the job."""


def work(task: Mapping[str, Any]) -> dict[str, Any]:
    """Return the outcome of `task` as plain data: `status` "done", "refused" or "versions", and `result` or `reason`.

    `task` has the fields of a Job; its recordings as {"path", "data"} where `data` (base64) is None for a file that
    the worker sees; the text of its model file; `report` (whether one is wanted) and the sender's `versions`.
    """
    from exoid.ground.version import versions

    here = dict(versions())
    if here != task["versions"]:
        return {"status": "versions", "reason": _differing(task["versions"], here)}
    if task["case"] is not None:
        from exoid.apps.campaign.trials.trial import run_case

        return {"status": "done", "result": _steady(run_case(task["case"])), "notes": []}
    with tempfile.TemporaryDirectory(prefix="exoid-job-") as folder:
        return _asked(task, Path(folder))


def _asked(task: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Ask the command; where a recording is away for a moment, again a little later."""
    gone = [item["away"] for role in ROLES for item in task[role] if item.get("away")]
    given = {role: [_placed(element, folder, k, role) for k, element in enumerate(task[role])] for role in ROLES}
    expected = {
        path: entry["sha256"] for role in ROLES for path, entry in zip(given[role], task[role], strict=True)
        if entry.get("sha256")
    }  # fmt: skip
    for attempt in range(ATTEMPTS):
        try:
            if gone:
                raise AwayError(gone[0])
            return _answered(task, folder, given, expected)
        except AwayError as error:
            reason = " ".join(str(error).split())
            if gone or attempt + 1 == ATTEMPTS:
                break
            time.sleep(PAUSE)
    return {"status": "away", "reason": f"{reason}; asked again when the campaign goes on", "unreadable": []}


def _answered(
    task: Mapping[str, Any], folder: Path, given: Mapping[str, list[str]], expected: Mapping[str, str]
) -> dict[str, Any]:
    """Ask the command; where it refuses, find the recordings it cannot read and ask again without them.

    AwayError unless every recording was read as `expected` {path: SHA-256}: an answer without it is one to another job.
    """
    with noting() as noted:
        status, result, said, report = _command(task, folder, given["recordings"], given["verify"])
    theirs = {path: str(item["path"]) for role in ROLES for path, item in zip(given[role], task[role], strict=True)}
    unreadable: list[dict[str, str]] = []
    if status != 2:
        _check(expected, expected, noted)
    else:
        paths = [] if verb_of(task["verb"]).alone else [path for role in ROLES for path in given[role]]
        unreadable = _unreadable(task, paths, expected)
        bad = {entry["path"] for entry in unreadable}
        left = {role: [path for path in paths if path not in bad] for role, paths in given.items()}
        if bad and left["recordings"] and bool(left["verify"]) == bool(given["verify"]):
            with noting() as noted:
                status, result, said, report = _command(task, folder, left["recordings"], left["verify"])
            _check([path for paths in left.values() for path in paths if status != 2], expected, noted)
        elif not bad and any(noted.get(path) != element for path, element in expected.items()):
            _check(expected, expected, {})
            before = status, said
            status, result, said, report = _command(task, folder, given["recordings"], given["verify"])
            _check(expected, expected, {})
            if before != (status, said):
                raise AwayError("a recording could be read only now and then")
    row: dict[str, Any] = {"unreadable": _shown(unreadable, theirs, folder)}
    lines = _shown(said, theirs, folder)
    if status == 2:
        return row | {"status": "refused", "reason": " ".join(line.strip() for line in lines)}
    if status not in (0, 1):
        raise WorkError("\n".join(lines))
    found = _steady(_shown(result, theirs, folder))
    return row | {"status": "done", "result": found, "notes": lines, "report": _shown(report, theirs, folder)}


def _check(paths: Iterable[str], expected: Mapping[str, str], noted: Mapping[str, str]) -> None:
    """Raise AwayError unless each of the `paths` was `noted` to hold what is expected, or at least does so now."""
    for path in paths:
        if path in expected and noted.get(path) != expected[path]:
            with refused(AwayError, "could not be reached ({})", path, ""):
                found = sha256_file(path)
            if found != expected[path]:
                raise AwayError(CHANGED, where=path)


def _command(
    task: Mapping[str, Any], folder: Path, recordings: Sequence[str], verify: Sequence[str]
) -> tuple[int, Any, list[str], str | None]:
    """Return the exit status of the command, its JSON, what it said on stderr, and its report."""
    from exoid.workbench.command import main

    answer, out, model = folder / "answer.json", folder / "out", folder / "model.toml"
    if task["model"] is not None:
        model.write_text(task["model"], encoding="utf-8")
    asked = verb_of(task["verb"])
    words = [task["verb"], *task["options"], *asked.words(None if task["model"] is None else str(model), recordings)]
    words += ["--json", str(answer), "--quiet", "--seed", str(task["seed"])]
    if verify:
        words += ["--verify", *verify]
    if task["report"]:
        words += ["--out", str(out)]
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        status = main(words)
    lines = [line.removeprefix("exoid: ") for line in said.getvalue().splitlines()]
    if status not in (0, 1):
        return status, None, lines, None
    page = out / "report.html"
    result = asked.answer(answer.read_text("utf-8"))
    return status, result, lines, page.read_text("utf-8") if page.is_file() else None


def _unreadable(
    task: Mapping[str, Any], paths: Sequence[str], expected: Mapping[str, str]
) -> list[dict[str, str]]:
    """Return the recordings that cannot be read, each with the reason; AwayError for one that is only away."""
    out = []
    for path in paths:
        reason, noted = _why_not(task, path)
        if path in expected and noted.get(path) != expected[path]:
            _check([path], expected, {})
            if _why_not(task, path)[0] != reason:
                raise AwayError("could be read only now and then", where=path)
        if reason:
            out.append({"path": path, "reason": reason.replace("\n", " ")})
    return out


def _why_not(task: Mapping[str, Any], path: str) -> tuple[str, dict[str, str]]:
    """Reason why a recording cannot be read, "" where it can, and what was read."""
    from exoid.ground.errors import ExoidError
    from exoid.workbench.command import verb_parser
    from exoid.workbench.command_line.inputs import load

    with noting() as noted:
        try:
            with contextlib.redirect_stderr(io.StringIO()):
                load(verb_parser(task["verb"]).parse([*task["options"], path]))
        except ExoidError as error:
            return str(error), noted
    return "", noted


def _placed(one: Mapping[str, Any], folder: Path, number: int, role: str) -> str:
    if one["data"] is None:
        return str(one["path"])
    place = folder / f"{role}_{number}"
    place.mkdir(exist_ok=True)
    path = place / Path(one["path"]).name
    path.write_bytes(base64.b64decode(one["data"]))
    return str(path)


def _shown(value: Any, theirs: Mapping[str, str], folder: Path) -> Any:
    """Return `value` with the sender's paths for the worker's (`theirs`), and without its temporary `folder`."""
    if isinstance(value, str):
        for here, there in theirs.items():
            value = value.replace(here, there)
        return value.replace(f"{folder}/", "")
    if isinstance(value, Mapping):
        return {key: _shown(item, theirs, folder) for key, item in value.items()}
    return [_shown(item, theirs, folder) for item in value] if isinstance(value, (list, tuple)) else value


def _steady(value: Any) -> Any:
    """Return `value` without times of computing: the same job gives the same bytes."""
    if isinstance(value, dict):
        return {key: _steady(item) for key, item in value.items() if key != "seconds"}
    return [_steady(item) for item in value] if isinstance(value, list) else value


def _differing(wanted: Mapping[str, str], here: Mapping[str, str]) -> str:
    names = sorted({*wanted, *here})
    pairs = [(n, wanted.get(n, "nothing"), here.get(n, "nothing")) for n in names if wanted.get(n) != here.get(n)]
    return ", ".join(f"{name} {there} here and {on} on the worker" for name, there, on in pairs)


FUNCTION = f"{work.__module__}:{work.__name__}"
"""How an engine calls it in processes of its own, whose version may be another."""
