"""`exoid diagnose`: which physical effect is missing; ranking, evidence, look-alikes, verdict."""

from __future__ import annotations

import argparse

from exoid.workbench.command_line.asking import answer_question
from exoid.workbench.command_line.options import add_common, add_question

GROUP = "answer"
HELP = """which physical effect is missing, how sure that is, and what looks like it

exoid diagnose run1.csv run2.csv --verify run3.csv"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_question(parser)
    add_common(parser)


def run(args: argparse.Namespace) -> int:
    """Diagnose and show; a missing effect is an answer (0), channels that cannot be what they say are none (1)."""
    from exoid.diagnosis.discovery import diagnose

    return answer_question(args, diagnose, "Which effect is missing")
