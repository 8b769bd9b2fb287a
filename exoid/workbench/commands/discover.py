"""`exoid discover`: compare, diagnose and add until the verdict says stop."""

from __future__ import annotations

import argparse

from exoid.workbench.command_line.asking import answer_question
from exoid.workbench.command_line.options import add_common, add_question

GROUP = "answer"
HELP = """add missing effects one after the other until the verdict says stop

exoid discover run1.csv run2.csv --verify run3.csv --out report --write leg_extended.toml"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_question(parser)
    parser.add_argument("--write", metavar="FILE", help="write the extended model to FILE")
    add_common(parser)


def run(args: argparse.Namespace) -> int:
    """Discover and show; 0 whatever is found, 1 where the channels cannot be what they say."""
    from exoid.diagnosis.discovery import discover

    return answer_question(args, discover, "What the model was missing", write=args.write)
