"""The options that commands share, spelt and explained once."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from exoid.workbench.command_line.parser import Seldom, UsageError

if TYPE_CHECKING:
    from exoid.ground.settings import Setting, VerbSettings


def add_common(parser: argparse.ArgumentParser, out: str = "write the report and its figures into DIR") -> None:
    """Add --json, --out, --seed and --quiet, which every command has."""
    group = parser.add_argument_group("output")
    group.add_argument("--json", metavar="FILE", help="write the result as JSON to FILE; -: standard output")
    group.add_argument("--out", metavar="DIR", help=out)
    seed = "seed of everything random (0)"
    Seldom(group).add_argument("--seed", metavar="N", type=whole_number, default=0, help=seed)
    group.add_argument("--quiet", action="store_true", help="no progress and no tables, only warnings and errors")


def add_settings(
    group: argparse._ActionsContainer | Seldom, record: type[VerbSettings], *names: str, **named: dict[str, Any]
) -> None:
    """Add an option for each setting called in `names`, as its record has it; in `named` with other words for it."""
    from exoid.ground.settings import default_of, settings_in

    known = {entry.name: (entry, about) for entry, about in settings_in(record)}
    for name in (*names, *named):
        entry, about = known[name]
        words: dict[str, Any] = {"help": about.meaning + default_of(entry), "default": entry.default}
        if isinstance(entry.default, bool):
            words["action"] = "store_true"
        elif about.choices:
            words["choices"] = about.choices
        else:
            words["metavar"] = about.unit.upper() if about.unit.isalpha() else "N"
            words["type"] = _reads(name, about, finite_number if isinstance(entry.default, float) else whole_number)
        group.add_argument(f"--{name.replace('_', '-')}", **(words | named.get(name, {})))


def settings_given(args: argparse.Namespace, record: type[VerbSettings], *but: str) -> dict[str, Any]:
    """Return {setting: value} of the settings of `record` that `args` know, but for some of them."""
    from exoid.ground.settings import settings_in

    names = [entry.name for entry, _ in settings_in(record) if entry.name not in but]
    return {name: getattr(args, name) for name in names if hasattr(args, name)}


def _reads(name: str, about: Setting, number: Callable[[str], float]) -> Callable[[str], float]:
    """Return a function that reads the value of a setting."""

    def read(text: str) -> float:
        value = number(text)
        objection = about.objection(name, value)
        if objection is not None:
            raise argparse.ArgumentTypeError(f"{objection[0]}: {objection[1]}")
        return value

    return read


def add_model(parser: argparse.ArgumentParser) -> None:
    """Add --model."""
    parser.add_argument("--model", metavar="FILE", help="model (TOML, URDF); without it, the standard leg")


def add_question(parser: argparse.ArgumentParser, *, required: bool = True) -> None:
    """Add what a question about recordings starts from: REC..., --verify, how they are read, and --model."""
    add_recordings(parser, required=required)
    add_derivative(parser)
    add_model(parser)


def add_recordings(
    parser: argparse.ArgumentParser, *, verify: bool = True, required: bool = True, rows: bool = True,
    everyday: bool = True,
) -> None:  # fmt: skip
    """Add REC..., --verify and what `add_reading` adds; `rows` unless --only means something else there."""
    count = "+" if required else "*"
    parser.add_argument(
        "recordings", metavar="REC", nargs=count,
        help="recordings the model is fitted to: files, folders, patterns in quotes ('runs/*.csv'), ZIP archives",
    )  # fmt: skip
    if verify:
        parser.add_argument(
            "--verify", metavar="REC", nargs="+", action="extend", default=[],
            help="recordings kept unseen; of a folder the rest is fitted",
        )  # fmt: skip
    add_reading(parser, rows, everyday=everyday)


def add_columns(group: argparse._ArgumentGroup | Seldom) -> None:
    """Add --map and --units: what the columns are."""
    group.add_argument(
        "--map", metavar="NAME=COLUMN", action="append", default=[], type=pairs,
        help="which column is which, for example q1=HipEnc,q2=KneeEnc; a product of columns as tau1=duty*volts",
    )  # fmt: skip
    group.add_argument(
        "--units", metavar="NAME=UNIT", action="append", default=[], type=pairs,
        help="units that are not SI, for example q=deg,tau=mNm; for a current, torque constant and gear: "
        "tau1=Nm/A*0.123*6",
    )  # fmt: skip


def add_reading(
    parser: argparse.ArgumentParser, rows: bool = True, *, everyday: bool = True, clock: str = "--rate"
) -> None:
    """Add what is needed to read recordings: --map, --units, --leg, --convention, --cutoff; --only where `rows` may be
    chosen. `everyday` where recordings are what the command is about; `clock` is what their rate is called.
    """
    group = parser.add_argument_group("reading the recordings")
    seldom = Seldom(group)
    usual = group if everyday else seldom
    add_columns(usual)
    seldom.add_argument(
        "--join", metavar="FILE[@LAG]", nargs="+", action="extend", default=[],
        help="further files of the same trial with clocks of their own, for example torques beside motion capture; of "
        "several recordings, REC=FILE says to which. They meet at the lag that physics says, or at LAG s",
    )  # fmt: skip
    seldom.add_argument(
        clock, dest="clock_rate", metavar="HZ", type=between(0.1, 1e6, "Hz"), default=0.0,
        help="how often recordings without a clock were sampled",
    )  # fmt: skip
    usual.add_argument(
        "--leg", choices=("left", "right", "both", "ipsi", "contra"),
        help="which leg, where a file holds both; both: two recordings of every file",
    )  # fmt: skip
    usual.add_argument(
        "--convention", metavar="NAME", action="append", default=[],
        help="how angles and torques are counted, where not as exoid does: flexion-positive, absolute-shank, ... "
        "(docs/file_formats.md; of other machines, docs/machines.md); several as A,B",
    )  # fmt: skip
    seldom.add_argument(
        "--passive", metavar="[FILE=]JOINT", action="append", default=[],
        help="the joint had no drive (in that recording), so its torque is zero for certain and needs no column: "
        "knee, or run6.csv=knee",
    )  # fmt: skip
    parser.set_defaults(condition="")
    if rows:
        seldom.add_argument(
            "--only", dest="condition", metavar="CONDITION", default="",
            help='of which rows the torques are explained, by a column of the file or of exoid: "contact == 0", '
            '"phase > 0.6 and t < 20"; unless it is given, stance is left out where a column says when the foot is on '
            "the ground and none what the ground does",
        )  # fmt: skip
    seldom.add_argument(
        "--cutoff", metavar="HZ", type=positive_number, help="cut-off of the common filter (chosen from the recordings)"
    )
    seldom.add_argument(
        "--verbose", action="store_true", help="say each warning and each repair of each file, and where it is"
    )


def add_derivative(parser: argparse.ArgumentParser) -> None:
    """Add --derivative, how velocities and accelerations come from angles, --payload and --wearer."""
    from exoid.diagnosis.settings import DiscoverySettings

    seldom = Seldom(parser)
    seldom.add_argument(
        "--payload", metavar="FILE=KG@M", action="append", default=[],
        help="the recording FILE was made with a known mass of KG on the shank, M below the knee, for example "
        "run4.csv=2@0.35; on the thigh, M below the hip: run4.csv=thigh:2@0.2; of an arm in space X,Y,Z in the frame "
        "of a joint: run4.csv=wrist_3:2@0,0,0.1; of a load nobody weighed only its link: run4.csv=shank",
    )  # fmt: skip
    seldom.add_argument(
        "--wearer", metavar="mass=KG,height=M",
        help="a person of this mass and height wore the machine in all recordings: the limb (Winter 2009, table 4.1) "
        "is taken off the numbers, which are those of the machine alone",
    )  # fmt: skip
    add_settings(seldom, DiscoverySettings, "derivative")


def add_limit(parser: argparse.ArgumentParser, what: str) -> None:
    """Add --limit: an error in N·m above which the exit status is 1."""
    Seldom(parser).add_argument(
        "--limit", metavar="RMS", type=limits,
        help=f"exit with status 1 when {what} is above RMS N·m (one number, or one per joint: hip,knee)",
    )  # fmt: skip


def whole_number(text: str) -> int:
    """Return a seed: a whole number from 0 to 2**32 - 1."""
    try:
        value = int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from None
    if not 0 <= value < 2**32:
        raise argparse.ArgumentTypeError(f"{text} is not between 0 and {2**32 - 1}")
    return value


def finite_number(text: str) -> float:
    """Return a finite number."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return value


