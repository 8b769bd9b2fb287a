"""A session kept in a folder: what was opened, said and found, written whole and opened again."""

from __future__ import annotations

import json
import math
import os
from dataclasses import astuple
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from exoid.apps.page import recent
from exoid.apps.page.folder import LARGEST, SESSION, SessionFolder, inside
from exoid.apps.page.given import FIT, VERIFY
from exoid.apps.page.takeaway import MODEL, REPORT, model_toml, report
from exoid.ground.errors import ExoidError, RecordingError, refused
from exoid.ground.files import write_whole
from exoid.ground.inputs import read_input
from exoid.ground.lock import LOCK, FolderHeld
from exoid.ground.ours import says_so
from exoid.ground.plain import SPOILT, plain

if TYPE_CHECKING:
    from exoid.apps.page.workspace import Workspace

SCHEMA = "exoid.session/1"


def save(workspace: Workspace, folder: Path) -> Path:
    """Keep the session in a folder that `exoid open FOLDER` opens again; everything or nothing new is in it.

    RecordingError where something else is there, or another process keeps its session there.
    """
    place = _held(workspace, free_for_session(folder))
    what, remedy = "the session cannot be saved ({})", "choose a folder that may be written to"
    try:
        with place.writing, refused(RecordingError, what, place.folder, remedy):
            _write(workspace, place)
    except BaseException:
        if place is not workspace.keeping.place:
            place.release()
        raise
    workspace.saved = place.folder
    _keep(workspace, place)
    return place.folder


def _write(workspace: Workspace, place: SessionFolder) -> None:
    """Write recordings first, then the session, in one step, and then what follows from it."""
    place.check()
    entries = []
    for item in list(workspace.given):
        digest = item.recordings[0].source.sha256 if item.recordings and not item.told.join else ""
        entries.append({
            "file": place.copy(item.path, item.name, digest), "name": item.name, "role": item.role,
            "join": [(place.copy(Path(file), f"joined-{Path(file).name}"), lag) for file, lag in item.told.join],
            "columns": item.told.columns, "units": item.told.units, "leg": item.told.leg, "passive": item.told.passive,
            "only": item.told.only, "rate": item.told.rate,
            "convention": list(filter(None, item.told.convention.split(","))),
            "payloads": [astuple(load) for load in item.told.payloads],
        })  # fmt: skip
    base = None if workspace.model_path is None else place.copy_base(workspace.model_path)
    content = {
        "schema": SCHEMA, "recordings": entries, "history": workspace.history.to_json(),
        "base": base, "model": workspace.model_name,
        "own_effects": list(workspace.own_texts.values()), "seed": workspace.seed, "cutoff": workspace.cutoff,
        "derivative": workspace.derivative,
        "verdicts": [{"effects": sorted(names), "found": entry} for names, entry in list(workspace.verdicts.items())],
    }  # fmt: skip
    before = _named(place)
    place.write(json.dumps(plain(content), indent=1, ensure_ascii=False))
    write_whole(place.folder / MODEL, model_toml(workspace), at_once=True, inside=place.folder)
    place.tidy(_files(content), before, workspace.place)


def _named(place: SessionFolder) -> list[str]:
    """Return the files that the session there names so far; none where it cannot be understood."""
    try:
        return _files(json.loads(place.present()))
    except SPOILT:
        return []


def _files(content: Any) -> list[str]:
    """Return the names of the files that the content of a session.json names."""
    entries = [name for item in content["recordings"] for name in (item["file"], *(file for file, _ in item["join"]))]
    return [str(name) for name in (*entries, content["base"]) if name]


def free_for_session(folder: Path) -> Path:
    """Return a folder in which a session may be kept; RecordingError where something else is there."""
    target = folder.expanduser()
    if target.exists() and not (
        target.is_dir() and (is_session(target) or _is_empty(target))
    ):
        what = "there is something else"
        raise RecordingError(what, where=str(target), remedy="choose a new folder, or one that exoid saved before")
    return target


def reopen(workspace: Workspace, folder: Path, kept: bool = True) -> None:
    """Open a session that was saved, and go on keeping it there unless `kept` is False; RecordingError where the folder
    holds none that can be understood, or another process keeps it.
    """
    place = None
    if kept:
        try:
            place = _held(workspace, folder)
        except RecordingError as error:
            if isinstance(error.__cause__, FolderHeld):
                raise
            workspace.keeping.unkept = error  # it may not be written to, but may be looked at
    try:
        _take_in(workspace, folder, place)
    except (OSError, *SPOILT, ExoidError) as error:
        workspace.clear()
        if place is not None and place is not workspace.keeping.place:
            place.release()
        what = f"this is no session that exoid can open ({error})"
        raise RecordingError(what, where=str(folder), remedy="give its recordings instead") from error
    workspace.saved = Path(os.path.realpath(folder)) if kept else None
    if place is not None:
        _keep(workspace, place)


