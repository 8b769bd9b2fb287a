"""A model as a TOML file a person can edit. Nothing in it is ever executed; every refusal names file, line and key.

`[[custom_effects]]` tables define effects in the same torque language as the catalogue's. They join the catalogue, so
that a diagnosis considers them; an `[[effects]]` table puts any effect, custom or not, into the model itself.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from exoid.ground.errors import EffectError, ExoidError, ExpressionError, ModelFileError
from exoid.ground.files import ROBOT_FILE, write_whole
from exoid.ground.ours import WRITTEN
from exoid.ground.toml_reader import Table, read_toml
from exoid.symbolic.custom_effect import read_custom_effect
from exoid.symbolic.effect import Effect
from exoid.symbolic.force import Force
from exoid.symbolic.joints import (
    HEAVIEST,
    LEG,
    LIGHTEST,
    SHORTEST,
    Joint,
    Origin,
    check_joints,
    is_leg,
    is_spatial,
    motors_of,
    names,
)
from exoid.symbolic.mechanics.body import BodyError
from exoid.symbolic.model_structure import TABLE_1, UNLIMITED, Limits, ModelStructure
from exoid.symbolic.quantity import JOINTS, Estimate
from exoid.symbolic.robot_file import read_robot
from exoid.symbolic.spatial_machine import robot_structure

if TYPE_CHECKING:
    from collections.abc import Sequence

IDENTIFIED = "identified"
"""In place of a number of a measured force: the recordings are to tell it."""
LARGEST_FILE = 1_000_000
"""Bytes; a model file has a few thousand, and anything this large is another kind of file."""


class Identified(Protocol):
    """The part of a fit that is written into a model file."""

    @property
    def estimates(self) -> Sequence[Any]: ...  # noqa: D102
    @property
    def delta(self) -> Any: ...  # noqa: D102


@dataclass(frozen=True, eq=False)
class Numbers:
    """Identified numbers read from a model file: {name: value} of `linear` and `shape`, `delta` (J,) N·m or None."""

    linear: Mapping[str, float]
    shape: Mapping[str, float]
    delta: tuple[float, ...] | None


def read_structure(path: str | Path) -> ModelStructure:
    """Read what the model of a file consists of, or the machine of all joints that move in a robot's URDF.

    ModelFileError says what is wrong, in which line, and what to do; of a URDF, RobotFileError does.
    """
    if Path(path).suffix.lower() == ROBOT_FILE:
        return robot_structure(read_robot(path), where=str(path)).model
    return _model(_load(path))


def read_numbers(path: str | Path) -> Numbers | None:
    """Read the `[identified]` numbers of a model file; None where it has none, as a URDF, ModelFileError where they are
    wrong.
    """
    if Path(path).suffix.lower() == ROBOT_FILE:
        return None
    top = _load(path)
    model = _model(top)
    if "identified" not in top.values:
        return None
    table = top.table("identified")
    found = {key: table.table(key) for key in ("parameters", "shape") if key in table.values}
    linear = _values(found.get("parameters"), [p.name for p in model.parameters])
    shape = _values(found.get("shape"), [s.name for s in model.shapes])
    delta = tuple(table.numbers("delta", len(model.joints), low=0.0)) if "delta" in table.values else None
    return Numbers(linear, shape, delta)


def write_model(model: ModelStructure, path: str | Path, fit: Identified | None = None) -> Path:
    """Write `model`, with the numbers of `fit` where given; see `Model.save`."""
    import tomli_w

    return write_whole(path, f"# {WRITTEN}.\n{tomli_w.dumps(model_content(model, fit))}")


def model_content(model: ModelStructure, fit: Identified | None = None) -> dict[str, Any]:
    """Return the content of the model file as plain data."""
    content: dict[str, Any] = {"name": model.name}
    if model.chain:
        pull = model.gravity if model.gravity_vector is None else list(model.gravity_vector)
        content |= {"gravity": pull, "joints": [_joint_content(model, joint) for joint in model.chain]}
        content |= {"base": {"motion": "measured"}} if model.moving_base else {}
        if coupled := [joint for joint in model.chain if joint.motor]:
            content["couplings"] = [{"motor": joint.name, "turns": dict(joint.motor)} for joint in coupled]
    else:
        content["geometry"] = {"thigh_length": model.thigh_length, "gravity": model.gravity}
        content["limits"] = {
            joint: {"angle": list(limit.angle), "velocity": limit.velocity, "acceleration": limit.acceleration}
            for joint, limit in model.limits.items()
        }
    if model.wearer is not None:
        content["wearer"] = {"mass": model.wearer.mass, "height": model.wearer.height}
    if model.forces:
        content["forces"] = [_force_content(force) for force in model.forces]
    if model.terms:
        content["effects"] = [
            {
                "id": term.effect.id,
                **({} if term.joint is None else {"joint": term.joint}),
                **({"own_places": True} if term.own_places else {}),
            }
            for term in model.terms
        ]
    custom = {effect.id: effect for effect in (*model.custom, *(t.effect for t in model.terms if t.effect.custom))}
    if custom:
        content["custom_effects"] = [custom_content(effect) for effect in custom.values()]
    if fit is not None:
        content["identified"] = _identified_content(model, fit)
    return content


def _joint_content(model: ModelStructure, joint: Joint) -> dict[str, Any]:
    """Return a joint and its limits; what is left out stays left out."""
    content: dict[str, Any] = {"name": joint.name, "kind": joint.kind, "length": joint.length, "parent": joint.parent}
    if joint.axis is not None:
        content["axis"] = list(joint.axis)
    if joint.origin is not None:
        content["origin"] = {"xyz": list(joint.origin.xyz), "rpy": list(joint.origin.rpy)}
    if joint.body:
        mass, *others = joint.body
        content["body"] = {"mass": mass, "centre": others[:3], "inertia": others[3:]}
    limit = model.limits.get(joint.name)
    if limit is not None:
        ends = list(limit.angle) if math.isfinite(limit.angle[0]) else None
        content |= {"position": ends, "velocity": limit.velocity, "acceleration": limit.acceleration}
    return {key: value for key, value in content.items() if value is not None and value != math.inf}


def _force_content(force: Force) -> dict[str, Any]:
    """Return a measured force as the file has it; what is left out is identified, or as usual."""
    content: dict[str, Any] = {"name": force.name, "link": force.link, "columns": list(force.columns)}
    if force.at is not None:
        content["at"] = list(force.at) if isinstance(force.at, tuple) else force.at
    if any(force.rpy):
        content["rpy"] = list(force.rpy)
    if force != replace(force, frame=""):
        content["frame"] = force.frame
    content |= {"sign": force.sign} if force.sign != 1 else {}
    for key, usual in (("gain", 1.0), ("delay", 0.0)):
        value = getattr(force, key)
        if value != usual:
            content[key] = IDENTIFIED if value is None else value
    return content


def custom_content(effect: Effect) -> dict[str, Any]:
    """Return a custom effect as plain data; ModelFileError for one that is derived in Python."""
    if effect.torque is None:
        what = "an effect that changes the mechanism needs Python and cannot be written to TOML"
        remedy = "add it as a file in exoid/symbolic/effects/"
        raise ModelFileError(what, where=f"custom effect {effect.id}", remedy=remedy)
    content: dict[str, Any] = {"id": effect.id, "explains": effect.explains}
    if effect.on_both:
        content["joint"] = "both"
    elif len(effect.joints) == 1:
        content["joint"] = effect.joints[0]
    content["torque"] = effect.torque if isinstance(effect.torque, str) else dict(effect.torque)
    for field in ("coefficients", "shape"):
        declared = getattr(effect, field)
        if declared:
            content[field] = {key: _declaration(value) for key, value in declared.items()}
    for field in ("title", "family", "tells_apart", "reference"):
        if getattr(effect, field) not in ("", "other", "no reference given"):
            content[field] = getattr(effect, field)
    return content


def _declaration(value: Any) -> dict[str, Any]:
    kept = {}
    for field in dataclasses.fields(value):
        item = getattr(value, field.name)
        if field.name == "unit" or (item is not None and item != field.default):
            kept[field.name] = list(item) if isinstance(item, tuple) else item
    return kept


def _identified_content(model: ModelStructure, fit: Identified) -> dict[str, Any]:
    content: dict[str, Any] = {}
    estimates = {estimate.name: estimate for estimate in fit.estimates}
    for group, known in (("parameters", model.parameters), ("shape", model.shapes)):
        content[group] = {entry.name: _ends(estimates[entry.name]) for entry in known if entry.name in estimates}
    if fit.delta is not None:
        content["delta"] = [float(value) for value in fit.delta]
    return {key: value for key, value in content.items() if value}


def _ends(estimate: Estimate) -> dict[str, Any]:
    """Return an estimate as the file keeps it; an interval that nothing determines stays infinite."""
    value, low, high = map(float, (estimate.value, estimate.low, estimate.high))
    return {"value": value, "unit": estimate.unit, "low": low, "high": high}


def _load(path: str | Path) -> Table:
    remedy = "mend that line, or give the model file (TOML) that exoid identify --write FILE or exoid add wrote"
    return read_toml(path, LARGEST_FILE, ModelFileError, what="model file", remedy=remedy)


def _model(top: Table) -> ModelStructure:
    top.only(
        "name", "geometry", "limits", "gravity", "joints", "base", "couplings", "wearer", "forces", "effects",
        "custom_effects", "identified",
    )  # fmt: skip
    if "identified" in top.values:
        top.table("identified").only("parameters", "shape", "delta", "loss", "rms")
    model = _worn(_machine(top) if "joints" in top.values else _leg(top), top)
    model = _pushed(model, top.tables("forces"))
    for entry in top.tables("effects"):
        entry.only("id", "joint", "own_places")
        joint, own = entry.text("joint", ""), entry.flag("own_places")
        try:
            model = model.with_effect(entry.text("id"), joint if joint not in ("", "both") else None, own_places=own)
        except ExoidError as error:
            raise entry.error("joint" if joint and "joint" in str(error) else "id", error.what, error.remedy) from error
    return model


def _worn(model: ModelStructure, top: Table) -> ModelStructure:
    """Return `model` with the person of a file's [wearer]."""
    if "wearer" not in top.values:
        return model
    person = top.table("wearer")
    person.only("mass", "height")
    try:
        return model.with_wearer(person.number("mass"), person.number("height"))
    except BodyError as error:
        key = next((key for key in person.values if f"whose {key} is" in error.what), "")
        place = person if key else top
        raise place.error(key or "wearer", error.what, error.remedy) from error


