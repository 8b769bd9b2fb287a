"""`exoid map`: say once which column is what; kept beside the recording and used for the next of its kind."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from exoid.workbench.command_line.files import write_json
from exoid.workbench.command_line.options import add_common, add_model, add_reading, merged
from exoid.workbench.terminal.screen import Screen

if TYPE_CHECKING:
    from exoid.symbolic.joints import Joint

GROUP = "measure"
HELP = """say which column is what, once for all recordings with these columns

exoid map run1.csv --map q1=HipEnc,q2=KneeEnc --units q=deg
writes exoid.toml beside run1.csv; without --map it asks, on a terminal"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("file", metavar="FILE", help="a recording; nothing in it is changed")
    add_reading(parser)
    add_model(parser)
    parser.add_argument(
        "--replace", action="store_true", help="keep this mapping instead of another one for the same columns"
    )
    add_common(parser, out="keep the mapping in DIR instead of beside the recording")


def run(args: argparse.Namespace) -> int:
    """Show the columns, ask for what is not said, check the answer and keep it."""
    from exoid.ground.output import make_folder
    from exoid.measurement.reading.mapping import FILE, StatedMapping, entries, remember
    from exoid.measurement.reading.read import open_table
    from exoid.measurement.reading.sources import folder_of
    from exoid.workbench.command_line.inputs import load_model

    screen = Screen.of(args)
    joints = load_model(args.model).joints
    of_all = merged(args.map, "--map"), merged(args.units, "--units"), args.leg or ""
    told = StatedMapping(*of_all, rate=args.clock_rate)
    table = open_table(args.file)
    folder = Path(args.out) if args.out else folder_of(Path(args.file))
    kept = [mapping for header, mapping in entries(folder / FILE) if header == table.names]
    if kept and not told:
        told = kept[-1]
        screen.say(f"{folder / FILE} says already: {told}")
    asking = sys.stdin.isatty() and not args.quiet and args.json != "-"
    if asking:
        _show(screen, table)
        told = _asked(table, told, args.file, screen, joints)
    found = _checked(table, told, args.file, joints)
    if args.out:
        make_folder(args.out)
    path = remember(folder, table.names, told, replacing=args.replace) if told else None
    for name, item in found.items():
        screen.say(f"  {name:<5} {item.column.name}" + (f"  [{item.unit}]" if item.told else ""))
    screen.say(
        f"kept in {path}; it is used for every recording there with these columns"
        if path
        else "every column is recognised as it is: nothing needs to be kept"
    )
    if args.json:
        write_json(args.json, {
            "schema": "exoid.mapping/1", "file": args.file, "kept": path, "header": table.names,
            "columns": {name: item.column.name for name, item in found.items()},
            "units": {name: item.unit for name, item in found.items()}, "leg": told.leg or None,
        })  # fmt: skip
    return 0


def _checked(table: Any, told: Any, where: str, joints: Sequence[Joint]) -> dict[str, Any]:
    """Return {canonical name: column} as `told`; RecordingError, which names the option, where something is open."""
    from exoid.measurement.reading.columns import assign_usable, legs

    chosen = replace(told, leg=next(iter(legs(table, joints)), "")) if told.leg == "both" else told
    return assign_usable(table, chosen, where=where, joints=joints)[0]


def _show(screen: Screen, table: Any) -> None:
    """Write the columns of `table` with their first values."""
    import numpy as np

    rows = []
    for number, column in enumerate(table.columns[:200], start=1):
        values = column.values[np.isfinite(column.values)]
        reach = _reach(values) if values.size else "no numbers"
        rows.append((number, column.name[:40], column.unit, reach))
    screen.table("columns", ("", "name", "unit", "range"), rows)


def _reach(values: Any) -> str:
    """Return "0 to 20" of numbers, with as many digits as it takes to distinguish the two: a clock in ms since 1970."""
    low, high = float(values.min()), float(values.max())
    digits = next((count for count in range(4, 17) if f"{low:.{count}g}" != f"{high:.{count}g}"), 4)
    return " to ".join(f"{item:.{digits}g}" if digits == 4 else f"{item:.15g}" for item in (low, high))


def _asked(table: Any, told: Any, where: str, screen: Screen, joints: Sequence[Joint]) -> Any:
    """Return `told` completed by the answers to one question after the other; an empty line leaves a column out."""
    from exoid.ground.errors import RecordingError
    from exoid.measurement.reading.columns import required
    from exoid.measurement.reading.mapping import numbered

    names = numbered(table.names)
    for _ in range(50):
        try:
            _checked(table, told, where, joints)
            return told
        except RecordingError as error:
            screen.say(error.what, "warn")
            if "more than one leg" in error.what:
                answer = _answer("which leg, left or right (or both)? ")
                if answer in ("left", "right", "both", "ipsi", "contra"):
                    told = replace(told, leg=answer)
                    continue
                raise
            said = f" {error.what}"
            open_names = [n for n in required(joints) if n not in told.columns and f" {n}" in said]
            wanted = next((n for n in open_names if n in error.what.replace(",", " ").replace(":", " ").split()), None)
            if wanted is None:
                raise
            answer = _answer(f"{wanted} is column (name or number)? ")
            if not answer:
                raise
            column = names[int(answer) - 1] if answer.isdecimal() and 0 < int(answer) <= len(names) else answer
            unit = _answer(f"{wanted} is in (empty: as the file says, else SI)? ")
            units = {**told.units, wanted: unit} if unit else told.units
            told = replace(told, columns={**told.columns, wanted: column}, units=units)
    return told


def _answer(question: str) -> str:
    """Return one line from the terminal, without blanks around it."""
    try:
        return input(question).strip()
    except EOFError:
        return ""
