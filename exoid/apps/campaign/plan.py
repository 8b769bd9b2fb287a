"""The plan of a campaign: a TOML file that says which recordings belong together and what is asked about each group.

    name = "left and right legs"
    verb = "discover"                                      # any command that takes recordings
    files = "data/{device}/{side}/{date}/run_{run}.csv"    # fields taken from folders and names, beside the plan
    group = ["device", "side", "date"]                     # one job for each combination; default: all but the last,
                                                           # and every field for watch (a job per recording)
    verify = { run = ["4"] }                               # held out: by field, or how many of the last ones
    model = "models/{device}.toml"                         # optional
    timeout = 600                                          # s per job, optional
    reports = true                                         # a report per job, optional
    [options]                                              # options of the command
    cutoff = 6.0

or, for simulated legs with sealed truths,

    verb = "blind"
    [blind]
    kinds = ["single", "none"]
    seeds = 5
"""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from exoid.apps.campaign.verb import askable, verb_of
from exoid.ground.errors import ModelFileError
from exoid.ground.plain import AsJson
from exoid.ground.suggest import did_you_mean
from exoid.ground.toml_reader import Table, read_toml

BLIND = "blind"
"""Simulated legs in place of recordings; asked of `discover`."""
LARGEST_PLAN = 1_000_000
FIELD = re.compile(r"\{([A-Za-z_][A-Za-z0-9_]*)\}")


class PlanError(ModelFileError):
    """A plan that cannot be carried out."""


@dataclass(frozen=True)
class Job(AsJson):
    """One question: `verb` about `recordings` and held-out `verify`, of a group with these `fields`.

    `model` is the path of a model file or None, `options` the command's own, `case` the name of a simulated leg.
    """

    name: str
    verb: str
    fields: Mapping[str, str]
    recordings: tuple[str, ...] = ()
    verify: tuple[str, ...] = ()
    model: str | None = None
    options: tuple[str, ...] = ()
    seed: int = 0
    case: str | None = None

    def _json(self) -> dict[str, Any]:
        return {
            "name": self.name, "verb": self.verb, "fields": self.fields, "recordings": self.recordings,
            "verify": self.verify, "model": self.model, "options": self.options, "seed": self.seed,
        }  # fmt: skip


@dataclass(frozen=True)
class Plan:
    """A plan as read: its jobs, in the order of their fields, and the settings that all of them share."""

    name: str
    verb: str
    jobs: tuple[Job, ...]
    fields: tuple[str, ...]
    device: str | None
    date: str | None
    timeout: float | None = None
    reports: bool = False
    notes: tuple[str, ...] = field(default=())


def read_plan(path: str | Path) -> Plan:
    """Read a plan and find its recordings; PlanError says what is wrong, in which line, and what to do."""
    path = Path(path)
    top = read_toml(path, LARGEST_PLAN, PlanError, what="plan", remedy="see docs/campaigns.md for a plan")
    top.only(
        "name", "verb", "files", "group", "verify", "model", "timeout", "reports", "seed", "options", "device", "date",
        "blind",
    )  # fmt: skip
    verb = top.text("verb", "discover")
    known = (*askable(), BLIND)
    if verb not in known:
        remedy = did_you_mean(verb, known) or f"use one of {', '.join(known)}"
        raise top.error("verb", f"{verb!r} cannot be asked about groups of recordings", remedy)
    timeout = top.number("timeout", above=0.0) if "timeout" in top.values else None
    seed = int(top.number("seed", 0.0, above=-1.0, below=2.0**32))
    reports = top.flag("reports")
    name = top.text("name", path.stem)
    if verb == BLIND:
        jobs, fields = _blind_jobs(top, seed)
        return Plan(name, verb, jobs, fields, None, None, timeout, reports)
    jobs, fields, notes = _recorded_jobs(top, path.parent, verb, seed)
    device = _named_field(top, "device", fields, fields[0] if fields else None)
    date = _named_field(top, "date", fields, "date" if "date" in fields else None)
    return Plan(name, verb, jobs, fields, device, date, timeout, reports, notes)


