"""`exoid paper`: every figure, table and equation of the paper, made again and judged."""

from __future__ import annotations

import argparse
from collections import Counter
from typing import TYPE_CHECKING

from exoid.apps.paper.item import FAILS, HOLDS, KINDS, SEEDS
from exoid.ground.output import make_folder, write_bytes, write_text
from exoid.workbench.command_line.deliver import deliver_results
from exoid.workbench.command_line.options import add_common, whole_number
from exoid.workbench.command_line.parser import UsageError
from exoid.workbench.terminal.progress import progress
from exoid.workbench.terminal.screen import Screen

if TYPE_CHECKING:
    from exoid.apps.paper.reproduce import Reproduced

GROUP = "look up"
HELP = """make the figures, tables and equations of the paper again, and say whether it holds

exoid paper --list                               what there is
exoid paper --figure 9 --out paper               one of them
exoid paper --table 1 --equation 4 regressor     several
exoid paper --out paper                          all, with a page; a minute or two"""

PAGE = "paper.md"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    group = parser.add_argument_group("what of the paper (all of it)")
    for kind in KINDS:
        group.add_argument(
            f"--{kind}", metavar="N", nargs="+", action="extend", default=[],
            help=f"this {kind}, by its number, or by the word that --list has for it",
        )  # fmt: skip
    group.add_argument("--list", action="store_true", help="say what there is, and what the paper says; make nothing")
    parser.add_argument(
        "--seeds", metavar="N", type=whole_number, default=SEEDS, help="runs of whatever is random (%(default)s)"
    )
    add_common(parser, out="write pictures, a page of all items and a report into DIR")


def run(args: argparse.Namespace) -> int:
    """Make what was asked for and show one line of each."""
    screen = Screen.of(args)
    if args.list:
        return _list(args, screen)
    with progress("the paper", quiet=args.quiet) as report:
        from exoid.apps.paper.reproduce import reproduce_paper

        found = reproduce_paper(
            figure=args.figure, table=args.table, equation=args.equation, seed=args.seed, seeds=args.seeds,
            progress=report,
        )  # fmt: skip
    _show(screen, found)
    if args.out:
        from exoid.apps.paper.page import page_of, pictures_in

        folder = make_folder(args.out)
        for name, content in pictures_in(found).items():
            write_bytes(folder / name, content)
        screen.say(f"page: {write_text(folder / PAGE, page_of(found))}")
    from exoid.diagnosis.report.material import Material, Picture

    deliver_results(args, screen, {"schema": "exoid.paper/1", **found.to_json()}, lambda: Material(
        title="The paper, made again", answer=_sentence(found), seconds=found.seconds,
        pictures=tuple(
            Picture(f"{one.item.name}: {one.item.title}", picture.alt, picture.figure)
            for one in found.answered for picture in one.answer.pictures
        ),
    ))  # fmt: skip
    return 0


def _list(args: argparse.Namespace, screen: Screen) -> int:
    from exoid.apps.paper.reproduce import paper_items

    if args.figure or args.table or args.equation or args.out:
        raise UsageError("--list makes nothing", remedy="leave out --list, or everything else")
    items = paper_items()
    rows = [(item.name, item.title, item.command) for item in items]
    screen.table("The paper", ("item", "about", "command"), rows)
    deliver_results(args, screen, {"schema": "exoid.paper/1", "items": [item.to_json() for item in items]})
    return 0


def _show(screen: Screen, found: Reproduced) -> None:
    """Show of each item what the paper says, what comes out, whether it holds, with its formula and its tables."""
    for one in found.answered:
        item, answer = one.item, one.answer
        screen.say(f"{item.name}: {item.title}", "head")
        screen.say(f"  the paper  {item.says}")
        screen.say(f"  here       {answer.found}")
        style = {HOLDS: "good", FAILS: "bad"}.get(answer.holds, "warn")
        screen.say(f"  verdict    {answer.holds}" + (f": {answer.why}" if answer.why else ""), style)
        for line in answer.text.splitlines():
            screen.say(f"    {line}")
        for table in answer.tables:
            screen.table(table.caption, table.head, [tuple(map(_plain, row)) for row in table.rows])
        screen.say()


def _plain(cell: str) -> str:
    """Return a cell without the marks of Markdown; in a formula two stars are a power."""
    return "".join(part if k % 2 else part.replace("**", "") for k, part in enumerate(cell.split("`")))


def _sentence(found: Reproduced) -> str:
    """Return how many items hold, in words."""
    counts = Counter(one.answer.holds for one in found.answered)
    return "Of what the paper shows: " + ", ".join(f"{count} {verdict}" for verdict, count in counts.items()) + "."
