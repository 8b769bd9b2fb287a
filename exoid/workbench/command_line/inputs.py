"""From the words of a command line to models and recordings."""

from __future__ import annotations

import argparse
import math
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from exoid.ground.suggest import did_you_mean
from exoid.measurement.signals.methods import BUTTERWORTH
from exoid.symbolic.joints import JOINT_NAME
from exoid.symbolic.quantity import JOINTS
from exoid.workbench.command_line.options import merged
from exoid.workbench.command_line.parser import UsageError
from exoid.workbench.command_line.said import say_findings
from exoid.workbench.terminal.progress import progress
from exoid.workbench.terminal.screen import warn

if TYPE_CHECKING:
    from exoid.diagnosis.own_numbers.numbers import Belonging
    from exoid.measurement.reading.among import FoundFiles
    from exoid.measurement.reading.mapping import StatedMapping
    from exoid.measurement.recording import Recording
    from exoid.symbolic.joints import Joint
    from exoid.symbolic.mechanics.payload import Payload
    from exoid.symbolic.model import Model


@dataclass(frozen=True, eq=False)
class Inputs:
    """Inputs of a question about recordings.

    `cutoff` in Hz is that of the common filter, None: chosen; `derivative` how accelerations come from angles. `loads`
    is what is said of loads of which only the link was given.
    """

    model: Model
    recordings: tuple[Recording, ...]
    verify: tuple[Recording, ...] = ()
    cutoff: float | None = None
    derivative: str = BUTTERWORTH
    loads: tuple[Belonging, ...] = ()

    @property
    def filter(self) -> dict[str, Any]:
        """Arguments of `prepare`, and of whatever prepares, about filtering."""
        return {"cutoff": self.cutoff, "derivative": self.derivative}


def load_model(path: str | None) -> Model:
    """Return the model in the file `path`, or the standard leg for None."""
    from exoid.symbolic.model import Model

    if path is None:
        return Model.standard()
    from exoid.symbolic.model import read_model

    return read_model(path)


def load(args: argparse.Namespace) -> Inputs:
    """Read what `args` name: --model, REC..., --verify, what belongs to reading, --derivative, --payload, --wearer."""
    from exoid.measurement.forces import pushed_model
    from exoid.measurement.reading.among import read_among

    model = load_model(getattr(args, "model", None))
    model = worn(model, getattr(args, "wearer", None))
    most = getattr(args, "limit", None) or (0.0,)
    if len(most) not in (1, len(model.joints)):
        remedy = f"give one, or one per joint as {','.join(model.joint_names)}"
        raise UsageError(f"--limit has {len(most)} numbers", where="--limit", remedy=remedy)
    *groups, told = told_recordings(args, model.joint_names)
    joints = model.joints if getattr(args, "model", None) else None
    recordings, verify = (
        read_among(files, lambda path: read(path, told[path], joints=joints, quiet=args.quiet)) if files.paths else ()
        for files in groups
    )
    say_findings((*recordings, *verify), args)
    model = pushed_model(model, (*recordings, *verify))
    given = Inputs(model, recordings, verify, args.cutoff, getattr(args, "derivative", BUTTERWORTH))
    links = loaded_links(getattr(args, "payload", []), list(told))
    return _with_loads(given, links, args.quiet) if links else given


def _with_loads(given: Inputs, links: dict[str, str], quiet: bool) -> Inputs:
    """Return the inputs with what the recordings in files carry, {path: link}, and say what it is."""
    from exoid.diagnosis.own_numbers.told_loads import with_loads_weighed

    every = (*given.recordings, *given.verify)
    own = {k: links[item.source.path] for k, item in enumerate(every) if item.source.path in links}
    with progress("weighing loads", quiet=quiet):
        fitted, unseen, loads = with_loads_weighed(given.model, given.recordings, given.verify, own, **given.filter)
    for load in loads:
        warn(load.sentence)
    return replace(given, recordings=fitted, verify=unseen, loads=loads)


def worn(model: Model, wearer: str | None) -> Model:
    """Return `model` worn by the person that --wearer tells of; BodyError where it tells of none."""
    from exoid.symbolic.mechanics.body import Body

    if not wearer:
        return model
    body = Body.named(wearer)
    return model.with_wearer(body.mass, body.height)


def told_recordings(
    args: argparse.Namespace, joints: Sequence[str]
) -> tuple[FoundFiles, FoundFiles, dict[str, StatedMapping]]:
    """Return the files that `args` mean to be fitted and to be held out, and what they tell of each."""
    from exoid.measurement.reading.among import files_among
    from exoid.measurement.reading.mapping import StatedMapping

    held_out = list(getattr(args, "verify", []))
    refuse_repeats(args.recordings, held_out)
    files_among([*args.recordings, *held_out])  # so that every missing file is named at once, of both groups
    given, unseen = files_among(args.recordings), files_among(held_out)
    hidden = {os.path.realpath(path) for path in unseen.paths}
    # Of a folder or pattern what --verify names is held out, and the rest is fitted.
    fitted = tuple(path for path in given.paths if path in given.named or os.path.realpath(path) not in hidden)
    given = replace(given, paths=fitted or given.paths)
    refuse_repeats(given.paths, unseen.paths)
    every = [*given.paths, *unseen.paths]
    loads = payloads(getattr(args, "payload", []), every)
    of_all = merged(args.map, "--map"), merged(args.units, "--units"), args.leg or ""
    kept, others = conventions_of(args.convention, every), joins_of(args.join, every)
    idle = passive_joints(args.passive, every, joints)
    told = {
        path: StatedMapping(
            *of_all, ",".join(kept[path]), tuple(others[path]), tuple(idle[path]), tuple(loads.get(path, ())),
            args.condition, args.clock_rate,
        )
        for path in every
    }
    return given, unseen, told


