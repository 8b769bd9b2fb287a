"""What a session becomes outside the page: commands, Python, a model file, the report, a folder to open again."""

from __future__ import annotations

import io
import json
import os
import shlex
import shutil
import tempfile
import zipfile
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ground.errors import RecordingError
from ground.files import write_whole
from workbench.page.given import FIT, VERIFY, safe_name

if TYPE_CHECKING:
    from workbench.page.workspace import Workspace

SESSION = "session.json"
SCHEMA = "exoid.session/1"


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
    """Return today's report of the present model as one page; RecordingError where nothing is open."""
    from diagnosis.extend import Waterfall
    from workbench.report.material import Material, Steps, pictures_of
    from workbench.report.page import render_report

    session = workspace.session
    if session is None:
        raise RecordingError("nothing is open yet", remedy="give at least one recording to fit")
    names = workspace.names
    comparison = session.compare(names)
    path = [names[:k] for k in range(len(names) + 1)]
    steps = [session.step(p, f"+ {p[-1]}" if p else "base") for p in path]
    fall = Waterfall(tuple(steps), session.prepared.noise_floor, "these effects were added by hand")
    found = workspace.diagnosis
    diagnosis = found[1] if found is not None and set(found[0]) == set(names) else None
    now = session.fitted(names)
    rms = ", ".join(
        f"{joint} {error:.3g}" for joint, error in zip(session.model.joint_names, now.judged_rms, strict=True)
    )
    kind = "motion the fit has not seen" if session.prepared.verify else "the fitted motion"
    shown = diagnosis or fall
    return render_report(Material(
        title="exoid open",
        answer=f"The model with {', '.join(names) or 'no further effect'} leaves {rms} (RMS) on {kind}.",
        recordings=session.recordings,
        verify=session.verify,
        model=now.model,
        fit=now.fit,
        comparison=comparison,
        diagnosis=diagnosis,
        steps=Steps.of(shown),
        pictures=pictures_of(shown, section="suspects") + pictures_of(comparison, section="where"),
        command=_cli(workspace).splitlines()[-1],
        settings={"filter": session.prepared.choice.reason},
    ))  # fmt: skip


def exported(workspace: Workspace, kind: str) -> bytes:
    """Return the present model as code, in an archive; ExportError where the format cannot carry it."""
    from workbench.exporting import exporter, formats
    from workbench.identified import Options, read_ready

    if kind not in formats():
        raise RecordingError(f"there is no format {kind[:20]!r}", remedy=f"use {', '.join(formats())}")
    with tempfile.TemporaryDirectory(prefix="exoid-export-") as folder:
        model = Path(folder) / "model.toml"
        model.write_text(model_toml(workspace), encoding="utf-8")
        files = exporter(kind).write(read_ready(str(model)), Options())
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return out.getvalue()


def save(workspace: Workspace, folder: Path) -> Path:
    """Keep the session in a folder that `exoid open FOLDER` opens again; everything or nothing new is in it.

    RecordingError where something else is there.
    """
    target = free_for_session(folder)
    runs = target / "recordings"
    try:
        runs.mkdir(parents=True, exist_ok=True)
        entries = []
        for one in workspace.given:
            kept = runs / f"{one.id:02d}-{safe_name(one.name)}"
            if not kept.exists() and one.path.is_file():
                part = kept.with_name(kept.name + ".part")
                shutil.copyfile(one.path, part)
                part.replace(kept)
            told = one.told
            entries.append({
                "file": f"recordings/{kept.name}", "name": one.name, "role": one.role, "convention": one.convention,
                "columns": dict(told.columns) if told else {}, "units": dict(told.units) if told else {},
                "leg": told.leg if told else "", "options": dict(one.options),
            })  # fmt: skip
        write_whole(target / "model.toml", model_toml(workspace))
        if workspace.model_path is not None:
            write_whole(target / "base.toml", workspace.model_path.read_bytes())
        # Last, and whole: what it names is there.
        content = {
            "schema": SCHEMA, "recordings": entries, "history": workspace.history.to_json(),
            "base": "base.toml" if workspace.model_path is not None else None, "model": workspace.model_name,
            "own_effects": list(workspace.own_texts.values()), "seed": workspace.seed,
        }  # fmt: skip
        write_whole(target / SESSION, json.dumps(content, indent=1, ensure_ascii=False))
    except OSError as error:
        raise RecordingError(
            f"the session cannot be saved ({error.strerror or error})", where=str(target),
            remedy="choose a folder that may be written to",
        ) from error  # fmt: skip
    workspace.saved = Path(os.path.realpath(target))
    keep_in(workspace, workspace.saved)
    return workspace.saved


def free_for_session(folder: Path) -> Path:
    """Return a folder in which a session may be kept; RecordingError where something else is there."""
    target = folder.expanduser()
    if target.exists() and not (
        target.is_dir() and (is_session(target) or not set(os.listdir(target)) - {"report.html"})
    ):
        raise RecordingError(
            "there is something else", where=str(target), remedy="choose a new folder, or one that exoid saved before"
        )
    return target


