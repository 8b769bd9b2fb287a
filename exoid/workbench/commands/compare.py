"""`exoid compare`: the model against measurements; how large the error is, and where it sits."""

from __future__ import annotations

import argparse
from dataclasses import replace

from exoid.workbench.command_line.deliver import deliver_results
from exoid.workbench.command_line.options import add_common, add_limit, add_question, exclusive
from exoid.workbench.terminal.progress import progress
from exoid.workbench.terminal.screen import Screen

GROUP = "answer"
HELP = """how large the error of the model is, and where it sits

exoid compare run1.csv run2.csv --verify run3.csv --out report
exoid compare before*.csv --against after*.csv     what differs, named, with intervals"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_question(parser)
    parser.add_argument(
        "--against", metavar="REC", nargs="+", action="extend", default=[],
        help="recordings made after maintenance, on another device, of another wearer: what differs from REC is named",
    )  # fmt: skip
    add_limit(parser, "the error (of the unseen recordings, if there are any)")
    add_common(parser)


def run(args: argparse.Namespace) -> int:
    """Fit, compare, show; 1 when the error is above --limit."""
    from exoid.workbench.command_line.inputs import load

    if args.against:
        return _against(args)
    given = load(args)
    with progress("comparing", quiet=args.quiet):
        from exoid.diagnosis.comparison import compare

        found = compare(given.model, given.recordings, verify=given.verify, **given.filter)
    from exoid.workbench.terminal.showing import show_comparison, show_limit

    screen = Screen.of(args)
    show_comparison(screen, found)
    rms = found.rms if found.verify_rms is None else found.verify_rms
    over = show_limit(screen, args.limit, rms, found.unit)
    payload = {"schema": "exoid.comparison/1", **found.to_json()}
    deliver_results(args, screen, payload, lambda: replace(
        found.material(), recordings=given.recordings, verify=given.verify, model=given.model,
    ))  # fmt: skip
    return 1 if over else 0


def _against(args: argparse.Namespace) -> int:
    """Say what differs between two sets of recordings; that nothing does is an answer too."""
    from exoid.diagnosis.report.material import Material, pictures_of
    from exoid.workbench.command_line.inputs import load
    from exoid.workbench.terminal.showing import show_differences

    exclusive(args, "against", "verify", "what is held out is chosen by exoid here")
    exclusive(args, "against", "limit")
    args.verify = args.against
    given = load(args)
    with progress("comparing before and after", quiet=args.quiet):
        from exoid.diagnosis.against.differences import compare_against

        found = compare_against(
            given.model, given.recordings, given.verify, seed=args.seed, extra=given.model.custom, **given.filter
        )
    screen = Screen.of(args)
    show_differences(screen, found)
    payload = {"schema": "exoid.differences/1", **found.to_json()}
    deliver_results(args, screen, payload, lambda: Material(
        title="Before against after", answer=" ".join([found.sentence, *(f"{d.sentence}." for d in found.found)]),
        recordings=given.recordings, verify=given.verify, model=given.model, pictures=pictures_of(found),
    ))  # fmt: skip
    return 0
