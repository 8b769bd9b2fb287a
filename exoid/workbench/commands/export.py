"""`exoid export`: the identified model as C, FMUs, a CasADi function, a NumPy module, URDF, MJCF, for ROS 2."""

from __future__ import annotations

import argparse
from pathlib import Path

from exoid.ground.output import default_folder, make_folder, write_bytes
from exoid.workbench.command_line.files import write_json
from exoid.workbench.command_line.options import add_common
from exoid.workbench.terminal.screen import Screen, warn

GROUP = "build"
HELP = """write an identified model for controllers and simulators: C99, CasADi, NumPy, URDF, MJCF, FMU, ROS 2

exoid identify run1.csv run2.csv --write leg_identified.toml
exoid export leg_identified.toml --out controller --sample-time 0.001
exoid export leg_identified.toml --as fmu --sample-time 0.001      for Simulink, Dymola, OpenModelica, FMPy
exoid export leg_identified.toml --as ros2 --out workspace/src     for controllers of ROS 2, with friction
exoid export leg_identified.toml --updater --sample-time 0.001     and what follows its numbers, in C
exoid export leg_identified.toml --format mjcf --into robot.urdf   and the numbers in a copy of your own URDF"""

DEFAULT_FOLDER = "exported"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    from exoid.workbench.exporting import formats, usual_formats

    known, usual = formats(), usual_formats()
    parser.add_argument("model", metavar="MODEL", help="model file with identified parameters (exoid identify --write)")
    parser.add_argument(
        "--format", "--as", nargs="+", choices=known, metavar="FORMAT",
        help=f"what to write: {', '.join(known)} (default: {', '.join(usual)})",
    )  # fmt: skip
    parser.add_argument("--name", default="exoid_leg", help="prefix of files and C functions (default: %(default)s)")
    parser.add_argument(
        "--sample-time", type=float, metavar="S", help="period of the control loop in s; effects with a delay need it"
    )
    parser.add_argument(
        "--sign-width", type=float, default=0.0, metavar="W",
        help="let sgn of a velocity fade below W rad/s, so that friction does not chatter at rest (default: a step)",
    )  # fmt: skip
    if "updater" in known:
        parser.add_argument(
            "--updater", action="store_true",
            help="write as well, in C, what follows the model's parameters while the controller runs; "
            "needs --sample-time",
        )  # fmt: skip
    parser.add_argument(
        "--into", metavar="URDF",
        help="write as well a copy of this URDF, of which the model was made, with the identified parameters in it",
    )  # fmt: skip
    add_common(parser, out=f"write into DIR (default: {DEFAULT_FOLDER})")


def run(args: argparse.Namespace) -> int:
    """Write every format asked for; 1 when one of several cannot carry this model."""
    from exoid.workbench.exporting import exporter, usual_formats
    from exoid.workbench.identified import ExportError, Options, read_ready

    options = Options(args.name, args.sample_time, args.sign_width)
    ready = read_ready(args.model)
    written, refused = {}, {}
    notes: tuple[str, ...] = ()
    for name in args.format or usual_formats():
        form = exporter(name)
        try:
            written[name] = form.write(ready, options)
            notes += form.notes(ready, options) if hasattr(form, "notes") else ()
        except ExportError as error:
            if args.format:  # asked for by name: not to be passed over
                raise ExportError(error.what, where=error.where or f"--format {name}", remedy=error.remedy) from error
            refused[name] = str(error)
    if getattr(args, "updater", False):
        written["updater"] = exporter("updater").write(ready, options)
    own: dict[str, bytes] = {}
    if args.into:
        from exoid.workbench.into_urdf import into_urdf

        content, said = into_urdf(ready, args.into)
        notes += said
        own[f"{Path(args.into).stem}_identified.urdf"] = content
    folder = make_folder(args.out or default_folder(DEFAULT_FOLDER))
    screen = Screen.of(args)
    for name, files in written.items():
        for file, content in files.items():
            whole = content.encode() if isinstance(content, str) else content
            screen.say(f"  {name:<7} {write_bytes(Path(folder) / file, whole)}")
    for file, content in own.items():
        screen.say(f"  own     {write_bytes(Path(folder) / file, content)}")
    for note in notes:
        screen.say(f"  {note}", "faint")
    for name, why in refused.items():
        warn(f"not written as {name}: {why}")
    if args.json:
        from exoid.symbolic.codegen.fingerprint import model_key

        write_json(args.json, {
            "schema": "exoid.export/1", "model": ready.model.name, "key": model_key(ready.model), "folder": str(folder),
            "files": {name: sorted(files) for name, files in (*written.items(), *([("own", own)] if own else []))},
            "refused": refused, "notes": list(notes),
            "numbers": {**ready.linear, **ready.shape},
        })  # fmt: skip
    return 1 if refused else 0