def _take_in(workspace: Workspace, folder: Path, place: SessionFolder | None) -> None:
    """Take in the session of a folder."""
    from exoid.apps.page.history import History

    text = place.read() if place is not None else read_input(folder / SESSION, LARGEST, remember=False, inside=folder)
    content = json.loads(text)
    if content["schema"] != SCHEMA:
        raise ValueError(content["schema"])
    recordings = [_given(folder, entry) for entry in content["recordings"]]
    history = History.from_json(content["history"])
    verdicts = {frozenset(verdict["effects"]): _verdict(verdict["found"]) for verdict in content["verdicts"]}
    if content["base"]:
        workspace.use_model(inside(folder, content["base"]), str(content["model"]))
    for entry in content["own_effects"]:
        workspace.add_effect(dict(entry))
    for name in {layer.name for step in history.steps for layer in step.layers}:
        effect, _, joint = name.partition(":")
        workspace.model.with_effect(workspace.own.get(effect, effect), joint or None)  # refuses what does not exist
    workspace.cutoff = None if content["cutoff"] is None else float(content["cutoff"])
    if workspace.cutoff is not None and not 0.0 < workspace.cutoff < math.inf:
        raise ValueError("its cut-off is no frequency")
    workspace.derivative = str(content["derivative"])
    if type(content["seed"]) is not int or content["seed"] < 0:
        raise ValueError("its seed is no whole number from 0 on")
    workspace.seed = content["seed"]
    for recording in recordings:
        workspace.add_file(**recording)
    workspace.change_history(lambda _: history)
    workspace.verdicts = verdicts


def _given(folder: Path, entry: dict[str, Any]) -> dict[str, Any]:
    """Return a recording of a saved session as the workspace takes it."""
    from exoid.measurement.reading.mapping import StatedMapping
    from exoid.symbolic.mechanics.payload import Payload

    lags = [(inside(folder, file), None if lag is None else float(lag)) for file, lag in entry["join"]]
    if not all(lag is None or math.isfinite(lag) for _, lag in lags):
        raise ValueError("a lag is no number")
    told = StatedMapping(
        _texts(entry["columns"]), _texts(entry["units"]), str(entry["leg"]), ",".join(entry["convention"]),
        tuple((str(file), lag) for file, lag in lags),
        tuple(entry["passive"]),
        tuple(Payload(*payload) for payload in entry["payloads"]),
        str(entry.get("only", "")),
        float(entry.get("rate", 0.0)),
    )  # fmt: skip
    role = VERIFY if entry["role"] == VERIFY else FIT
    return {"path": inside(folder, entry["file"]), "name": str(entry["name"]), "role": role, "told": told}


def _texts(value: Any) -> dict[str, str]:
    return {str(key): str(item) for key, item in dict(value).items()}


def _verdict(found: dict[str, Any]) -> dict[str, Any]:
    """Return a verdict of a saved session; KeyError or TypeError where it lacks what is shown of it."""
    texts = ("verdict", "sentence", "rule", "next_experiment", "stopped_because")
    entries = {"accepted": ("effect", "joint", "stability"), "possible": ("effect", "joint", "reason")}
    shown = {key: [{name: item[name] for name in names} for item in found[key]] for key, names in entries.items()}
    for effect, kept in zip(found["accepted"], shown["accepted"], strict=True):
        kept["sentence"] = str(effect.get("sentence", ""))  # sessions of older versions lack this and the next two
    return {
        **{key: str(found[key]) for key in texts},
        **{key: str(found.get(key, "")) for key in ("headline", "sureness")},
        "steps": [{"model": str(step["model"]), **{e: _errors(step[e]) for e in ERRORS}} for step in found["steps"]],
        **shown,
        **({"noise_floor": _errors(found["noise_floor"])} if found.get("noise_floor") else {}),
    }


ERRORS = ("train_rms", "verify_rms")


def _errors(value: Any) -> list[float] | None:
    """Return the error of each joint; None where no motion was held out."""
    return None if value is None else [float(item) for item in value]


def keep_in(workspace: Workspace, folder: Path) -> None:
    """Keep the session in `folder` after every step from now on; RecordingError where another process has it."""
    _keep(workspace, _held(workspace, folder))


def _keep(workspace: Workspace, place: SessionFolder) -> None:
    recent.note(place.folder)
    workspace.keeping.keep_in(place, partial(save, workspace, place.folder), partial(report, workspace))


def _held(workspace: Workspace, folder: Path) -> SessionFolder:
    """Return the folder as this workspace holds it already, or holds it from now on."""
    place = workspace.keeping.place
    return place if place is not None and place.folder == Path(os.path.realpath(folder)) else SessionFolder(folder)


def _is_empty(folder: Path) -> bool:
    """True if a folder holds nothing but, perhaps, a report of exoid's."""
    others = set(os.listdir(folder)) - {LOCK}
    return not others or (others == {REPORT} and says_so(folder / REPORT))


def is_session(path: str | Path) -> bool:
    """True if a folder holds a saved session: a session.json that exoid wrote, or what is left of one."""
    place = Path(path) / SESSION
    return place.is_file() and (says_so(place) or (Path(path) / LOCK).is_file())