def _pushed(model: ModelStructure, entries: Sequence[Table]) -> ModelStructure:
    """Return `model` with the measured forces of a file's [[forces]]."""
    for entry in entries:
        entry.only("name", "link", "at", "columns", "frame", "sign", "gain", "delay", "rpy")
        at: Any = entry.values.get("at")
        at = tuple(at) if isinstance(at, list) else None if at is None else entry.number("at")
        gain = None if entry.values.get("gain") == IDENTIFIED else entry.number("gain", 1.0)
        delay = entry.number("delay", 0.0)
        sign = entry.number("sign", 1.0)
        try:
            named = entry.text("name"), entry.text("link"), tuple(entry.texts("columns"))
            whole = int(sign) if sign in (1.0, -1.0) else 0
            turned = entry.values.get("rpy", [0.0, 0.0, 0.0])
            force = Force(*named, at, entry.text("frame", ""), gain, delay, whole, turned)
            model = model.with_forces(*model.forces, force)
        except EffectError as error:
            key = next((key for key in entry.values if error.what.startswith(f"{key} is")), "name")
            raise entry.error(key, error.what, error.remedy) from error
    return model


def _leg(top: Table) -> ModelStructure:
    """Return the leg of a file that has [geometry] and [limits.hip], [limits.knee]."""
    for key in ("gravity", "base", "couplings"):
        if key in top.values:
            raise top.error(key, f"{key} belongs to a file with [[joints]]", "write gravity below [geometry]")
    geometry = top.table("geometry") if "geometry" in top.values else top.child("geometry", {})
    geometry.only("thigh_length", "gravity")
    return ModelStructure(
        name=top.text("name", "unnamed leg"),
        thigh_length=geometry.number("thigh_length", 0.40, least=SHORTEST, below=2.0),
        gravity=geometry.number("gravity", 9.81, least=LIGHTEST, below=HEAVIEST),
        limits=_limits(top),
        custom=_custom_effects(top, LEG),
    )