def read(
    path: str, told: StatedMapping | None = None, *, joints: Sequence[Joint] | None = None, quiet: bool = False
) -> tuple[Recording, ...]:
    """Read one file, which holds a recording or one of each leg."""
    from exoid.measurement.reading.mapping import StatedMapping
    from exoid.measurement.reading.read import read_as_told

    # Only a file that takes more than a glance is worth a bar.
    with progress(f"reading {Path(path).name}", quiet=quiet) as report:
        return read_as_told(path, StatedMapping() if told is None else told, joints, report)


def joins_of(given: Sequence[str], paths: Sequence[str]) -> dict[str, list[tuple[str, float | None]]]:
    """Return {path: (file, lag in s or None) of every file joined to it} from FILE, FILE@LAG, REC=FILE or REC=FILE@LAG.

    Without REC there must be one recording, or as many files as recordings, which are then taken in order.
    """
    found: dict[str, list[tuple[str, float | None]]] = {path: [] for path in paths}
    plain: list[str] = []
    for text in given:
        name, _, rest = text.partition("=")
        meant = _called(name, paths)
        if not Path(text).exists() and rest and len(meant) == 1:
            found[meant[0]].append(_with_lag(rest))
        else:
            plain.append(text)
    if plain and len(paths) == 1:
        found[paths[0]] += [_with_lag(text) for text in plain]
    elif plain and len(plain) == len(paths):
        for path, text in zip(paths, plain, strict=True):
            found[path].append(_with_lag(text))
    elif plain:
        what = f"{plain[0]}: there are {len(paths)} recordings, and nothing says to which of them it belongs"
        remedy = f"write for example {paths[0] if paths else 'REC'}={plain[0]}, or one file per recording, in order"
        raise UsageError(what, where="--join", remedy=remedy)
    return found


def _called(name: str, paths: Sequence[str]) -> list[str]:
    """Return the recordings that a name means: one's path or, where that is enough, its file name."""
    return [path for path in paths if path == name] or [path for path in paths if Path(path).name == name]


def _with_lag(text: str) -> tuple[str, float | None]:
    """Return (file, lag) from FILE or FILE@LAG."""
    file, at, lag = text.rpartition("@")
    if not at or Path(text).exists():
        return text, None
    try:
        value = float(lag)
    except ValueError:
        return text, None
    if not math.isfinite(value):
        raise UsageError(f"{lag} is not a lag in s", where="--join", remedy="write for example torque.csv@0.35")
    return file, value


def conventions_of(given: Sequence[str], paths: Sequence[str]) -> dict[str, list[str]]:
    """Return {path: the names of its conventions} from texts such as flexion-positive or run4.csv=absolute-shank."""
    found: dict[str, list[str]] = {path: [] for path in paths}
    for text in given:
        name, _, names = text.partition("=")
        meant = _called(name, paths)
        for path in meant or paths:
            found[path].append(names if meant else text)
    return found


def passive_joints(given: Sequence[str], paths: Sequence[str], joints: Sequence[str] = JOINTS) -> dict[str, list[str]]:
    """Return {path: its joints without a drive} from texts such as knee or run6.csv=knee; UsageError for others."""
    found: dict[str, list[str]] = {path: [] for path in paths}
    for text in given:
        name, _, joint = text.rpartition("=")
        meant = _called(name, paths) if name else list(paths)
        if joint not in joints or not meant:
            raise UsageError(
                f"{text!r} does not name a joint{f' of a recording called {name}' if name else ''}",
                where="--passive",
                remedy=did_you_mean(name, paths)
                if name and not meant
                else f"write for example {joints[-1]}, or run6.csv={joints[-1]}",
            )
        for path in meant:
            found[path].append(joint)
    return found


def payloads(given: Sequence[str], paths: Sequence[str]) -> dict[str, list[Payload]]:
    """Return {path: its payloads} from texts such as run4.csv=2@0.35; UsageError where one names none of these."""
    found: dict[str, list[Payload]] = {}
    for path, load in _loads(given, paths):
        if not _is_link(load):
            found.setdefault(path, []).append(payload_of(load))
    return found


