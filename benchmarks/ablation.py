"""What each rule of the decision is worth: switched off alone, on the arena's cases in which it fires, paired.

    python benchmarks/ablation.py FOLDER                     ask every case, then switch every rule off where it fired
    python benchmarks/ablation.py FOLDER --cases 60 --only exchange drop_unsteady
    python benchmarks/ablation.py FOLDER --page              the table, from what was answered so far

A rule that fires in no case changes none. FOLDER holds fired.jsonl (case, what it answers, which rules fired) and
without.jsonl (case, rule, what is answered without it), a line each, so that it can be interrupted.
"""

from __future__ import annotations

import argparse
import functools
import importlib
import json
import os
import sys
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # must be set before NumPy is imported

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from benchmarks.arena.__main__ import answered  # noqa: E402 - the repository must be on the path first
from benchmarks.arena.cases import names  # noqa: E402
from benchmarks.arena.referee import right  # noqa: E402
from benchmarks.baselines import read_lines  # noqa: E402
from exoid.diagnosis.hypotheses import channels  # noqa: E402
from exoid.ground.folder import names_in  # noqa: E402

Line = dict[str, Any]


@dataclass(frozen=True)
class Switch:
    """A function whose answer is a rule's: what it says where the rule is off, given its arguments."""

    module: str
    name: str
    off: Callable[..., Any]

    @property
    def rule(self) -> str:
        """Name of the rule: of a doubt, that of its file."""
        return self.module.rpartition(".")[2] if self.name == "doubt" and "." in self.module else self.name.lstrip("_")

    @property
    def function(self) -> Callable[..., Any]:
        """The function as it is."""
        found: Callable[..., Any] = getattr(importlib.import_module(f"exoid.diagnosis.{self.module}"), self.name)
        return found


def _says(value: Any) -> Callable[..., Any]:
    return lambda *arguments, **named: value


def _as_it_was(context: Any, state: Any) -> Any:
    return state


def _switches() -> Iterator[Switch]:
    for name in ("little_motion", "on_bound", "undetermined", "made_by_the_filter", "explains_nothing"):
        yield Switch("search.doubt", name, _says(""))
    for name in ("beside_standstill", "less_than_chance", "torque_before_motion"):
        yield Switch("search.doubt", name, _says(""))
    yield Switch("search.doubt", "refuted", _says(None))
    yield Switch("search.choice", "plainer_together", _says(frozenset()))
    yield Switch("search.choice", "outlives_noise", _says(True))
    yield Switch("search.choice", "_twins", _says([]))
    yield Switch("search.containing", "contains", _says(False))
    for name in ("prune", "exchange", "drop_unsteady"):
        yield Switch("search.engine", name, _as_it_was)
    yield Switch("search.engine", "_made_of", _says(False))
    yield Switch("search.engine", "_holds_any", _says(False))
    yield Switch("search.take_back", "proxies", _says(frozenset()))
    yield Switch("search.take_back", "_superseded", _says(set()))
    yield Switch("evidence.proxies", "_bumps", _says([]))
    yield Switch("evidence.curves", "may_move", _says(False))
    yield Switch("evidence.ranking", "clearly_helps", _says(True))
    yield Switch("evidence.model_error", "repeats", _says(None))
    yield Switch("search.take_back", "left_over", _says(None))
    yield Switch("search.take_back", "_of_filter", _says(False))
    yield Switch("evidence.score", "harmless", _says(True))
    yield Switch("evidence.ranking", "_outvoted", _says(False))
    yield Switch("evidence.soft_drive", "soft_drive", _says(None))
    yield Switch("evidence.swinging", "sway_nodes", _says(None))
    yield Switch("evidence.swinging", "swinging", _says(None))
    yield Switch("evidence.apart", "odd_ones", _says(()))
    yield Switch("evidence.intermittent", "intermittent", _says(None))
    for name in names_in(channels):
        yield Switch(f"hypotheses.channels.{name}", "doubt", _says(None))
    yield Switch("verdict", "_far_where_fitted", _says([]))
    yield Switch("verdict", "within_filter_error", _says(None))


def switches() -> dict[str, Switch]:
    """Return every switch, by the name of its rule."""
    return {one.rule: one for one in _switches()}


@contextmanager
def replaced(switch: Switch, function: Callable[..., Any]) -> Iterator[None]:
    """Let another function stand wherever a module of exoid holds that of a switch."""
    before = switch.function
    places = [
        (module, key, value)
        for module in list(sys.modules.values())
        if getattr(module, "__name__", "").startswith("exoid")
        for key, value in list(vars(module).items())
        if value is before or (isinstance(value, tuple) and any(one is before for one in value))
    ]
    for module, key, value in places:
        new = tuple(function if one is before else one for one in value) if isinstance(value, tuple) else function
        setattr(module, key, new)
    try:
        yield
    finally:
        for module, key, value in places:
            setattr(module, key, value)