def _machine(top: Table) -> ModelStructure:
    """Return the machine of a file with [[joints]]: two that are hip and knee are the leg."""
    for key in ("geometry", "limits"):
        if key in top.values:
            raise top.error(key, f"{key} does not go with [[joints]]", "write lengths and limits below each joint")
    moving = _moving_base(top)
    vector = isinstance(top.values.get("gravity"), list)
    pull = tuple(top.numbers("gravity", 3)) if vector else ()
    gravity = math.hypot(*pull) if vector else top.number("gravity", 9.81, least=0.0, below=HEAVIEST)
    if gravity and not LIGHTEST <= gravity < HEAVIEST:
        remedy = "give m/s²: " + ("[0, 0, -9.81]" if vector else "9.81, or 0 where none acts in its plane")
        raise top.error("gravity", f"gravity is {gravity:g} m/s²", remedy)
    entries = top.tables("joints")
    joints = _coupled(tuple(_joint(entry) for entry in entries), top.tables("couplings"))
    try:
        check_joints(joints)
    except EffectError as error:
        found = re.match(r"joint (\d+)", error.where)
        place = entries[int(found[1]) - 1] if found else top
        raise place.error("name" if found else "joints", error.what, error.remedy) from error
    given = {joint.name: _joint_limits(entry) for joint, entry in zip(joints, entries, strict=True)}
    limits = {joint: limit for joint, limit in given.items() if limit is not None}
    name = top.text("name", "unnamed machine")
    if pull and not is_spatial(joints):
        raise top.error("gravity", "gravity is a vector, and no joint has an axis", "give a number, m/s² downwards")
    if gravity > 0.0 and not moving and is_leg(joints) and not any(joint.motor for joint in joints):
        known = {joint: limits.get(joint, UNLIMITED).filled(usual) for joint, usual in TABLE_1.items()}
        custom = _custom_effects(top, LEG)
        return ModelStructure(name, float(joints[0].length or 0.0), gravity, known, custom=custom)
    custom = _custom_effects(top, joints)
    vector_given = (pull[0], pull[1], pull[2]) if pull else None
    return ModelStructure(
        name, gravity=gravity, limits=limits, custom=custom, joints=joints, moving_base=moving,
        gravity_vector=vector_given,
    )  # fmt: skip


