"""What a session becomes outside the page: commands, Python, a model file, the report, a folder to open again."""

from __future__ import annotations

import io
import json
import math
import os
import shlex
import tempfile
import threading
import zipfile
from dataclasses import astuple
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ground.errors import ExoidError, RecordingError, refused
from ground.files import write_whole
from ground.inputs import read_input
from ground.lock import LOCK, FolderHeld
from ground.plain import picked, plain
from measurement.signals.methods import BUTTERWORTH
from workbench.page.folder import LARGEST, SESSION, SessionFolder, inside
from workbench.page.given import FIT, VERIFY

if TYPE_CHECKING:
    from workbench.page.given import Given
    from workbench.page.workspace import Workspace

SCHEMA = "exoid.session/1"
MODEL = "model.toml"
"""Name of the model file that is taken away."""
DRAWING = threading.Lock()
"""Matplotlib draws for one thread at a time."""
REPORT = "report.html"


def commands(workspace: Workspace) -> dict[str, str]:
    """Return the session as a command line, as Python and as a model file."""
    return {"cli": _cli(workspace), "python": _python(workspace), "toml": model_toml(workspace)}


def model_toml(workspace: Workspace) -> str:
    """Return the present model as a model file, with its numbers where it is fitted."""
    import tomli_w

    from symbolic.model_file import model_content

    session = workspace.session
    if session is None:
        return str(tomli_w.dumps(model_content(workspace.model)))
    now = session.known(workspace.names)
    model = session.with_effects(workspace.names)
    content = model_content(model, None if now is None else now.fit)
    known = {entry["id"] for entry in content.get("custom_effects", [])}
    more = [entry for id, entry in workspace.own_texts.items() if id not in known]
    if more:
        content["custom_effects"] = [*content.get("custom_effects", []), *more]
    return str(tomli_w.dumps(content))


def report(workspace: Workspace) -> str:
    """Return today's report of the present model as one page, and keep it where the session is kept; RecordingError
    where nothing is open.
    """
    from diagnosis.extend import Waterfall
    from workbench.report.material import Material, before_and_after, pictures_of, without_folders
    from workbench.report.page import render_report
    from workbench.report.sections.verdict import WORDS

    session, folder = workspace.opened(), workspace.keeping.folder
    names = workspace.names
    path = [names[:k] for k in range(len(names) + 1)]
    steps = [session.step(p, f"+ {p[-1]}" if p else "base") for p in path]
    said = workspace.verdict
    origin = "these effects were added by hand" if said is None else said["stopped_because"]
    fall = Waterfall(tuple(steps), session.prepared.noise_floor, origin)
    diagnosis = workspace.diagnoses.get(frozenset(names))
    now = session.fitted(names)
    rms = ", ".join(
        f"{joint.name} {error:.3g} {joint.unit('tau')}"
        for joint, error in zip(session.model.joints, now.evaluation_rms, strict=True)
    )
    kind = "motion the fit has not seen" if session.prepared.verify else "the fitted motion"
    answer = f"The model with {', '.join(names) or 'no further effect'} leaves {rms} (RMS) on {kind}."
    if said is not None:
        answer = "" if diagnosis is not None else f"{WORDS.get(said['verdict'], said['verdict'])}. {said['sentence']}"
    shown = diagnosis or fall
    with DRAWING:
        comparison = session.compare()
        falls = before_and_after(comparison, now.fit) if names else ()
        page = render_report(Material(
            title="What the model was missing" if names else "Model against measurement",
            answer=answer,
            recordings=session.recordings,
            verify=session.verify,
            model=now.model,
            fit=now.fit,
            comparison=comparison,
            diagnosis=diagnosis,
            fall=shown,
            pictures=falls + pictures_of(shown, section="suspects") + pictures_of(comparison, section="where"),
            command=without_folders(_cli(workspace).splitlines()[-1]),
            settings={"filter": session.prepared.choice.reason},
        ))  # fmt: skip
    if folder is not None and (diagnosis is not None or said is None):  # or the one kept says more
        write_whole(folder / REPORT, page, at_once=True, inside=folder)
    return page


