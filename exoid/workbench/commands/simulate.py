"""`exoid simulate`: recordings from the virtual bench, with effects hidden in the leg."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from exoid.ground.output import make_folder
from exoid.workbench.command_line.files import write_json
from exoid.workbench.command_line.options import add_common, between, exclusive, positive_number, whole_number
from exoid.workbench.terminal.progress import progress
from exoid.workbench.terminal.screen import Screen

GROUP = "measure"
HELP = """make recordings on the virtual bench, with an effect hidden in the leg; truth.seal keeps what was hidden

exoid simulate --effect stribeck:knee=2.5 --out runs
exoid simulate --effect torque_ripple:hip=a=0.8,n=24 --out runs
exoid simulate --blind --seed 7 --out runs   something at random; exoid reveal runs/truth.seal tells
exoid simulate --wearer --walk --measured cuffs,switch --out walk   a person in a leg that walks"""

DEFAULT_FOLDER = "exoid-runs"
NOTHING = "nothing"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("model", metavar="MODEL", nargs="?", help="model file (TOML); without it, the standard leg")
    parser.add_argument(
        "--effect", metavar="ID[:joint][=SIZE]", action="append", default=[],
        help="hide this effect; SIZE is one number, or a list such as c=2.6,v_s=0.15",
    )  # fmt: skip
    parser.add_argument(
        "--blind", action="store_true",
        help="seal the truth in a separate file and do not show it; without --effect it is drawn at random",
    )  # fmt: skip
    parser.add_argument("--trajectory", metavar="FILE", help="let every run follow this motion (exoid design wrote it)")
    parser.add_argument(
        "--payload", metavar="KG@M",
        help="hang a known mass on the last link, M along it (2@0.35), in space at X,Y,Z of its joint (2@0,0,0.1)",
    )  # fmt: skip
    parser.add_argument(
        "--wearer", metavar="mass=KG,height=M", nargs="?", const="",
        help="a person in the leg, who pushes at its cuffs; told mass and height, with a limb of this size",
    )  # fmt: skip
    parser.add_argument(
        "--walk", action="store_true",
        help="the leg walks, its foot on the ground for 60 %% of each stride, instead of following a motion",
    )  # fmt: skip
    parser.add_argument(
        "--measured", metavar="WHAT",
        help="which columns of what pushes are recorded: cuffs, plate, switch, several as A,B, or nothing (all forces)",
    )  # fmt: skip
    runs = between(1, 100, number=whole_number)
    parser.add_argument("--runs", metavar="N", type=runs, default=4, help="number of recordings (4)")
    parser.add_argument("--duration", metavar="S", type=positive_number, default=30.0, help="length of each in s (30)")
    parser.add_argument("--rate", metavar="HZ", type=positive_number, default=100.0, help="sampling rate in Hz (100)")
    add_common(parser, out=f"write the recordings into DIR (default: {DEFAULT_FOLDER})")


def run(args: argparse.Namespace) -> int:
    """Simulate and write; never overwrites a recording."""
    from exoid.measurement.bench.hidden import parse_hidden, true_model
    from exoid.measurement.bench.simulation import bench_machine
    from exoid.workbench.command_line.inputs import load_model, worn
    from exoid.workbench.terminal.showing import truth_sentence

    exclusive(args, "trajectory", "blind", "blind runs draw motions of their own")
    exclusive(args, "payload", "blind", "simulate the loaded runs without --blind")
    exclusive(args, "trajectory", "walk", "a leg that walks follows no other motion")
    model = worn(load_model(args.model), args.wearer)
    leg = _loaded(bench_machine(model), args.payload, model)
    hidden = tuple(parse_hidden(text) for text in args.effect)
    true_model(model, leg.base, hidden)  # a wrong name is told before anything is written
    bench = _bench(args)
    folder = Path(args.out or DEFAULT_FOLDER)
    make_folder(folder)
    _refuse_overwriting(folder, args.runs)
    if args.blind and not hidden:
        hidden = _draw(args.seed, model)
    with progress("simulating", quiet=args.quiet):
        files, seal, truth = _simulate(args, folder, model, leg, hidden, bench)
    screen = Screen.of(args)
    for path in files:
        screen.say(f"wrote {path}")
    screen.say(f"wrote {seal}; exoid reveal {seal} opens it")
    if not args.blind:
        screen.say(truth_sentence(truth))
    if args.json:
        write_json(args.json, {
            "schema": "exoid.simulation/1", "recordings": [str(path) for path in files],
            "seal": str(seal), "seed": args.seed,
            "effects": None if args.blind else [one.name for one in hidden],
            "truth": None if args.blind else truth.to_json(),
        })  # fmt: skip
    return 0


def _loaded(leg: Any, text: str | None, model: Any) -> Any:
    """Return `leg`, or machine of `model`, with the payload that --payload names."""
    from exoid.workbench.command_line.inputs import payload_of

    load = payload_of(text) if text else None
    if load is None:
        return leg
    return leg.with_payload(load, model) if model.chain else leg.with_payload(load.mass, load.along, load.link)


def _bench(args: argparse.Namespace) -> Any:
    """Return the bench that the arguments ask for."""
    from exoid.measurement.bench.simulation import Bench
    from exoid.measurement.bench.walk import Walk
    from exoid.measurement.bench.wearer import Wearer

    measured = None
    if args.measured is not None:
        measured = () if args.measured == NOTHING else tuple(part.strip() for part in args.measured.split(","))
    person, steps = None if args.wearer is None else Wearer(), Walk() if args.walk else None
    return Bench(duration=args.duration, rate=args.rate, wearer=person, walk=steps, measured=measured)


def _simulate(
    args: argparse.Namespace, folder: Path, model: Any, leg: Any, hidden: Any, bench: Any
) -> tuple[Any, Path, Any]:
    """Write the recordings and their truth; return the paths of both, and the truth."""
    from exoid.measurement.bench.blind import write_runs
    from exoid.measurement.bench.simulation import simulate_runs
    from exoid.measurement.trajectories.trajectory_file import read_trajectory

    path = read_trajectory(args.trajectory, model.joint_names) if args.trajectory else None
    runs = simulate_runs(args.runs, model, leg, effects=hidden, seed=args.seed, excitation=path, bench=bench)
    return *write_runs(folder, runs), runs[0].truth


def _draw(seed: int, model: Any) -> Any:
    """Return something to hide, drawn at random from the catalogue."""
    import numpy as np

    from exoid.measurement.bench.blind import draw_hidden
    from exoid.symbolic.effect_catalogue import catalogue

    # A stream of its own: the motion drawn from the same seed must not tell what is hidden.
    known = catalogue(worn=model.wearer is not None).values()
    return draw_hidden(np.random.default_rng([seed, 99]), known, model=model)


def _refuse_overwriting(folder: Path, count: int) -> None:
    from exoid.ground.output import OutputError, check_target

    names = [*(f"run_{k}.csv" for k in range(count)), "truth.seal"]
    there = [name for name in names if os.path.lexists(folder / name)]
    if there:
        what = f"{there[0]} exists already"
        raise OutputError(what, where=str(folder), remedy="name another folder with --out, or remove the old runs")
    for name in names:
        check_target(str(folder / name))
