"""Identity of models, processors and versions of this code: the parts of every cache key."""

from __future__ import annotations

import json
import platform
import sys
from collections.abc import Mapping
from dataclasses import astuple
from functools import lru_cache
from pathlib import Path
from types import CodeType
from typing import TYPE_CHECKING, Any

from exoid.ground.files import sha256
from exoid.symbolic.joints import HERE, Joint

if TYPE_CHECKING:
    from exoid.symbolic.effect import Effect
    from exoid.symbolic.model_structure import ModelStructure
    from exoid.symbolic.term import Term

GENERATING = ("language", "mechanics", "codegen")
"""Folders of `symbolic/` whose code decides what is generated."""


def model_key(model: ModelStructure) -> str:
    """Return the hash of everything the numbers of a model depend on, plus its name and limits."""
    limits = {joint: [*limit.angle, limit.velocity, limit.acceleration] for joint, limit in model.limits.items()}
    own = [[effect.id, effect.joints, repr(effect.torque)] for effect in model.custom]
    return sha256(canonical_json({"name": model.name, "limits": limits, "custom": own, **model_data(model)}))


@lru_cache(maxsize=1024)  # each is asked for thousands of times
def equations_key(model: ModelStructure) -> str:
    """Return the hash of the model's equations alone: models that differ in name or limits share it."""
    return sha256(canonical_json(model_data(model)))


def model_data(model: ModelStructure) -> dict[str, Any]:
    """Return the content that decides the equations, as plain data."""
    content: dict[str, Any] = {"thigh_length": model.thigh_length.hex()}
    if model.chain:
        content = {"joints": [joint_record(joint) for joint in model.chain]}
        content |= {"base": "measured"} if model.moving_base else {}
    if model.gravity_vector is not None:
        content["pull"] = [value.hex() for value in model.gravity_vector]
    if model.forces:
        content["forces"] = [astuple(force) for force in model.forces]
    return {**content, "gravity": model.gravity.hex(), "terms": [term_content(term) for term in model.terms]}


def joint_record(joint: Joint) -> dict[str, Any]:
    """Return a joint as plain data."""
    record = {"name": joint.name, "kind": joint.kind, "length": joint.length, "parent": joint.parent}
    if joint.axis is None:
        return record
    origin = joint.origin or HERE
    return record | {"axis": list(joint.axis), "origin": [*origin.xyz, *origin.rpy]}


def term_content(term: Term) -> dict[str, Any]:
    """Return the content of a term that decides its equations and the names of its numbers."""
    effect: Effect = term.effect
    torque = dict(effect.torque) if isinstance(effect.torque, Mapping) else effect.torque
    return {
        "name": term.name,
        "torque": torque,
        "deflection": None if effect.deflection is None else dict(effect.deflection),
        "derive": None if effect.derive is None else code_content(effect.derive),
        "coefficients": list(effect.coefficients),
        "shape": list(effect.shape),
    }


def code_content(function: Any) -> Any:
    """Content of a Python function as plain data: its code, its constants, its defaults and its
    closure.
    """
    code = getattr(function, "__code__", None)
    if code is None:
        return repr(function)
    if function.__doc__ is not None and function.__doc__ in code.co_consts:
        code = code.replace(co_consts=tuple(None if c == function.__doc__ else c for c in code.co_consts))
    closure = [repr(cell.cell_contents) for cell in function.__closure__ or ()]
    return [_code(code), repr(function.__defaults__), closure, platform.python_version()]


def _code(code: CodeType) -> list[Any]:
    constants = [_code(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts]
    return [code.co_code.hex(), constants, list(code.co_names), list(code.co_varnames)]


def canonical_json(content: Any) -> str:
    """Return JSON with one spelling per content."""
    return json.dumps(content, sort_keys=True, ensure_ascii=True, separators=(",", ":"))


@lru_cache(maxsize=1)
def generator_key() -> str:
    """Return the hash of the code that derives and generates: any change in it makes every compiled model stale."""
    folder = Path(__file__).parents[1]
    files = [path for part in GENERATING for path in sorted((folder / part).glob("*.*"))]
    return sha256("".join(sha256(path.read_bytes()) for path in files))


@lru_cache(maxsize=1)
def library_versions() -> dict[str, str]:
    """Return the versions of the libraries the equations pass through, without importing them."""
    return {name: _version(name) for name in ("sympy", "casadi")}


def _version(name: str) -> str:
    """Return a package's version from the name of its folder of metadata; importlib.metadata takes 20 ms to import."""
    for place in sys.path:
        found = sorted(Path(place or ".").glob(f"{name}-*.dist-info"))
        if len(found) == 1:
            return found[0].name.removeprefix(f"{name}-").removesuffix(".dist-info")
        if found:
            break
    from importlib import metadata

    return metadata.version(name)


@lru_cache(maxsize=1)
def processor() -> str:
    """Processor as -march=native depends on it: the processor's model and its instruction sets."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return " ".join((platform.machine(), platform.processor()))
    first = text.split("\n\n", 1)[0].splitlines()
    return "\n".join(line for line in first if line.startswith(("model name", "flags", "Features", "CPU part")))
