"""`exoid add`: extend the model by one effect, regenerate its code, refit, and show before and after."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from exoid.workbench.command_line.deliver import deliver_results
from exoid.workbench.command_line.options import add_common, add_question
from exoid.workbench.terminal.progress import progress
from exoid.workbench.terminal.screen import Screen

GROUP = "answer"
HELP = """add an effect to the model, refit, and show the error before and after

exoid add stribeck:knee --model leg.toml run1.csv run2.csv --verify run3.csv
exit status 1 when the effect does not help on unseen recordings"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("effect", metavar="EFFECT[:joint]", help="what to add, for example stribeck:knee")
    add_question(parser)
    parser.add_argument(
        "--write", metavar="FILE", help="the extended model (default: next to the model, under a new name)"
    )
    add_common(parser)


def run(args: argparse.Namespace) -> int:
    """Extend, refit, show; 1 when the effect does not help on unseen recordings."""
    from exoid.ground.output import make_folder
    from exoid.workbench.command_line.inputs import beside, check_new_model, load, load_model, split_joint

    model = load_model(args.model)
    effect, joint = split_joint(args.effect, model.joint_names)
    model.with_effect(effect, joint=joint)  # a wrong name is told before the recordings are read
    target = args.write or (str(Path(args.out) / "model.toml") if args.out else beside(args.model, args.effect))
    if args.out:
        make_folder(args.out)  # the model goes there
    check_new_model(target, args.model, named=args.write is not None)
    given = load(args)
    with progress(f"adding {args.effect}", quiet=args.quiet):
        from exoid.diagnosis.extend import add

        found = add(given.model, args.effect, given.recordings, given.verify, **given.filter)
    from exoid.symbolic.model_file import write_model

    write_model(found.model, target, found.after)
    screen = Screen.of(args)
    _show(screen, found, target)
    payload = {"schema": "exoid.addition/1", **found.to_json(), "model_file": target}
    deliver_results(args, screen, payload, lambda: _material(args, given, found))
    return 0 if found.helped else 1


def _show(screen: Screen, found: Any, target: str) -> None:
    from exoid.symbolic.wording import number_of
    from exoid.workbench.terminal.showing import number, show_steps

    new = [e for e in found.after.estimates if e.name not in {b.name for b in found.before.estimates}]
    rows = [(number_of(e.name), number(e.value), e.unit, number(e.low), number(e.high), e.name) for e in new]
    screen.table("What was added", ("number", "value", "unit", "95 % from", "to", "id"), rows)
    show_steps(screen, found.waterfall)
    screen.say(str(found.sentence), "good" if found.helped else "bad")
    screen.say(f"model: {target}")


def _material(args: argparse.Namespace, given: Any, found: Any) -> Any:
    return replace(found.material(), recordings=given.recordings, verify=given.verify)
