"""`exoid model --from-urdf FILE`: a model file for the planar machine in a robot's URDF."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from exoid.workbench.command_line.files import make_folder, write_json
from exoid.workbench.command_line.options import add_common, between
from exoid.workbench.terminal.screen import Screen

GROUP = "build"
HELP = """write a model file for the planar machine in a URDF

exoid model --from-urdf robot.urdf --joints hip,knee,ankle --write leg.toml"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--from-urdf", metavar="FILE", required=True, help="the robot's URDF")
    parser.add_argument(
        "--joints", metavar="A,B,C", help="joints of the machine, from the base on (default: all that move)"
    )
    parser.add_argument(
        "--gravity", type=between(0.0, 100.0, "m/s²"), metavar="G",
        help="gravity within the plane in m/s² (default: 9.81 upright, 0 flat)",
    )  # fmt: skip
    parser.add_argument("--write", metavar="FILE", help="model file to write (default: the robot's name.toml)")
    add_common(parser, out="write the model file into DIR")


def run(args: argparse.Namespace) -> int:
    """Read the URDF, write the model file, and say what was found."""
    from exoid.symbolic.model_file import model_content, write_model
    from exoid.symbolic.planar_machine import planar_machine
    from exoid.symbolic.robot_file import read_robot
    from exoid.workbench.command_line.inputs import check_new_model

    names = [name.strip() for name in (args.joints or "").split(",") if name.strip()]
    found = planar_machine(read_robot(args.from_urdf), names, args.gravity, args.from_urdf)
    target = args.write or _free_name(found.model.name, args.out)
    check_new_model(target, args.from_urdf)
    if args.out:
        make_folder(args.out)
    write_model(found.model, target)
    screen = Screen.of(args)
    rows = [
        (joint.name, joint.kind, "-" if joint.length is None else f"{joint.length:.4g}", joint.parent or "")
        for joint in found.model.joints
    ]
    title = f"{found.model.name}: gravity {found.model.gravity:g} m/s²"
    screen.table(title, ("joint", "kind", "length [m]", "hangs from"), rows)
    for note in found.notes:
        screen.say(note)
    screen.say(f"model: {target}")
    if args.json:
        write_json(args.json, {
            "schema": "exoid.model/1", "model_file": target, "joints": list(found.model.joint_names),
            "in_the_file": list(found.names), "model": model_content(found.model), "notes": list(found.notes),
        })  # fmt: skip
    return 0


def _free_name(robot: str, folder: str | None) -> str:
    """Return a file name that is not taken, made of the robot's name."""
    stem = re.sub(r"[^A-Za-z0-9_-]", "_", robot)[:60] or "machine"
    names = (Path(folder or ".") / f"{stem}{'' if k == 1 else f'-{k}'}.toml" for k in range(1, 1000))
    return str(next((name for name in names if not name.exists()), Path(folder or ".") / f"{stem}.toml"))
