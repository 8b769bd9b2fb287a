"""`exoid compare`: the model against measurements; how large the error is, and where it sits."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence

from workbench.command_line.deliver import check_places, deliver_results
from workbench.command_line.options import add_common, add_derivative, add_limit, add_model, add_recordings
from workbench.terminal.progress import progress
from workbench.terminal.screen import Screen

HELP = """how large the error of the model is, and where it sits

exoid compare run1.csv run2.csv --verify run3.csv --out report"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_recordings(parser)
    add_derivative(parser)
    add_model(parser)
    add_limit(parser, "the error (of the unseen recordings, if there are any)")
    add_common(parser)


def run(args: argparse.Namespace) -> int:
    """Fit, compare, show; 1 when the error is above --limit."""
    from workbench.command_line.inputs import load

    check_places(args)
    given = load(args)
    with progress("comparing", quiet=args.quiet):
        from diagnosis.compare import compare

        found = compare(given.model, given.recordings, verify=given.verify, **given.filter)
    from workbench.report.material import Material, command_of, pictures_of, settings_of
    from workbench.terminal.showing import above, show_comparison

    screen = Screen.of(args)
    show_comparison(screen, found)
    rms = found.rms if found.verify_rms is None else found.verify_rms
    over = above(args.limit, rms)
    if over:
        screen.say(f"the error is above the limit of {' / '.join(f'{x:g}' for x in args.limit)} N·m", "bad")
    payload = {"schema": "exoid.comparison/1", **found.to_json()}
    deliver_results(args, screen, payload, lambda: Material(
        title="Model against measurement", answer=_sentence(rms, found.joints, found.verify_rms is not None),
        recordings=given.recordings, verify=given.verify, model=given.model, fit=found.fit, comparison=found,
        pictures=pictures_of(found, section="where"), command=command_of(args), settings=settings_of(args),
    ))  # fmt: skip
    return 1 if over else 0


def _sentence(rms: Iterable[float], joints: Sequence[str], unseen: bool) -> str:
    from workbench.terminal.screen import per_joint
    from workbench.terminal.showing import NOTHING_HELD_OUT

    kind = "motion the fit has not seen" if unseen else "the fitted motion"
    held_out = "" if unseen else f" {NOTHING_HELD_OUT}"
    return f"The model's torque misses the measured one by {per_joint(rms, joints)} (RMS) on {kind}.{held_out}"
