"""Common steps of `diagnose`, `discover` and `demo`: ask the question, show the answer, write it down."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from exoid.diagnosis.report.material import Material
from exoid.workbench.command_line.deliver import deliver_results
from exoid.workbench.command_line.inputs import Inputs, check_new_model, load
from exoid.workbench.terminal.progress import part, progress
from exoid.workbench.terminal.screen import Screen
from exoid.workbench.terminal.showing import show_diagnosis, show_steps

Question = Callable[..., Any]
"""`diagnose` or `discover` of `exoid.diagnosis.discovery`."""


def answer_question(
    args: argparse.Namespace, question: Question, title: str, *, write: str | None = None, **more: Any
) -> int:
    """Read what `args` name, put the `question`, show and write the answer; return 1 if channels are in doubt.

    `more` goes to the question.
    """
    if write:
        check_new_model(write, args.model)
    given = load(args)
    found, comparison = answer(args, question, given, **more)
    screen = Screen.of(args)
    show_diagnosis(screen, found)
    show_steps(screen, found)
    if write:
        from exoid.symbolic.model_file import write_model

        write_model(found.model, write, found.fit)
        screen.say(f"model: {write}")
    deliver_results(args, screen, found.to_json(), lambda: material_of(title, given, found, comparison))
    return 1 if found.verdict == "check_channels" else 0


def answer(args: argparse.Namespace, question: Question, given: Inputs, **more: Any) -> tuple[Any, Any]:
    """Return the answer, and the Comparison of the model it started from where a report is asked for."""
    with progress("fitting the model", quiet=args.quiet) as report:
        found = question(
            given.model, given.recordings, verify=given.verify, seed=args.seed, **given.filter,
            progress=part(report, 0.0, 0.95), **more,
        )  # fmt: skip
        if given.loads:
            from exoid.diagnosis.write_up import with_loads

            found = with_loads(found, given.loads)
        comparison = None
        if args.out:
            from exoid.diagnosis.comparison import compare_prepared

            report(0.95, "looking where the model fails")
            comparison = compare_prepared(found.given.fit, found.given.prepared)
    return found, comparison


def material_of(title: str, given: Inputs, found: Any, comparison: Any, truth: str = "") -> Material:
    """Return the material of the report of a Diagnosis."""
    made: Material = found.material(comparison)
    return replace(made, title=title, recordings=given.recordings, verify=given.verify, truth=truth)
