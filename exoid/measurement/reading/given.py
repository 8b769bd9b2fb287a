"""What a verb is given as recordings, one or many: recordings, paths, folders, tables, arrays, in any mixture."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from exoid.ground.errors import ExoidError, RecordingError
from exoid.measurement.reading.frames import is_table
from exoid.measurement.reading.read import read_recording, read_recordings
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.model_file import read_model

Given: TypeAlias = Recording | str | Path | Mapping[str, Any] | Iterable[Any]
"""A recording, a path, folder, pattern or archive, a DataFrame, a mapping {name: array}, an array with the columns t,
q1, ..., tau1, ..., or several of these."""
TAKEN = (
    "give a recording, a path, a folder, a DataFrame, a mapping {name: array}, an array with the columns t, q1, ..., "
    "tau1, ..., or a list of these"
)
Asked = TypeVar("Asked")
Verb = TypeVar("Verb", bound=Callable[..., Any])


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


def of_the_leg(verb: Verb) -> Verb:
    """Let a verb (`model`, recordings, ...) take recordings alone: they are of the standard leg then, as on the command
    line without `--model`.
    """
    names = list(inspect.signature(verb).parameters)
    place = names.index("model")
    recordings = names[place + 1]

    @functools.wraps(verb)
    def asked(*given: Any, **named: Any) -> Any:
        alone = given[place:]
        if "model" not in named and recordings in named and not alone:
            named["model"] = Model.standard()
        elif "model" not in named and recordings not in named and len(alone) == 1 and _holds_recordings(alone[0]):
            given = (*given[:place], Model.standard(), *alone)
        return verb(*given, **named)

    return asked  # type: ignore[return-value]


def _holds_recordings(given: Any) -> bool:
    if isinstance(given, (str, Path)):
        return Path(given).suffix.lower() != ".toml"
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
    model: Asked, recordings: Given | None, verify: Given | None = ()
) -> tuple[Asked, tuple[Recording, ...], tuple[Recording, ...]]:
    """Return model and recordings as a verb needs them; a path to a model file is read, a fit is kept.

    ExoidError where the first is no model, RecordingError where the others are no recordings.
    """
    machine = model_of(model)
    joints = machine_of(machine).joints
    return machine, recordings_in(recordings, joints), recordings_in(verify, joints)


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