def exported(workspace: Workspace, kind: str) -> bytes:
    """Return the present model at its numbers as code, in an archive; ExportError where the format cannot carry it,
    RecordingError where nothing is open or there is no such format.
    """
    from workbench.exporting import exporter, formats
    from workbench.identified import Options, read_ready

    if kind not in formats():
        raise RecordingError(f"there is no format {kind[:20]!r}", remedy=f"use {', '.join(formats())}")
    if workspace.session is None:
        raise RecordingError("there are no numbers yet", remedy="open recordings, and wait until they are fitted")
    workspace.session.fitted(workspace.names)  # at once where it has been, as the code needs the numbers
    with tempfile.TemporaryDirectory(prefix="exoid-export-") as folder:
        model = Path(folder) / MODEL
        model.write_text(model_toml(workspace), encoding="utf-8")
        try:
            files = exporter(kind).write(read_ready(str(model)), Options())
        except ExoidError as error:
            raise error.about(MODEL, model) from error
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return out.getvalue()


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
    for one in list(workspace.given):
        digest = one.recordings[0].source.sha256 if one.recordings and not one.told.join else ""
        entries.append({
            "file": place.copy(one.path, one.name, digest), "name": one.name, "role": one.role,
            "join": [(place.copy(Path(file), f"joined-{Path(file).name}"), lag) for file, lag in one.told.join],
            **picked(one.told, "columns units leg passive only"),
            "convention": list(filter(None, one.told.convention.split(","))),
            "payloads": [astuple(load) for load in one.told.payloads],
        })  # fmt: skip
    base = None if workspace.model_path is None else place.copy_base(workspace.model_path)
    content = {
        "schema": SCHEMA, "recordings": entries, "history": workspace.history.to_json(),
        "base": base, "model": workspace.model_name,
        "own_effects": list(workspace.own_texts.values()), "seed": workspace.seed, "cutoff": workspace.cutoff,
        "derivative": workspace.derivative,
        "verdicts": [{"effects": sorted(names), "found": one} for names, one in list(workspace.verdicts.items())],
    }  # fmt: skip
    before = _named(place)
    place.write(json.dumps(plain(content), indent=1, ensure_ascii=False))
    write_whole(place.folder / MODEL, model_toml(workspace), at_once=True, inside=place.folder)
    place.tidy(_files(content), before)


def _named(place: SessionFolder) -> list[str]:
    """Return the files that the session there names so far; none where it cannot be understood."""
    try:
        return _files(json.loads(place.present()))
    except SPOILT:
        return []


def _files(content: Any) -> list[str]:
    """Return the names of the files that the content of a session.json names."""
    entries = [name for one in content["recordings"] for name in (one["file"], *(file for file, _ in one["join"]))]
    return [str(name) for name in (*entries, content["base"]) if name]


def free_for_session(folder: Path) -> Path:
    """Return a folder in which a session may be kept; RecordingError where something else is there."""
    target = folder.expanduser()
    if target.exists() and not (
        target.is_dir() and (is_session(target) or not set(os.listdir(target)) - {REPORT, LOCK})
    ):
        raise RecordingError(
            "there is something else", where=str(target), remedy="choose a new folder, or one that exoid saved before"
        )
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
        raise RecordingError(
            f"this is no session that exoid can open ({error})", where=str(folder), remedy="give its recordings instead"
        ) from error
    workspace.saved = Path(os.path.realpath(folder)) if kept else None
    if place is not None:
        _keep(workspace, place)


SPOILT = (KeyError, TypeError, ValueError, OverflowError, RecursionError, AttributeError)
"""What a session.json that was spoilt raises when it is gone through."""


def _take_in(workspace: Workspace, folder: Path, place: SessionFolder | None) -> None:
    """Take in the session of a folder."""
    from diagnosis.session.history import History

    text = place.read() if place is not None else read_input(folder / SESSION, LARGEST, remember=False, inside=folder)
    content = json.loads(text)
    if content["schema"] != SCHEMA:
        raise ValueError(content["schema"])
    recordings = [_given(folder, entry) for entry in content["recordings"]]
    history = History.from_json(content["history"])
    verdicts = {frozenset(one["effects"]): _verdict(one["found"]) for one in content["verdicts"]}
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
    for one in recordings:
        workspace.add_file(**one)
    workspace.change_history(lambda _: history)
    workspace.verdicts = verdicts


def _given(folder: Path, entry: dict[str, Any]) -> dict[str, Any]:
    """Return a recording of a saved session as the workspace takes it."""
    from measurement.reading.mapping import StatedMapping
    from symbolic.mechanics.payload import Payload

    lags = [(inside(folder, file), None if lag is None else float(lag)) for file, lag in entry["join"]]
    if not all(lag is None or math.isfinite(lag) for _, lag in lags):
        raise ValueError("a lag is no number")
    told = StatedMapping(
        _texts(entry["columns"]), _texts(entry["units"]), str(entry["leg"]), ",".join(entry["convention"]),
        tuple((str(file), lag) for file, lag in lags),
        tuple(entry["passive"]),
        tuple(Payload(*one) for one in entry["payloads"]),
        str(entry.get("only", "")),
    )  # fmt: skip
    role = VERIFY if entry["role"] == VERIFY else FIT
    return {"path": inside(folder, entry["file"]), "name": str(entry["name"]), "role": role, "told": told}


def _texts(value: Any) -> dict[str, str]:
    return {str(key): str(one) for key, one in dict(value).items()}


def _verdict(found: dict[str, Any]) -> dict[str, Any]:
    """Return a verdict of a saved session; KeyError or TypeError where it lacks what is shown of it."""
    texts = ("verdict", "sentence", "rule", "next_experiment", "stopped_because")
    entries = {"accepted": ("effect", "joint", "stability"), "possible": ("effect", "joint", "reason")}
    shown = {key: [{name: one[name] for name in names} for one in found[key]] for key, names in entries.items()}
    return {**{key: str(found[key]) for key in texts}, **shown}


def keep_in(workspace: Workspace, folder: Path) -> None:
    """Keep the session in `folder` after every step from now on; RecordingError where another process has it."""
    _keep(workspace, _held(workspace, folder))


