"""Recordings as a verb is given them, one or many: recordings, paths, folders, tables, arrays, in any mixture."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from exoid.ground.errors import ExoidError, RecordingError
from exoid.ground.files import MODEL_FILES
from exoid.measurement.reading.frames import is_table
from exoid.measurement.reading.read import read_recording, read_recordings
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model, read_model

Given: TypeAlias = Recording | str | Path | Mapping[str, Any] | Iterable[Any]
"""A recording, a path, folder, pattern or archive, a DataFrame, a mapping {name: array}, an array with the columns t,
q1, ..., tau1, ..., or several of these."""
TAKEN = (
    "give a recording, a path, a folder, a DataFrame, a mapping {name: array}, an array with the columns t, q1, ..., "
    "tau1, ..., or a list of these"
)
Asked = TypeVar("Asked")


def recordings_in(given: Given | None, joints: Sequence[Joint] | None = None) -> tuple[Recording, ...]:
    """Return the recordings in `given`, read and audited where they are not yet, as ones of a machine with `joints`.

    RecordingError for what is none and for what cannot be read.
    """
    if given is None:
        return ()
    several = not (_is_one(given) or isinstance(given, (Model, Mapping)))
    parts = list(given) if several and isinstance(given, Iterable) else [given]
    tables = sum(is_table(part) for part in parts)
    found: list[Recording] = []
    for place, part in enumerate(parts, start=1):
        if isinstance(part, Recording):
            found.append(part)
        elif isinstance(part, (str, Path)):
            found += read_recordings(part, joints=joints)
        elif is_table(part):
            found.append(read_recording(part, name=f"table {place}" if tables > 1 else "", joints=joints))
        else:
            what = f"a {type(part).__name__} is not a recording"
            raise RecordingError(what, where=f"number {place} of {len(parts)}" if several else "", remedy=TAKEN)
    return tuple(found)


def _holds_recordings(given: Any) -> bool:
    if isinstance(given, (str, Path)):
        return Path(given).suffix.lower() not in MODEL_FILES
    return _is_one(given) or isinstance(given, (list, tuple))


def one_recording(given: Given, joints: Sequence[Joint] | None = None) -> Recording:
    """Return the one recording in `given`; RecordingError where there are several."""
    found = recordings_in(given, joints)
    if len(found) != 1:
        raise RecordingError(f"{len(found)} recordings, and one is watched at a time", remedy="give one of them")
    return found[0]


def _is_one(given: Any) -> bool:
    return isinstance(given, (Recording, str, Path)) or is_table(given)


def question_of(
    model: Any, recordings: Given | None = None, verify: Given | None = ()
) -> tuple[Any, tuple[Recording, ...], tuple[Recording, ...]]:
    """Model or fit, and recordings, as a verb needs them; a path to a model file is read. Recordings alone, in either
    place, are of the standard leg.

    ExoidError where the first is no model, RecordingError where there are no recordings or what is given is none.
    """
    if recordings is None and _holds_recordings(model):
        model, recordings = None, model
    if recordings is None:
        raise RecordingError("there are no recordings", remedy=f"after the model, {TAKEN}")
    machine = model_of(Model.standard() if model is None else model)
    joints = machine_of(machine).joints
    unseen = recordings_in(verify, joints)
    return machine, _beside(recordings_in(recordings, joints), unseen, recordings), unseen


def _beside(found: tuple[Recording, ...], unseen: tuple[Recording, ...], given: Any) -> tuple[Recording, ...]:
    """The recordings `found` in what was `given`, without files of a folder or pattern that are held out."""
    hidden = {os.path.realpath(item.source.path) for item in unseen if item.source.path}
    parts = given if isinstance(given, (list, tuple)) else [given]
    named = {os.path.realpath(part) for part in parts if isinstance(part, (str, Path))}
    own = {id(part) for part in parts}
    return tuple(
        item for item in found if id(item) in own or os.path.realpath(item.source.path) not in hidden - named
    ) or found  # fmt: skip


def model_of(model: Asked) -> Asked:
    """Return the model, the fit, that of an answer, or what a model file says; ExoidError for anything else."""
    if isinstance(model, (str, Path)):
        return read_model(model)  # type: ignore[return-value]
    own, fit = machine_of(model), getattr(model, "fit", None)
    if isinstance(model, Model) or hasattr(model, "estimates"):
        return model
    return own if fit is None else fit  # type: ignore[return-value]


def machine_of(model: Any) -> Model:
    """Return a model, or that of a fit or an answer; ExoidError for anything else."""
    own = model if isinstance(model, Model) else getattr(model, "model", None)
    own = getattr(getattr(model, "fit", None), "model", None) if own is None else own
    if isinstance(own, Model):
        return own
    swapped = " (the recordings come second)" if isinstance(model, (Recording, list, tuple)) or is_table(model) else ""
    remedy = "give exoid.Model.standard(), a Model of other joints, a fit, or the path of a model file"
    raise ExoidError(f"the model comes first, and a {type(model).__name__} is none{swapped}", remedy=remedy)