def _coupled(joints: tuple[Joint, ...], entries: Sequence[Table]) -> tuple[Joint, ...]:
    """Return `joints` with the motors of a file's [[couplings]]."""
    known = names(joints)
    found: dict[str, tuple[tuple[str, float], ...]] = {}
    for entry in entries:
        entry.only("motor", "turns")
        motor, turns = entry.text("motor"), entry.table("turns")
        turns.only(*known)
        if motor not in known or motor in found:
            what = f"there are two couplings of the motor of {motor}" if motor in found else f"no joint {motor!r}"
            raise entry.error("motor", what, f"give each motor once, by its joint: {', '.join(known)}")
        found[motor] = tuple((name, turns.number(name)) for name in turns.values)
        if not found[motor] or not all(ratio for _, ratio in found[motor]):
            remedy = f"give the motor's rad for 1 rad of each joint: turns = {{ {motor} = 100.0 }}"
            raise entry.error("turns", "a motor that turns with nothing", remedy)
    made = tuple(replace(joint, motor=found.get(joint.name, ())) for joint in joints)
    try:
        motors_of(made)
    except EffectError as error:
        raise entries[-1].error("turns", error.what, error.remedy) from error
    return made


def _moving_base(top: Table) -> bool:
    """True if the file says that the base moves and recordings say how."""
    if "base" not in top.values:
        return False
    base = top.table("base")
    base.only("motion")
    if base.text("motion", "fixed") not in ("fixed", "measured"):
        raise base.error("motion", f"unknown motion {base.text('motion')!r}", 'use "fixed" or "measured"')
    return base.text("motion", "fixed") == "measured"


