"""`exoid effects [ID]`: the catalogue of physical effects, or one entry in full. Its look-alikes are computed once."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from exoid.ground.output import make_folder, write_text
from exoid.symbolic.formula import formula
from exoid.workbench.command_line.files import write_json
from exoid.workbench.command_line.inputs import split_joint
from exoid.workbench.command_line.options import add_common
from exoid.workbench.terminal.progress import progress
from exoid.workbench.terminal.screen import Screen, width

if TYPE_CHECKING:
    from exoid.symbolic.effect import Coefficient, Effect, Shape
    from exoid.symbolic.model import Model

WIDE = 110
"""Columns of a terminal from which on the list shows formulas too."""

GROUP = "look up"
HELP = """list the physical effects exoid knows, or explain one

exoid effects              the whole catalogue
exoid effects stribeck     formula, coefficients, look-alikes, the experiment that distinguishes it"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("id", metavar="ID", nargs="?", help="the entry to explain")
    parser.add_argument("--model", metavar="FILE", help="include the effects of your own in this model file")
    add_common(parser, out="write the catalogue as effects.json and one text per entry into DIR")


def run(args: argparse.Namespace) -> int:
    """Show the catalogue, or the entry asked for."""
    from exoid.symbolic.effect_catalogue import catalogue, find_effect
    from exoid.workbench.command_line.inputs import load_model

    own = {effect.id: effect for effect in load_model(args.model).custom} if args.model else {}
    known = {**catalogue(), **own}
    found = None
    if args.id:
        name = split_joint(args.id)[0]
        found = own.get(name) or find_effect(name)
    chosen = known if found is None else {found.id: found}
    screen = Screen.of(args)
    if found is not None:
        screen.say(describe_effect(found))
    else:
        head, rows = ["effect", "joint", "what it means"], [[e.id, joints(e), e.explains] for e in chosen.values()]
        if width() >= WIDE:
            head.insert(2, "torque added")
            for row, effect in zip(rows, chosen.values(), strict=True):
                row.insert(2, next(iter(formula(effect).values())))
        screen.table("", head, rows)
        screen.say(f"{len(rows)} effects; exoid effects ID explains one of them")
    payload: dict[str, Any] = {"schema": "exoid.effects/1", "effects": [effect_record(e) for e in chosen.values()]}
    if found is not None:
        same = never(found, load_model(args.model), args.quiet)
        payload["effects"][0]["never_separable"] = {name: list(others) for name, others in same.items()}
        screen.say(written(same))
    if args.json:
        write_json(args.json, payload)
    if args.out:
        folder = make_folder(args.out)
        write_json(str(folder / "effects.json"), payload)
        for effect in chosen.values():
            write_text(folder / f"{effect.id}.txt", describe_effect(effect) + "\n")
        screen.say(f"wrote {folder}")
    return 0


def joints(effect: Effect) -> str:
    """Return the joints at which the effect may sit: "hip or knee", "knee", "both at once"."""
    if effect.on_both:
        return "both at once"
    return " or ".join(joint for joint in effect.joints if joint not in effect.absorbed_on) or "none"


def never(effect: Effect, model: Model, quiet: bool) -> Mapping[str, tuple[str, ...]]:
    """Return {term: what makes the same torque at every state of `model`}, for each joint the effect may sit at."""
    from exoid.symbolic.identifiability import every_candidate, never_separable

    names = [term.name for term in (*model.terms, *every_candidate(model)) if term.effect.id == effect.id]
    with progress("comparing its torque with every other effect's, once", quiet=quiet):
        return never_separable(names, model)


def written(same: Mapping[str, tuple[str, ...]]) -> str:
    """Return the effects that no motion can distinguish, as text."""
    lines = ["", "what no motion at all can distinguish (computed)"]
    lines += [f"  {name} from {', '.join(others)}" for name, others in same.items() if others]
    alone = [name for name, others in same.items() if not others]
    if alone:
        lines.append(f"  nothing else makes the same torque at every state as {' or '.join(alone)}")
    return "\n".join(lines if len(alone) < len(same) else ["", *(line.strip() for line in lines[2:])])


def describe_effect(effect: Effect) -> str:
    """Return everything the catalogue says about `effect`, as text."""
    lines = [f"{effect.id}: {effect.title or effect.family}", f"  {effect.explains}", ""]
    for joint, text in formula(effect).items():
        lines.append(f"  torque added{' on the ' + joint if joint else ''}: {text}")
    lines.append(f"  joint: {joints(effect)}")
    for joint, reason in effect.absorbed_on.items():
        lines.append(f"  not on the {joint}: {reason}")
    if effect.coefficients:
        lines += ["", "  coefficients (the torque is linear in them)"]
        lines += [f"    {name}: {_coefficient(c)}" for name, c in effect.coefficients.items()]
    if effect.shape:
        lines += ["", "  shape (searched within its bounds)"]
        lines += [f"    {name}: {_shape(s)}" for name, s in effect.shape.items()]
    if effect.tells_apart:
        lines += ["", f"  look-alikes, and the experiment that distinguishes it: {effect.tells_apart}"]
    lines += ["", f"  reference: {effect.reference}"]
    where = "" if effect.on_both else ":knee" if "knee" in effect.joints else ":hip"
    if not effect.custom:
        lines += ["", f"  try it: exoid simulate --effect {effect.id}{where} --out runs"]
    return "\n".join(lines)


def _coefficient(entry: Coefficient) -> str:
    bounds = {
        (True, True): "any sign",
        (False, True): f"at least {entry.min}",
        (True, False): f"at most {entry.max}",
        (False, False): f"{entry.min} to {entry.max}",
    }[entry.min is None, entry.max is None]
    return _number(entry, bounds)


def _shape(entry: Shape) -> str:
    span = " or ".join(f"{c:g}" for c in entry.choices) if entry.choices else f"{entry.min:g} to {entry.max:g}"
    return _number(entry, span)


def _number(entry: Coefficient | Shape, span: str) -> str:
    typical = f", typically {entry.typical:g}" if entry.typical is not None else ""
    return f"{entry.unit or '1'}, {span}{typical}" + (f"; {entry.explains}" if entry.explains else "")


def effect_record(effect: Effect) -> dict[str, Any]:
    """Return the entry in plain types."""
    numbers = {
        kind: {name: dict(vars(entry)) for name, entry in getattr(effect, kind).items()}
        for kind in ("coefficients", "shape")
    }
    return {
        "id": effect.id, "title": effect.title, "family": effect.family, "explains": effect.explains,
        "joints": effect.joints, "torque": effect.torque, "deflection": effect.deflection,
        "absorbed_on": effect.absorbed_on, "tells_apart": effect.tells_apart, "reference": effect.reference,
        "custom": effect.custom, **numbers, "derived": effect.derive is not None,
    }  # fmt: skip