def loaded_links(given: Sequence[str], paths: Sequence[str]) -> dict[str, str]:
    """Return {path: the link that carries an unknown load} from texts such as run4.csv=shank; UsageError where one
    names none of the paths, or a file has two such loads.
    """
    found: dict[str, str] = {}
    for path, load in _loads(given, paths):
        if _is_link(load) and found.setdefault(path, load) != load:
            what = f"{path} has unknown loads on two links"
            raise UsageError(what, where="--payload", remedy="give kg and m of all but one: FILE=KG@M")
    return found


def _is_link(load: str) -> bool:
    return bool(JOINT_NAME.fullmatch(load))


def _loads(given: Sequence[str], paths: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield (path, load) of texts such as run4.csv=2@0.35; UsageError where one names none of the paths."""
    for text in given:
        name, _, load = text.rpartition("=")
        if not name:
            raise UsageError(
                f"{text!r} is not FILE=KG@M", where="--payload",
                remedy="write for example run4.csv=2@0.35 (kg, m), or run4.csv=shank where only the link is known",
            )  # fmt: skip
        meant = _called(name, paths)
        if len(meant) != 1:
            what = f"{name} is {'none' if not meant else 'more than one'} of the recordings given"
            remedy = did_you_mean(name, paths) or "name it as it is named among the recordings"
            raise UsageError(what, where="--payload", remedy=remedy)
        yield meant[0], load


def payload_of(text: str) -> Payload:
    """Return the payload that a text such as 2@0.35, thigh:2@0.2 or wrist:2@0,0,0.1 means; UsageError where it means
    none.
    """
    from exoid.symbolic.mechanics.payload import Payload

    link, colon, load = text.rpartition(":")
    mass, _, along = load.partition("@")
    try:
        weight, place = float(mass), tuple(float(part) for part in along.split(","))
        if len(place) not in (1, 3):
            raise ValueError("one number, or three in space")
    except ValueError:
        raise UsageError(
            f"{text!r} is not KG@M", where="--payload",
            remedy="write for example 2@0.35, thigh:2@0.2, or in space 2@0,0,0.1 (kg, m)",
        ) from None  # fmt: skip
    return Payload(weight, (place[0], place[1], place[2]) if len(place) == 3 else place[0], link if colon else "shank")


def refuse_repeats(fitted: Sequence[str], unseen: Sequence[str]) -> None:
    """Refuse a file that is named twice: counted twice it fakes certainty, and seen it is not unseen."""
    names = [os.path.realpath(path) for path in fitted]  # not resolve(), which raises where links go in a circle
    for path in fitted:
        if names.count(os.path.realpath(path)) > 1:
            raise UsageError("this recording is named twice", where=path, remedy="name it once")
    for path in unseen:
        if os.path.realpath(path) in names:
            remedy = "a recording that was fitted cannot show how well unseen motion is predicted"
            raise UsageError("this recording is both fitted and in --verify", where=path, remedy=remedy)


def split_joint(text: str, joints: Sequence[str] = JOINTS) -> tuple[str, str | None]:
    """Return ("stribeck", "knee") for "stribeck:knee"; raises UsageError for a joint that does not exist."""
    effect, colon, joint = text.partition(":")
    if not effect or (colon and joint not in joints):
        example = f"write for example stribeck:{joints[-1]}; joints are {' and '.join(joints)}"
        what = f"{text!r} does not name an effect"
        raise UsageError(what, where="EFFECT[:joint]", remedy=did_you_mean(joint, joints) or example)
    return effect, joint or None


def check_new_model(target: str, source: str | None, named: bool = True) -> None:
    """Refuse a model file that would overwrite the one it comes from or what is no model, or cannot be written; and
    where the user has not `named` the file, one that exoid did not write.
    """
    from exoid.ground.output import OutputError, check_result, check_target

    if target == "-":
        raise OutputError("a model is written to a file", where=target, remedy="name a file ending in .toml")
    if source is not None and os.path.realpath(target) == os.path.realpath(source):
        what = "this would overwrite the model it was made from"
        raise OutputError(what, where=target, remedy="choose another file name")
    if not named:
        check_result(target)
        return
    check_target(target, _is_model)


MODEL_KEYS = frozenset(
    ("name", "geometry", "gravity", "joints", "base", "limits", "effects", "custom_effects", "identified")
)


def _is_model(content: bytes) -> bool:
    """True if a file that begins so is a model file, or empty: every line of its beginning is TOML of a model."""
    text = content.decode("utf-8", "replace")
    lines = (line.strip() for line in text.splitlines())
    first = next((line for line in lines if line and not line.startswith("#")), None)
    return first is None or ((found := re.match(r"\[*\s*(\w+)", first)) is not None and found[1] in MODEL_KEYS)


def beside(source: str | None, suffix: str) -> str:
    """Return a free file name next to the model `source`: leg.toml becomes leg+stribeck-knee.toml."""
    base = Path("leg.toml") if source is None else Path(source)
    for count in range(1, 1000):
        tail = "" if count == 1 else f"-{count}"
        name = base.with_name(f"{base.stem}+{suffix.replace(':', '-')}{tail}.toml")
        if not os.path.lexists(name):  # a link that leads nowhere would be followed
            return str(name)
    raise UsageError("there are a thousand such models already", where=str(base.parent), remedy="use --write FILE")