def reopen(workspace: Workspace, folder: Path) -> None:
    """Open a session that was saved; RecordingError where the folder holds none that can be understood."""
    from diagnosis.session.history import History
    from measurement.reading.mapping import StatedMapping

    try:
        content = json.loads((folder / SESSION).read_text(encoding="utf-8"))
        if content["schema"] != SCHEMA:
            raise ValueError(content["schema"])
        if content["base"]:
            workspace.use_model(_inside(folder, content["base"]), str(content["model"]))
        for entry in content["own_effects"]:
            workspace.add_effect(dict(entry))
        for entry in content["recordings"]:
            told = StatedMapping(dict(entry["columns"]), dict(entry["units"]), str(entry["leg"]))
            workspace.add_file(
                _inside(folder, entry["file"]), str(entry["name"]), VERIFY if entry["role"] == VERIFY else FIT,
                told=told if told else None, convention=str(entry["convention"]),
            )  # fmt: skip
        history = History.from_json(content["history"])
        workspace.change_history(lambda _: history)
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise RecordingError(
            f"this is no session that exoid can open ({error})", where=str(folder), remedy="give its recordings instead"
        ) from error
    workspace.saved = Path(os.path.realpath(folder))
    keep_in(workspace, workspace.saved)


def keep_in(workspace: Workspace, folder: Path) -> None:
    """Keep the session in `folder` after every step from now on."""
    workspace.saving = folder
    workspace.keeper = partial(save, workspace, folder)


def is_session(path: str | Path) -> bool:
    """Whether a folder holds a saved session."""
    return (Path(path) / SESSION).is_file()


def _inside(folder: Path, name: Any) -> Path:
    """Return a file of a saved session; ValueError where it lies outside of its folder."""
    path = Path(os.path.realpath(folder / str(name)))
    if not path.is_relative_to(os.path.realpath(folder)):
        raise ValueError(f"{name} lies outside")
    return path


def _files(workspace: Workspace, role: str) -> list[str]:
    return [_shown(workspace, one) for one in workspace.given if one.role == role]


def _shown(workspace: Workspace, one: Any) -> str:
    """Return the path of a file as a command takes it: of one that was dropped, its name."""
    return one.name if one.path.is_relative_to(workspace.place) else str(one.path)


def _options(workspace: Workspace) -> list[str]:
    """Return the options that say what was said of the columns."""
    out: list[str] = []
    told = next((one.told for one in workspace.given if one.told), None)
    if told is not None and told.columns:
        out += ["--map", ",".join(f"{name}={column}" for name, column in told.columns.items())]
    if told is not None and told.units:
        out += ["--units", ",".join(f"{name}={unit}" for name, unit in told.units.items())]
    if told is not None and told.leg:
        out += ["--leg", told.leg]
    kept = next((one.convention for one in workspace.given if one.convention), "")
    return [*out, "--convention", kept] if kept else out


def _recordings(workspace: Workspace) -> list[str]:
    verify = _files(workspace, VERIFY)
    return [*_files(workspace, FIT), *(["--verify", *verify] if verify else []), *_options(workspace)]


def _cli(workspace: Workspace) -> str:
    """Return the commands that do the same: one for every effect that was added, then the whole search."""
    files = _recordings(workspace)
    base = [] if workspace.model_path is None else ["--model", workspace.model_name]
    names = workspace.names
    if not names:
        return shlex.join(["exoid", "compare", *files, *base])
    if workspace.diagnosis is not None and set(workspace.diagnosis[0]) == set(names):
        return shlex.join(["exoid", "discover", *files, *base])
    lines, model = [], base
    for k, name in enumerate(names, start=1):
        file = f"step{k}.toml"
        lines.append(shlex.join(["exoid", "add", name, *files, *model, "--write", file]))
        model = ["--model", file]
    return "\n".join(lines)


def _python(workspace: Workspace) -> str:
    fit, verify = _files(workspace, FIT), _files(workspace, VERIFY)
    told = next((one.told for one in workspace.given if one.told), None)
    more = ""
    if told is not None:
        more = "".join(
            f", {key}={value!r}"
            for key, value in (("columns", dict(told.columns)), ("units", dict(told.units)), ("leg", told.leg))
            if value
        )
    model = "exoid.Model.standard()" if workspace.model_path is None else f"exoid.read_model({workspace.model_name!r})"
    lines = [
        "import exoid",
        "",
        f"runs = [exoid.read_recording(path{more}) for path in {fit!r}]",
        f"held_out = [exoid.read_recording(path{more}) for path in {verify!r}]",
        f"session = exoid.Session({model}, runs, verify=held_out)",
        f"names = {list(workspace.names)!r}",
        "session.compare(names)",
    ]
    if workspace.own_texts:
        lines.insert(1, '# the effects of your own stand in the model file: exoid.read_model("model.toml")')
    return "\n".join(lines) + "\n"
