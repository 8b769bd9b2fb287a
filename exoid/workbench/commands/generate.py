"""`exoid generate`: derive equations, print them, or generate C from them, compile it, and say what changed."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from exoid.ground.ours import WRITTEN
from exoid.ground.output import default_folder, make_folder, write_bytes, write_text
from exoid.workbench.command_line.files import write_json
from exoid.workbench.command_line.options import add_common, exclusive
from exoid.workbench.command_line.parser import UsageError
from exoid.workbench.terminal.progress import progress
from exoid.workbench.terminal.screen import Screen

GROUP = "build"
HELP = """derive the equations of a model, print them, or generate its C code and compile it

exoid generate leg.toml --out generated
exoid generate --check --out generated   check the equations; exit status 1 when a property does not hold or the
                                         files there are out of date
exoid generate --check                   the same of ./generated; without such files, only the equations
exoid generate leg.toml --print          M, C, G, J and Y, and what the base parameters are made of
exoid generate leg.toml --print --as latex --out equations"""

DEFAULT_FOLDER = "generated"
FORMATS = {"text": "txt", "latex": "tex", "sympy": "py", "casadi": "py"}
"""How equations can be printed -> ending of their file; `exoid.symbolic.writing_equations` writes them."""

COMMENTS = {"text": "", "latex": "% ", "sympy": "# ", "casadi": "# "}
"""What a comment begins with in them."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("model", metavar="MODEL", nargs="?", help="model file (TOML); without it, the standard leg")
    parser.add_argument(
        "--check",
        action="store_true",
        help="write nothing; check the equations (symmetry, energy, the paper's C and Y) and the files, byte by byte",
    )
    parser.add_argument(
        "--print", action="store_true", help="print M, C, G, J and the regressor Y with its parameters; write no code"
    )
    parser.add_argument(
        "--as", dest="form", choices=FORMATS, help="with --print: text (default), LaTeX, or Python for SymPy or CasADi"
    )
    add_common(parser, out=f"write C, header and manifest into DIR (default: {DEFAULT_FOLDER})")


def run(args: argparse.Namespace) -> int:
    """Print, or generate, compile, say what changed; with --check, 1 when something would change."""
    exclusive(args, "print", "check")
    if args.print:
        return _print(args)
    if args.form:
        raise UsageError(f"--as {args.form} says how equations are printed", remedy="add --print")
    from exoid.symbolic.codegen.code import generate
    from exoid.symbolic.codegen.fingerprint import model_key
    from exoid.symbolic.codegen.kernel import compiled
    from exoid.workbench.command_line.inputs import load_model

    model = load_model(args.model)
    folder = Path(args.out or default_folder(DEFAULT_FOLDER))
    screen = Screen.of(args)
    with progress("deriving the equations", quiet=args.quiet) as report:
        fresh = {name: text.encode() for name, text in generate(model).files.items()}
        states = {name: _state(folder / name, content) for name, content in fresh.items()}
        if not args.check:
            report(0.5, "compiling")
            make_folder(folder)
            for name in (name for name, state in states.items() if state != "unchanged"):
                write_bytes(folder / name, fresh[name])
        backend = str(compiled(model).backend)  # so that the next command need not compile
        properties: tuple[Any, ...] = ()
        if args.check:
            from exoid.symbolic.check import check_equations

            report(0.6, "checking the equations")
            properties = check_equations(model)
    for name, state in states.items():
        screen.say(f"  {state:<9}  {folder / name}")
    screen.say(f"compiled: {'as C' if backend == 'c' else 'no C compiler, CasADi computes instead (slower)'}")
    for item in properties:
        screen.say(f"  {item}", "good" if item.holds else "bad")
    # Outside a checkout there are no files to be out of date, unless somebody names the folder where they should be.
    absent = args.out is None and all(state == "new" for state in states.values())
    stale = args.check and not absent and any(state != "unchanged" for state in states.values())
    if args.check and absent:
        screen.say(f"there are no generated files in {folder}: only the equations are checked")
    if stale:
        screen.say("the files are not what this model generates; run exoid generate", "bad")
    if args.json:
        write_json(args.json, {
            "schema": "exoid.generated/1", "model": model.name, "key": model_key(model), "folder": str(folder),
            "files": states, "checked_only": bool(args.check), "backend": backend,
            "checks": [{"name": c.name, "holds": c.holds, "how": c.how, "detail": c.detail} for c in properties],
        })  # fmt: skip
    return 1 if stale or not all(entry.holds for entry in properties) else 0


def _print(args: argparse.Namespace) -> int:
    """Print the equations; with --out, write them there as well."""
    from exoid.symbolic.codegen.fingerprint import model_key
    from exoid.symbolic.model_equations import equations
    from exoid.workbench.command_line.inputs import load_model

    model, form = load_model(args.model), args.form or "text"
    with progress("deriving the equations", quiet=args.quiet):
        found = equations(model)
        text = found.text(form)
    screen = Screen.of(args)
    if not screen.silent:
        sys.stdout.write(text)
    if args.out:
        whole = f"{COMMENTS[form]}{WRITTEN}.\n{text}"
        path = write_text(make_folder(args.out) / f"equations_{form}.{FORMATS[form]}", whole)
        screen.say(f"written: {path}")
    if args.json:
        write_json(args.json, {
            "schema": "exoid.equations/1", "model": model.name, "key": model_key(model), "format": form, "text": text,
            "parameters": {p.name: {"unit": p.unit, "meaning": str(found.base.get(p.name, p.label))}
                           for p in found.parameters},
        })  # fmt: skip
    return 0


def _state(path: Path, content: bytes) -> str:
    """Return the state of one file: "new", "changed" or "unchanged"."""
    if not path.exists():
        return "new"
    if not path.is_file():
        return "changed"
    return "unchanged" if path.read_bytes() == content else "changed"