def _counted(switch: Switch, fired: set[str]) -> Callable[..., Any]:
    before = switch.function

    @functools.wraps(before)
    def asked(*arguments: Any, **named: Any) -> Any:
        answer = before(*arguments, **named)
        quiet = switch.off(*arguments, **named)
        same = answer.names == quiet.names if hasattr(answer, "names") and hasattr(quiet, "names") else answer == quiet
        if not (isinstance(same, bool) and same):
            fired.add(switch.rule)
        return answer

    return asked


def _said(case: str) -> Line | None:
    """Return what exoid answers to a case, and the truth; None where it cannot be drawn here."""
    truth, said = answered(case, ["exoid_discover"], sealed_before=False)
    return truth | said[0] if truth is not None and said else None


def counted(case: str) -> Line | None:
    """Return the answer to a case as the rules are, and which of them fired; None where it cannot be drawn here."""
    importlib.import_module("exoid.diagnosis.discovery")
    fired: set[str] = set()
    with ExitStack() as stack:
        for one in switches().values():
            stack.enter_context(replaced(one, _counted(one, fired)))
        line = _said(case)
    return None if line is None else line | {"fired": sorted(fired)}


def without(case: str, rule: str) -> Line | None:
    """Return the answer to a case with a rule switched off; None where it cannot be drawn here."""
    importlib.import_module("exoid.diagnosis.discovery")
    one = switches()[rule]
    with replaced(one, one.off):
        line = _said(case)
    return None if line is None else line | {"rule": rule}


def run(folder: Path, wanted: Sequence[str], rules: Sequence[str], processes: int) -> None:
    """Ask what was not answered yet, and keep every answer at once."""
    fired, off = folder / "fired.jsonl", folder / "without.jsonl"
    known = {line["case"] for line in read_lines(fired)}
    with ProcessPoolExecutor(max_workers=processes) as pool:
        for line in pool.map(counted, [case for case in wanted if case not in known]):
            _keep(fired, line)
        known_off = {(line["case"], line["rule"]) for line in read_lines(off)}
        asked = [
            (line["case"], rule)
            for line in read_lines(fired)
            for rule in rules
            if rule in line["fired"] and line["case"] in wanted and (line["case"], rule) not in known_off
        ]
        for line in pool.map(without, [case for case, _ in asked], [rule for _, rule in asked]):
            _keep(off, line)


def _keep(file: Path, line: Line | None) -> None:
    if line is not None:
        with file.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(line) + "\n")


def table(answers: Sequence[Line], off: Sequence[Line], rules: Sequence[str]) -> str:
    """Return how often each rule fired, and which answers are wrong or right without it."""
    usual = {line["case"]: line for line in answers}
    lost: dict[str, list[str]] = defaultdict(list)
    won: dict[str, list[str]] = defaultdict(list)
    for line in off:
        if line["case"] in usual:
            was, now = (_right(one) for one in (usual[line["case"]], line))
            if was != now:
                (lost if was else won)[line["rule"]].append(line["case"])
    rows = [f"{len(usual)} cases, right as they are {sum(map(_right, usual.values()))}.", ""]
    rows += [
        "| rule | fired in | right without it alone | wrong without it | which |",
        "| --- | --- | --- | --- | --- |",
    ]
    for rule in rules:
        count = sum(rule in line["fired"] for line in answers)
        which = "; ".join([*(f"+ {case}" for case in won[rule]), *(f"- {case}" for case in lost[rule])][:4])
        rows.append(f"| {rule} | {count} | {len(won[rule])} | {len(lost[rule])} | {which} |")
    return "\n".join(rows)


def _right(line: Mapping[str, Any]) -> bool:
    return right(line, line)


def main(words: Sequence[str] | None = None) -> int:
    """Run what the command line asks for."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="benchmarks/ablation.py", description=__doc__, formatter_class=form)
    importlib.import_module("exoid.diagnosis.discovery")
    everything = list(switches())
    parser.add_argument("folder", type=Path, help="where answers are kept, outside the repository")
    parser.add_argument("--cases", type=int, default=None, help="the first so many cases, kinds by turns (all)")
    parser.add_argument("--within", default="", help="cases whose name contains this (all)")
    parser.add_argument("--only", nargs="+", choices=everything, default=everything, metavar="RULE")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--page", action="store_true", help="print the table and ask nothing")
    given = parser.parse_args(words)
    if given.folder.resolve().is_relative_to(ROOT):
        parser.error(f"{given.folder} is inside the repository; results are not part of it")
    given.folder.mkdir(parents=True, exist_ok=True)
    if not given.page:
        wanted = [case for case in names() if given.within in case][: given.cases]
        run(given.folder, wanted, given.only, given.processes)
    print(table(read_lines(given.folder / "fired.jsonl"), read_lines(given.folder / "without.jsonl"), given.only))
    return 0


if __name__ == "__main__":
    sys.exit(main())