def _joint(entry: Table) -> Joint:
    entry.only("name", "kind", "length", "parent", "axis", "origin", "body", "position", "velocity", "acceleration")
    length = entry.number("length", least=0.0) if "length" in entry.values else None
    parent = entry.text("parent") if "parent" in entry.values else None
    axis, origin = None, None
    if "axis" in entry.values:
        x, y, z = entry.numbers("axis", 3)
        axis = x, y, z
        if not any(axis):
            raise entry.error("axis", "an axis has the length zero", "give its direction, such as [0, 0, 1]")
    if "origin" in entry.values:
        place = entry.table("origin")
        place.only("xyz", "rpy")
        (x, y, z), (roll, pitch, yaw) = (
            place.numbers(key, 3) if key in place.values else [0.0, 0.0, 0.0] for key in ("xyz", "rpy")
        )
        try:
            origin = Origin((x, y, z), (roll, pitch, yaw))
        except EffectError as error:
            raise entry.error("origin", error.what, error.remedy) from error
    body: tuple[float, ...] = ()
    if "body" in entry.values:
        said = entry.table("body")
        said.only("mass", "centre", "inertia")
        body = (said.number("mass", above=0.0), *said.numbers("centre", 3), *said.numbers("inertia", 6))
    return Joint(entry.text("name"), entry.text("kind", "revolute"), length, parent, axis, origin, body=body)


def _joint_limits(entry: Table) -> Limits | None:
    """Return the limits below a joint, infinite where one is left out; None where there are none."""
    if not {"position", "velocity", "acceleration"} & entry.values.keys():
        return None
    return _limits_of(entry, "position", UNLIMITED)


def _limits(top: Table) -> Mapping[str, Limits]:
    if "limits" not in top.values:
        return TABLE_1
    table = top.table("limits")
    table.only(*JOINTS)
    for own in (table.table(joint) for joint in table.values):
        own.only("angle", "velocity", "acceleration")
    given = {joint: _limits_of(table.table(joint), "angle", TABLE_1[joint]) for joint in table.values}
    return {**TABLE_1, **given}


def _limits_of(entry: Table, key: str, usual: Limits) -> Limits:
    """Return the limits in a table, the range as its `key`, `usual` ones where they are left out."""
    low, high = entry.numbers(key, 2) if key in entry.values else usual.angle
    if not low < high:
        raise entry.error(key, f"the range [{low}, {high}] is empty", "give [low, high] with low < high")
    rates = (entry.number(name, getattr(usual, name), above=0.0) for name in ("velocity", "acceleration"))
    return Limits((low, high), *rates)


def _custom_effects(top: Table, machine: tuple[Joint, ...]) -> tuple[Effect, ...]:
    found: dict[str, Effect] = {}
    for entry in top.tables("custom_effects"):
        try:
            effect = read_custom_effect(entry, machine)
        except ExpressionError as error:
            raise ExpressionError(
                error.what, where=f"{entry.place('torque')}:\n{error.where}", remedy=error.remedy
            ) from error
        if effect.id in found:
            raise entry.error("id", f"there are two custom effects called {effect.id!r}", "rename one")
        found[effect.id] = effect
    return tuple(found.values())


def _values(table: Table | None, known: list[str]) -> dict[str, float]:
    """Return {name: value}; a value may stand alone or in a table with its unit and interval."""
    if table is None:
        return {}
    table.only(*known)
    found = {}
    for name, value in table.values.items():
        found[name] = table.table(name).number("value") if isinstance(value, dict) else table.number(name)
    return found
