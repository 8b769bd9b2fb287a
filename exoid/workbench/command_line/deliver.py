"""The end of every command: JSON where it was asked for, a report where it was asked for."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from exoid.diagnosis.report.material import Material, without_folders
from exoid.ground.output import check_folder, make_folder
from exoid.workbench.command_line.files import check_json, write_json
from exoid.workbench.terminal.screen import Screen


def check_places(args: argparse.Namespace) -> None:
    """Refuse a --json or --out that cannot be written before the work starts; raises OutputError."""
    if args.json:
        check_json(args.json)
    if args.out:
        check_folder(args.out)


def deliver_results(
    args: argparse.Namespace, screen: Screen, payload: Any, material: Callable[[], Material] | None = None
) -> None:
    """Write `payload` to --json and to --out, where the report of `material()` goes too."""
    if args.json:
        write_json(args.json, payload)
    if not args.out:
        return
    folder = make_folder(args.out)
    write_json(str(folder / "result.json"), payload)
    if material is None:
        screen.say(f"wrote {folder}")
        return
    from exoid.diagnosis.report.page import write_report

    made = material()
    told = {**settings_of(args), **made.settings}
    page = write_report(replace(made, payload=payload, command=command_of(args), settings=told), folder)
    screen.say(f"report: {page}")


def settings_of(args: argparse.Namespace) -> dict[str, str]:
    """Return the settings of a command line as text, for the section that says how to repeat it."""
    hidden = ("command_line", "quiet", "verbose", "json", "out", "inputs", "recordings", "verify")
    return {
        name.replace("_", " "): str(value)
        for name, value in sorted(vars(args).items())
        if name not in hidden and str(value) not in ("None", "[]", "", "False", "0.0")
    }


def command_of(args: argparse.Namespace) -> str:
    """Return the command line as it can be pasted into a shell, in the folder of the files."""
    return shlex.join(without_folders(word) for word in getattr(args, "command_line", ["exoid"]))