def _named_field(top: Table, key: str, fields: Sequence[str], default: str | None) -> str | None:
    if key not in top.values:
        return default
    name = top.text(key)
    _known(top, key, name, "the groups", fields)
    return name


def _texts(top: Table, key: str, value: Any) -> list[str]:
    if isinstance(value, (str, int)) and not isinstance(value, bool):
        value = [value]
    if not isinstance(value, list) or not all(isinstance(v, (str, int)) and not isinstance(v, bool) for v in value):
        raise top.error(key, f"{key} is not a list of texts", f'write {key} = ["a", "b"]')
    return [str(v) for v in value]


def _recorded_jobs(
    top: Table, base: Path, verb: str, seed: int
) -> tuple[tuple[Job, ...], tuple[str, ...], tuple[str, ...]]:
    pattern = top.text("files")
    names = tuple(dict.fromkeys(FIELD.findall(pattern)))
    if re.search(r"\}\*?\{|\}\*|\*\{|[^/]\*\*|\*\*[^/]", pattern):
        raise top.error("files", "two fields or * touch each other", "put a character or a folder between them")
    found = find(base, pattern)
    if not found:
        place = os.path.realpath(base)
        raise top.error("files", "no recording matches this pattern", f"it is looked for below {place}")
    alone = verb_of(verb).alone
    group = names if alone else names[:-1]
    if "group" in top.values:
        group = tuple(_texts(top, "group", top.values["group"]))
    for name in group:
        _known(top, "group", name, "files", names)
    if alone and "verify" in top.values:
        raise top.error("verify", f"{verb} holds no recording out", "leave verify out")
    held_out = _held_out(top, names)
    options = _options(top, verb)
    model = top.text("model", "") or None
    jobs, notes = [], []
    found.sort(key=lambda item: ([_natural(item[1].get(n, "")) for n in group], _natural(str(item[0]))))
    for key, items in itertools.groupby(found, key=lambda item: tuple(item[1][n] for n in group)):
        fields = dict(zip(group, key, strict=True))
        members = list(items)
        unseen = {path for path, values in members if held_out(values, members)}
        fitted = [str(path) for path, _ in members if path not in unseen]
        label = "/".join(key) or Path(pattern).parent.name or "all"
        if alone and len(members) > 1:
            what = f"{verb} follows one recording at a time, and {label!r} has {len(members)}"
            raise top.error(
                "group", what, "give group every field of files, and files a field for every part that varies"
            )
        if not fitted:
            notes.append(f"{label}: all its recordings are held out, so there is nothing to fit")
            continue
        verify = tuple(str(path) for path, _ in members if path in unseen)
        where = None if model is None else str(base / _filled(top, model, fields))
        jobs.append(Job(label, verb, fields, tuple(fitted), verify, where, options, seed))
    if not jobs:
        raise top.error("verify", "every recording is held out, so there is nothing to fit", "hold out fewer")
    return tuple(jobs), group, tuple(notes)


def _known(top: Table, key: str, name: str, whose: str, fields: Iterable[str]) -> None:
    """Refuse a field that is not among those of files, or of the groups."""
    if name not in fields:
        raise top.error(key, f"{name!r} is not a field of {whose}", f"the fields are {', '.join(fields) or 'none'}")


def find(base: Path, pattern: str) -> list[tuple[Path, dict[str, str]]]:
    """Return the files below `base` that match `pattern`, each with its fields; a field never spans a folder."""
    if Path(pattern).is_absolute():
        base, pattern = Path(Path(pattern).anchor), str(Path(pattern).relative_to(Path(pattern).anchor))
    seen: set[str] = set()
    text = ""
    for part in re.split(r"(\{[A-Za-z_][A-Za-z0-9_]*\}|\*)", pattern):
        name = FIELD.fullmatch(part)
        if name and name[1] in seen:
            text += f"(?P={name[1]})"
        elif name:
            seen.add(name[1])
            text += f"(?P<{name[1]}>[^/]+?)"
        else:
            text += "[^/]*" if part == "*" else re.escape(part)
    shape = re.compile(text)
    globbed = FIELD.sub("*", pattern.replace("[", "[[]").replace("?", "[?]"))
    out = []
    for path in base.glob(globbed):
        match = shape.fullmatch(path.relative_to(base).as_posix())
        if match and path.is_file():
            out.append((path, dict(match.groupdict())))
    return out


