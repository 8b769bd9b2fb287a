"""`exoid reveal`: what was hidden in blind recordings."""

from __future__ import annotations

import argparse

from workbench.deliver import check_places, deliver
from workbench.options import add_common
from workbench.screen import Screen

HELP = """open the seal of blind recordings: what was hidden in the leg

exoid reveal runs/truth.seal"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("seal", metavar="SEAL", help="the .seal file that exoid simulate --blind wrote")
    parser.add_argument("recordings", metavar="REC", nargs="*", help="check that the seal belongs to these recordings")
    add_common(parser, out="write result.json into DIR")


def run(args: argparse.Namespace) -> int:
    """Open the seal and show its content."""
    from measurement.seal import open_seal
    from workbench.showing import truth_sentence

    check_places(args)
    truth = open_seal(args.seal, args.recordings or ()).truth
    screen = Screen.of(args)
    screen.say(truth_sentence(truth))
    deliver(args, screen, {"schema": "exoid.truth/1", **truth.to_json()})
    return 0