def positive_number(text: str) -> float:
    """Return a finite number above zero."""
    value = finite_number(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text} is not above zero")
    return value


def between(
    low: float, high: float, unit: str = "", number: Callable[[str], Any] = finite_number
) -> Callable[[str], Any]:
    """Return a function that reads a number from `low` to `high`."""

    def read(text: str) -> Any:
        value = number(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text} is not between {low:g} and {high:g}{unit and ' '}{unit}")
        return value

    return read


def exclusive(args: argparse.Namespace, one: str, other: str, remedy: str = "give one of them") -> None:
    """Refuse two options that exclude each other; UsageError."""
    if getattr(args, one) and getattr(args, other):
        raise UsageError(f"--{one} and --{other} exclude each other", remedy=remedy)


def limits(text: str) -> tuple[float, ...]:
    """Return the limit for all joints from "0.5", or one per joint from "0.5,0.8"."""
    return tuple(positive_number(part) for part in text.split(","))


def pairs(text: str) -> dict[str, str]:
    """Return {"q1": "HipEnc", ...} from "q1=HipEnc,..."; a comma inside a name is written `\\,`."""
    found: dict[str, str] = {}
    for part in text.replace("\\,", "\0").split(","):
        name, equals, value = part.replace("\0", ",").partition("=")
        if not (equals and name.strip() and value.strip()):
            raise argparse.ArgumentTypeError(f"{part!r} is not NAME=VALUE")
        if name.strip() in found:
            raise argparse.ArgumentTypeError(f"{name.strip()!r} is given twice")
        found[name.strip()] = value.strip()
    return found


def merged(given: Sequence[dict[str, str]], option: str) -> dict[str, str]:
    """Return one mapping from a repeated option; raises UsageError when two of them disagree."""
    total: dict[str, str] = {}
    for entry in given:
        for name, value in entry.items():
            if total.get(name, value) != value:
                raise UsageError(f"{name} is given as {total[name]!r} and as {value!r}", where=option)
            total[name] = value
    return total