def _held_out(top: Table, names: Sequence[str]) -> Any:
    """Return a function of (fields of a recording, all of its group) that says whether it is held out."""
    value = top.values.get("verify", 0)
    if isinstance(value, int) and not isinstance(value, bool) and value >= 0:

        def last(fields: Mapping[str, str], members: Sequence[tuple[Path, Mapping[str, str]]]) -> bool:
            kept = [values for _, values in members][-value:] if value else []
            return any(values is fields for values in kept)

        return last
    if not isinstance(value, dict):
        raise top.error("verify", "verify is neither a number nor a table", 'write verify = 1, or { run = ["4"] }')
    wanted = {name: set(_texts(top, "verify", given)) for name, given in value.items()}
    for name in wanted:
        _known(top, "verify", name, "files", names)
    return lambda fields, members: all(fields[name] in values for name, values in wanted.items())


def _options(top: Table, verb: str) -> tuple[str, ...]:
    """Return the options of [options] as words of a command line, after its parser has accepted them."""
    if "options" not in top.values:
        return ()
    from exoid.ground.errors import ExoidError
    from exoid.workbench.command import verb_parser

    table = top.table("options")
    words: list[str] = []
    for key, value in table.values.items():
        if key in ("json", "out", "seed", "quiet", "model", "verify", "write"):
            raise table.error(key, f"--{key} is set by the campaign itself", "leave it out of [options]")
        name = f"--{key.replace('_', '-')}"
        if isinstance(value, bool):
            words += [name] if value else []
            continue
        for one in value if isinstance(value, list) else [value]:
            if not isinstance(one, (str, int, float)):
                raise table.error(key, f"{key} is neither text nor number", "write it as on the command line")
            words.append(f"{name}={one}")
    try:
        verb_parser(verb).parse([*words, *verb_of(verb).words(None, ["recording.csv"])])
    except ExoidError as error:
        raise PlanError(error.what, where=table.place(), remedy=error.remedy) from error
    return tuple(words)


def _filled(top: Table, text: str, fields: Mapping[str, str]) -> str:
    for name in FIELD.findall(text):
        _known(top, "model", name, "the groups", fields)
    return FIELD.sub(lambda match: fields[match[1]], text)


def _natural(text: str) -> list[Any]:
    """Return a key under which run_2 comes before run_10."""
    return [(0, int(part), "") if part.isdecimal() else (1, 0, part) for part in re.split(r"(\d+)", text)]


def _blind_jobs(top: Table, seed: int) -> tuple[tuple[Job, ...], tuple[str, ...]]:
    from exoid.apps.campaign.trials.cases import KINDS, cases

    table = top.table("blind") if "blind" in top.values else top.child("blind", {})
    table.only("kinds", "seeds", "first", "only")
    kinds = _texts(table, "kinds", table.values.get("kinds", list(KINDS)))
    for kind in kinds:
        if kind not in KINDS:
            raise table.error("kinds", f"there is no kind {kind!r}", did_you_mean(kind, KINDS) or ", ".join(KINDS))
    seeds = int(table.number("seeds", 1.0, above=0.0, below=1e6))
    first = int(table.number("first", float(seed), above=-1.0, below=2.0**31))
    only = table.text("only", "") if table.values.get("only") else ""
    jobs = tuple(
        Job(case.name, BLIND, {"kind": case.kind, "hidden": "+".join(case.variants)}, seed=case.seed, case=case.name)
        for case in cases(kinds, seeds, first)
        if only in case.name
    )
    if not jobs:
        raise table.error("only", f"no case contains {only!r}", "write a part of a name such as stribeck:knee")
    return jobs, ("kind", "hidden")
