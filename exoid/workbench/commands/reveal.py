"""`exoid reveal`: what was hidden in blind recordings, and whether a diagnosis found it."""

from __future__ import annotations

import argparse

from exoid.workbench.command_line.deliver import deliver_results
from exoid.workbench.command_line.options import add_common
from exoid.workbench.terminal.screen import Screen

GROUP = "measure"
HELP = """open the seal of blind recordings: what was hidden in the leg, and was the diagnosis right

exoid reveal runs/truth.seal
exoid reveal runs/truth.seal --diagnosis found.json     score what exoid discover --json found.json wrote; exit
                                                        status 1 when it was wrong"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("seal", metavar="SEAL", help="the .seal file that exoid simulate wrote")
    parser.add_argument("recordings", metavar="REC", nargs="*", help="check that the seal belongs to these recordings")
    parser.add_argument("--diagnosis", metavar="JSON", help="score this result of exoid diagnose or discover")
    add_common(parser, out="write result.json into DIR")


def run(args: argparse.Namespace) -> int:
    """Open the seal and show its content; with --diagnosis 1 when the diagnosis was wrong."""
    from exoid.measurement.bench.seal import open_seal
    from exoid.workbench.terminal.showing import truth_sentence

    truth = open_seal(args.seal, args.recordings or ()).truth
    screen = Screen.of(args)
    if args.diagnosis is None:
        screen.say(truth_sentence(truth))
        deliver_results(args, screen, {"schema": "exoid.truth/1", **truth.to_json()})
        return 0
    from exoid.diagnosis.grading import score
    from exoid.ground.output import read_json

    scored = score(truth, read_json(args.diagnosis), args.diagnosis)
    screen.say(truth_sentence(truth))
    for line in scored.lines:
        screen.say(f"  {line}")
    deliver_results(args, screen, {"schema": "exoid.truth/1", **truth.to_json(), "score": scored.to_json()})
    return 0 if scored.right else 1