def _keep(workspace: Workspace, place: SessionFolder) -> None:
    workspace.keeping.keep_in(place, partial(save, workspace, place.folder), partial(report, workspace))


def _held(workspace: Workspace, folder: Path) -> SessionFolder:
    """Return the folder as this workspace holds it already, or holds it from now on."""
    place = workspace.keeping.place
    return place if place is not None and place.folder == Path(os.path.realpath(folder)) else SessionFolder(folder)


def is_session(path: str | Path) -> bool:
    """Whether a folder holds a saved session."""
    return (Path(path) / SESSION).is_file()


def _shown(workspace: Workspace, path: Path, name: str) -> str:
    """Return the path of a file as a command takes it: of one that was dropped, its name."""
    return name if path.is_relative_to(workspace.place) else str(path)


def _recordings(workspace: Workspace) -> list[str]:
    """Return the recordings, and the options that say how they are read, as a command takes them."""
    named = [(one, _shown(workspace, one.path, one.name)) for one in workspace.given]
    out = [name for one, name in named if one.role == FIT]
    if verify := [name for one, name in named if one.role == VERIFY]:
        out += ["--verify", *verify]
    for said in [one.told for one in workspace.given if one.told][:1]:
        for option, known in (("--map", said.columns), ("--units", said.units)):
            out += [option, ",".join(f"{name}={value}" for name, value in known.items())] if known else []
        out += ["--leg", said.leg] if said.leg else []
    only = next((one.told.only for one in workspace.given if one.told.only), "")
    out += ["--only", only] if only else []
    for one, name in named:
        told = one.told
        out += ["--convention", f"{name}={told.convention}"] if told.convention else []
        for file, lag in told.join:
            out += ["--join", f"{name}={file}" + ("" if lag is None else f"@{lag:g}")]
        for joint in told.passive:
            out += ["--passive", f"{name}={joint}"]
        for load in told.payloads:
            out += ["--payload", f"{name}={load.link}:{load.mass:g}@{load.along:g}"]
    out += [] if workspace.cutoff is None else ["--cutoff", f"{workspace.cutoff:g}"]
    out += [] if workspace.derivative == BUTTERWORTH else ["--derivative", workspace.derivative]
    return [*out, "--seed", str(workspace.seed)] if workspace.seed else out


def _base(workspace: Workspace) -> list[str]:
    """Return the option that names the model everything starts from."""
    path = workspace.model_path
    return [] if path is None else ["--model", _shown(workspace, path, workspace.model_name)]


def _cli(workspace: Workspace) -> str:
    """Return the commands that do the same: one for every effect that was added, then the whole search."""
    files, base, names = _recordings(workspace), _base(workspace), workspace.names
    if any(name.partition(":")[0] in workspace.own for name in names):
        # A command knows an effect of one's own from a model file.
        return shlex.join(["exoid", "compare", *files, "--model", MODEL])
    if workspace.verdict is not None:
        return shlex.join(["exoid", "discover", *files, *base])
    if not names:
        return shlex.join(["exoid", "compare", *files, *base])
    lines, model = [], base
    for k, name in enumerate(names, start=1):
        file = f"step{k}.toml"
        lines.append(shlex.join(["exoid", "add", name, *files, *model, "--write", file]))
        model = ["--model", file]
    return "\n".join(lines)


def _python(workspace: Workspace) -> str:
    """Return the same as Python that runs as it stands, beside the recordings and the model file."""
    own = any(name.partition(":")[0] in workspace.own for name in workspace.names)
    path = MODEL if own else (_base(workspace) or ["", ""])[1]
    names = [] if own else list(workspace.names)
    lines = ["import exoid", "", f"model = exoid.read_model({path!r})" if path else "model = exoid.Model.standard()"]
    for variable, role in (("runs", FIT), ("held_out", VERIFY)):
        lines.append(f"{variable} = [")
        lines += [f"    {_read(workspace, one)}," for one in workspace.given if one.role == role]
        lines.append("]")
    more = "" if workspace.cutoff is None else f", cutoff={workspace.cutoff!r}"
    more += "" if workspace.derivative == BUTTERWORTH else f", derivative={workspace.derivative!r}"
    more += f", seed={workspace.seed}" if workspace.seed else ""
    lines += [
        f"session = exoid.Session(model, runs, verify=held_out{more})",
        f"print(session.compare({names!r}))",
        f"print(session.discover({names if workspace.verdict is None else []!r}))",
    ]
    return "\n".join(lines) + "\n"


def _read(workspace: Workspace, one: Given) -> str:
    """Return the call that reads a recording as it is read here."""
    more = [f", {key}={value!r}" for key, value in one.told.options.items()]
    more += [", joints=model.joints"] if workspace.joints is not None else []
    text = f"exoid.read_recording({_shown(workspace, one.path, one.name)!r}{''.join(more)})"
    text += f".with_passive({', '.join(map(repr, one.told.passive))})" if one.told.passive else ""
    return text + "".join(f".with_payload({p.mass!r}, {p.along!r}, {p.link!r})" for p in one.told.payloads)
