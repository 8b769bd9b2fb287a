"""`exoid design`: the motion that tells most about the leg's numbers, or that distinguishes rival effects."""

from __future__ import annotations

import argparse
from typing import Any

from exoid.ground.files import MODEL_FILES
from exoid.ground.output import make_folder, write_bytes, write_text
from exoid.workbench.command_line.deliver import deliver_results
from exoid.workbench.command_line.files import write_json
from exoid.workbench.command_line.options import (
    add_common,
    add_reading,
    add_settings,
    between,
    exclusive,
    finite_number,
    limits,
    settings_given,
)  # fmt: skip
from exoid.workbench.command_line.parser import Seldom, UsageError
from exoid.workbench.terminal.progress import progress
from exoid.workbench.terminal.screen import Screen, warn

GROUP = "measure"
HELP = """design the motion to record next, inside the limits of the leg

exoid design leg.toml --out motion                 the parameters of the model as well as possible
exoid design --free --rest --period 8              free centre, start and end at rest
exoid design --check motion/motion.toml            evaluate a motion; --check paper: the paper's coefficients
exoid design --separate stribeck:hip,viscous_quadratic:hip --model leg.toml run1.csv run2.csv
                                                   distinguish rival effects; exit status 1 when no motion can"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    from exoid.diagnosis.separation.settings import SeparationSettings
    from exoid.optimisation.excitation.settings import DesignSettings

    parser.add_argument(
        "inputs", metavar="MODEL|REC", nargs="*",
        help="model file (TOML; without it, the standard leg); with --separate, the present recordings",
    )  # fmt: skip
    parser.add_argument("--model", metavar="FILE", help="model file (TOML)")
    parser.add_argument(
        "--separate", metavar="A,B[,C]", help="find the motion that best distinguishes these effects (ID[:joint], ...)"
    )
    parser.add_argument("--check", metavar="FILE", help="evaluate this motion, design none (TOML, or paper)")
    motion = parser.add_argument_group("the motion")
    add_settings(motion, DesignSettings, "criterion", "period")
    seldom = Seldom(motion)
    add_settings(seldom, DesignSettings, "harmonics")
    seldom.add_argument("--middle", action="store_true", help="centre the motion in the middle of the angle range")
    motion.add_argument("--free", action="store_true", help="let the search choose the centre of the motion")
    # A motion that is only evaluated may use more than the limits allow.
    add_settings(motion, DesignSettings, "rest", use={"metavar": "SHARE", "type": between(1e-3, 10.0)})
    seldom.add_argument(
        "--rate", metavar="HZ", type=between(0.1, 1e6, "Hz"), default=100.0, help="rate of the sampled table (100)"
    )
    seldom.add_argument(
        "--target", metavar="VALUE", type=finite_number, help="exit with status 1 when the criterion is above VALUE"
    )
    search = Seldom(parser.add_argument_group("the search"))
    add_settings(search, SeparationSettings, generations={"help": "with --separate: generations of NFO (40)"})
    add_settings(search, DesignSettings, "optimiser", "starts", "printed", "box")
    noise = Seldom(parser.add_argument_group("what it is evaluated by"))
    noise.add_argument(
        "--noise", metavar="NM", type=limits,
        help="standard deviation of a torque sample in N·m (N where a joint slides), one or hip,knee (0.5: the bench)",
    )  # fmt: skip
    add_settings(noise, DesignSettings, "duration")
    add_reading(parser, everyday=False, clock="--recorded-rate")
    add_common(parser, out="write motion.toml, motion.csv (sampled), motion.png and the report into DIR")


def run(args: argparse.Namespace) -> int:
    """Design or evaluate a motion; 1 when limits, a target or the wish to distinguish effects cannot be met."""
    exclusive(args, "free", "middle")
    exclusive(args, "separate", "check")
    if args.out and not args.check:
        from exoid.measurement.trajectories.trajectory_file import samples_per_period

        samples_per_period(args.period, args.rate)  # told before the search, not after it
    if args.separate:
        return _separate(args)
    return _design(args)


def _design(args: argparse.Namespace) -> int:
    """Design a motion for one model, or evaluate a given one."""
    from exoid.measurement.trajectories.trajectory_file import sample_table
    from exoid.workbench.command_line.inputs import load_model

    path = _model_path(args)
    model = load_model(path)
    numbers = _numbers(path)
    from exoid.optimisation.excitation.design import NoMotionError

    try:
        found = _found(args, model, numbers)
    except NoMotionError as error:
        warn(str(error))
        if args.json:
            write_json(args.json, {"schema": "exoid.design/1", "feasible": False, "reason": error.what})
        return 1
    sampled = sample_table(found.trajectory, args.rate) if args.out else ""
    screen = Screen.of(args)
    _show(screen, found)
    if args.out:
        _write_motion(screen, args.out, found, sampled)
    from exoid.ground.ties import least_of

    missed = args.target is not None and not found.value <= args.target
    if missed:
        screen.say(f"{found.value:.5g} is above the target of {args.target:g}", "bad")
    tightest = least_of(found.uses, lambda use: -use.share, 1.0)
    answer = (
        f"cond(Ȳ) = {found.condition:.1f}; most used limit: {tightest.joint} {tightest.quantity}, "
        f"{100 * tightest.share:.1f} %."
    )
    alt = "Angle, velocity and acceleration of every joint over one period, each between its limits."
    payload = {"schema": "exoid.design/1", **found.to_json()}
    deliver_results(args, screen, payload, lambda: _material("A motion for identification", answer, found, alt))
    return 0 if found.feasible and found.informative and not missed else 1


def _found(args: argparse.Namespace, model: Any, numbers: Any) -> Any:
    """Return the Excitation that `args` ask for."""
    from exoid.optimisation.excitation.criteria import Noise
    from exoid.optimisation.excitation.design import design, evaluate
    from exoid.optimisation.excitation.settings import DesignSettings

    noise = Noise.white(args.noise, args.rate, model.joints)
    if args.check:
        from exoid.measurement.trajectories.trajectory import paper_trajectory
        from exoid.measurement.trajectories.trajectory_file import read_trajectory

        paper = args.check == "paper"
        given = paper_trajectory(args.period) if paper else read_trajectory(args.check, model.joint_names)
        return evaluate(
            given, model, criterion=args.criterion, name="the paper's" if paper else "given", noise=noise,
            numbers=numbers, duration=args.duration, use=args.use,
        )  # fmt: skip
    offsets = "free" if args.free else "middle" if args.middle else "paper"
    with progress("designing the motion", quiet=args.quiet) as report:
        wanted = settings_given(args, DesignSettings, "generations", "noise")
        return design(model, **wanted, offsets=offsets, noise=noise, numbers=numbers, progress=report)


def _show(screen: Screen, found: Any) -> None:
    """Show the searches, the limits and what the motion will tell."""
    from exoid.measurement.trajectories.extremes import shortest_period
    from exoid.optimisation.excitation.result import MEANING

    rows = [(c.name, f"{c.value:.5g}", c.evaluations, f"{c.seconds:.1f}", c.status) for c in found.candidates]
    head = (f"{found.criterion}: {MEANING[found.criterion]}", "value", "steps", "s", "said")
    screen.table("Best known", head, rows, note="not convex: no optimum is claimed" if len(rows) > 1 else "")
    screen.say(f"cond(Ȳ) = {found.condition:.2f}, log det of the information = {found.log_det:.2f}")
    limits = [
        (u.joint, u.quantity, f"{u.low:.4f}", f"{u.high:.4f}", *map("{:g}".format, u.limit), u.unit,
         f"{100 * u.share:.2f} %")
        for u in found.uses
    ]  # fmt: skip
    screen.table(
        "Limits, proven for all times", ("joint", "", "lowest", "highest", "limit", "limit ", "unit", "in use"), limits
    )
    if not found.feasible:
        shortest = shortest_period(found.trajectory, found.model.motion_limits)
        what = "no period helps: an angle is outside" if shortest == float("inf") else f"a period of {shortest:.3g} s"
        screen.say(f"the motion leaves its limits; {what} would keep them", "bad")
    known = [
        (
            p.name, f"{p.value:.4g}", f"{p.deviation:.3g}", p.unit,
            "-" if p.relative is None else f"{100 * p.relative:.2f} %",
        )
        for p in found.precision
    ]  # fmt: skip
    screen.table(
        f"Standard deviations after {found.duration:g} s", ("number", "assumed", "deviation", "unit", "relative"), known
    )
    screen.say(f"assumed: {found.numbers}; noise: {found.noise}", "faint")
    for text in found.cautions:
        screen.say(f"careful: {text}", "warn")


def _material(title: str, answer: str, found: Any, alt: str) -> Any:
    """Return the material of the report."""
    from exoid.diagnosis.report.material import Material, Picture

    pictures = () if found.trajectory is None else (Picture("The motion", alt, found.plot(), "motion"),)
    return Material(title=title, answer=answer, model=found.model, pictures=pictures, seconds=found.seconds)


def _write_motion(screen: Screen, out: str, found: Any, sampled: str) -> None:
    """Write coefficients, samples and picture of a motion."""
    from exoid.ground.figures import to_png
    from exoid.measurement.trajectories.trajectory_file import write_trajectory

    folder = make_folder(out)
    write_trajectory(found.trajectory, folder / "motion.toml", found.model.joint_names)
    write_text(folder / "motion.csv", sampled)
    write_bytes(folder / "motion.png", to_png(found.plot()))
    screen.say(f"wrote {folder / 'motion.toml'}, motion.csv, motion.png")


def _model_path(args: argparse.Namespace) -> str | None:
    """Return the one model file that is named, by position or by --model."""
    named = [*args.inputs, *([args.model] if args.model else [])]
    if len(named) > 1:
        what = f"{len(named)} models are named: {', '.join(named)}"
        raise UsageError(what, remedy="name one model file; recordings belong to --separate")
    return named[0] if named else None


def _numbers(path: str | None) -> Any:
    """Return the identified parameters of a model file, where it has some."""
    from exoid.symbolic.model_file import read_numbers

    return None if path is None else read_numbers(path)


def _separate(args: argparse.Namespace) -> int:
    """Design the motion that distinguishes rivals."""
    from exoid.optimisation.excitation.criteria import Noise
    from exoid.workbench.command_line.inputs import load, load_model

    joints = load_model(args.model).joints
    white = Noise.white(args.noise, args.rate, joints) if args.noise else None
    toml = [name for name in args.inputs if name.lower().endswith(MODEL_FILES)]
    if toml:
        raise UsageError("this is a model, not a recording", where=toml[0], remedy=f"--model {toml[0]}")
    args.recordings = args.inputs
    given = load(args)
    with progress("designing the motion", quiet=args.quiet) as report:
        from exoid.diagnosis.separation.design import separate
        from exoid.diagnosis.separation.settings import SeparationSettings

        found = separate(
            given.model, [name.strip() for name in args.separate.split(",") if name.strip()], given.recordings,
            **settings_given(args, SeparationSettings, "noise", "cutoff"), numbers=_numbers(args.model), noise=white,
            offsets="middle" if args.middle else "free", cutoff=given.cutoff, progress=report,
        )  # fmt: skip
    screen = Screen.of(args)
    _show_separation(screen, found)
    if args.out and found.trajectory is not None:
        from exoid.measurement.trajectories.trajectory_file import sample_table

        _write_motion(screen, args.out, found, sample_table(found.trajectory, args.rate))
    alt = "How far apart the rivals will be on this motion, at random and at present; the angles of all joints."
    payload = {"schema": "exoid.separation/1", **found.to_json()}
    title = "A motion that distinguishes rivals"
    deliver_results(args, screen, payload, lambda: _material(title, found.sentence, found, alt))
    return 0 if found.separable else 1


def _show_separation(screen: Screen, found: Any) -> None:
    """Show how far apart the rivals will be, or why no motion helps and what would."""
    screen.say(found.sentence, "good" if found.separable else "bad")
    if found.apart:
        head = ("true", "fitted", "design", "random", "now")
        rows = [
            (
                a,
                b,
                f"{far:.1f}",
                f"{found.usual[a, b]:.1f}",
                "" if found.present is None else f"{found.present[a, b]:.1f}",
            )
            for (a, b), far in found.apart.items()
        ]
        screen.table("σ apart, everything else refitted", head, rows)
    for item in found.same:
        for way in item.ways:
            screen.say(f"instead: {way}")
    for rival in found.rivals:
        screen.say(rival.sentence, "faint")
    screen.say(f"noise: {found.noise}; filter {found.cutoff:g} Hz", "faint")
