"""`exoid model --from-urdf FILE`, `--from-dh FILE`: a model file for the machine in a robot's URDF, in a plane or in
space, or in its table of Denavit and Hartenberg.
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING

from exoid.ground.output import make_folder
from exoid.symbolic.joints import HERE, Vector
from exoid.workbench.command_line.files import write_json
from exoid.workbench.command_line.options import add_common, between
from exoid.workbench.terminal.screen import Screen

if TYPE_CHECKING:
    from exoid.symbolic.model import Model

GROUP = "build"
HELP = """write a model file for the machine in a URDF, or in a Denavit-Hartenberg table

exoid model --from-urdf robot.urdf --joints hip,knee,ankle --write leg.toml
exoid model --from-dh table.csv --write arm.toml"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    made = parser.add_mutually_exclusive_group(required=True)
    made.add_argument("--from-urdf", metavar="FILE", help="the robot's URDF")
    made.add_argument(
        "--from-dh", metavar="FILE", help="its Denavit-Hartenberg table: CSV with joint, theta [deg], d, a, alpha [deg]"
    )
    parser.add_argument(
        "--dh", choices=("standard", "modified"), default="standard", help="how the table counts; modified: Craig's"
    )
    parser.add_argument(
        "--joints", metavar="A,B,C", help="joints of the machine, from the base on (default: all that move)"
    )
    parser.add_argument(
        "--gravity", type=between(0.0, 100.0, "m/s²"), metavar="G",
        help="gravity in m/s²: of a planar machine within its plane (default: 9.81, flat 0)",
    )  # fmt: skip
    parser.add_argument("--write", metavar="FILE", help="model file to write (default: the robot's name.toml)")
    add_common(parser, out="write the model file into DIR")


def run(args: argparse.Namespace) -> int:
    """Read the URDF, write the model file, and say what was found."""
    from exoid.symbolic.dh_table import dh_machine
    from exoid.symbolic.model import robot_machine
    from exoid.symbolic.model_file import model_content, write_model
    from exoid.symbolic.model_structure import STANDARD_GRAVITY
    from exoid.symbolic.robot_file import read_robot
    from exoid.symbolic.spatial_machine import RobotMachine
    from exoid.workbench.command_line.inputs import check_new_model
    from exoid.workbench.command_line.parser import UsageError

    given = args.from_urdf or args.from_dh
    if args.from_dh:
        if args.joints:
            remedy = "leave --joints out, and the rows of other joints out of the table"
            raise UsageError("--joints chooses joints of a URDF", remedy=remedy)
        gravity = STANDARD_GRAVITY if args.gravity is None else args.gravity
        model = dh_machine(args.from_dh, args.dh, gravity)
        found = RobotMachine(model, model.joint_names, ())
    else:
        names = [name.strip() for name in (args.joints or "").split(",") if name.strip()]
        found = robot_machine(read_robot(given), names, args.gravity, given)
    target = args.write or _free_name(found.model.name, args.out)
    if args.out:
        make_folder(args.out)
    check_new_model(target, given)
    write_model(found.model, target)
    screen = Screen.of(args)
    title = f"{found.model.name}: gravity {found.model.gravity:g} m/s²"
    screen.table(title, *_table(found.model))
    for note in found.notes:
        screen.say(note)
    screen.say(f"model: {target}")
    if args.json:
        write_json(args.json, {
            "schema": "exoid.model/1", "model_file": target, "joints": list(found.model.joint_names),
            "in_the_file": list(found.names), "model": model_content(found.model), "notes": list(found.notes),
        })  # fmt: skip
    return 0


def _table(model: Model) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return the columns and rows that show the joints of a model."""
    if model.spatial:
        rows: list[tuple[str, ...]] = [
            (joint.name, joint.kind, _three(joint.axis), _three(origin.xyz), _three(origin.rpy), joint.parent or "")
            for joint in model.joints
            for origin in (joint.origin or HERE,)
        ]
        return ("joint", "kind", "axis", "origin [m]", "turned by [rad]", "hangs from"), rows
    lengths = ["-" if joint.length is None else f"{joint.length:.4g}" for joint in model.joints]
    return ("joint", "kind", "length [m]", "hangs from"), [
        (joint.name, joint.kind, length, joint.parent or "")
        for joint, length in zip(model.joints, lengths, strict=True)
    ]


def _three(numbers: Vector | None) -> str:
    return " ".join(f"{number:.4g}" for number in numbers or ())


def _free_name(robot: str, folder: str | None) -> str:
    """Return a file name that is not taken, made of the robot's name."""
    stem = re.sub(r"[^A-Za-z0-9_-]", "_", robot)[:60] or "machine"
    names = (Path(folder or ".") / f"{stem}{'' if k == 1 else f'-{k}'}.toml" for k in range(1, 1000))
    return str(next((name for name in names if not name.exists()), Path(folder or ".") / f"{stem}.toml"))
