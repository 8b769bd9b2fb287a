"""`exoid model --from-urdf FILE`: a model file for the machine in a robot's URDF, in a plane or in space."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING

from exoid.symbolic.joints import HERE, Vector
from exoid.workbench.command_line.files import make_folder, write_json
from exoid.workbench.command_line.options import add_common, between
from exoid.workbench.terminal.screen import Screen

if TYPE_CHECKING:
    from exoid.symbolic.model import Model

GROUP = "build"
HELP = """write a model file for the machine in a URDF

exoid model --from-urdf robot.urdf --joints hip,knee,ankle --write leg.toml"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--from-urdf", metavar="FILE", required=True, help="the robot's URDF")
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
    from exoid.symbolic.model import robot_machine
    from exoid.symbolic.model_file import model_content, write_model
    from exoid.symbolic.robot_file import read_robot
    from exoid.workbench.command_line.inputs import check_new_model

    names = [name.strip() for name in (args.joints or "").split(",") if name.strip()]
    found = robot_machine(read_robot(args.from_urdf), names, args.gravity, args.from_urdf)
    target = args.write or _free_name(found.model.name, args.out)
    if args.out:
        make_folder(args.out)
    check_new_model(target, args.from_urdf)
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
