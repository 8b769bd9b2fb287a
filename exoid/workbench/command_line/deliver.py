"""The end of every command: JSON where it was asked for, a report where it was asked for."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from exoid.workbench.command_line.files import check_folder, check_json, make_folder, write_json
from exoid.workbench.terminal.screen import Screen

if TYPE_CHECKING:
    from exoid.workbench.report.material import Material


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
    from exoid.workbench.report.material import command_of, settings_of
    from exoid.workbench.report.page import write_report

    made = material()
    told = {**settings_of(args), **made.settings}
    page = write_report(replace(made, payload=payload, command=command_of(args), settings=told), folder)
    screen.say(f"report: {page}")
