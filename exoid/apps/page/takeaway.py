"""Forms of a session outside the page: commands, Python, a model file, the report, a folder to open again."""

from __future__ import annotations

import io
import shlex
import tempfile
import threading
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

from exoid.apps.page.given import FIT, VERIFY
from exoid.ground.errors import ExoidError, RecordingError
from exoid.ground.files import write_whole
from exoid.ground.text import digits
from exoid.measurement.signals.methods import BUTTERWORTH

if TYPE_CHECKING:
    from exoid.apps.page.given import Given
    from exoid.apps.page.workspace import Workspace

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

    from exoid.symbolic.model_file import model_content

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
    from exoid.diagnosis.extend import Waterfall
    from exoid.diagnosis.report.material import Material, Picture, pictures_of, without_folders
    from exoid.diagnosis.report.page import render_report
    from exoid.diagnosis.report.sections.verdict import WORDS

    session, folder = workspace.opened(), workspace.keeping.folder
    names = workspace.names
    path = [names[:k] for k in range(len(names) + 1)]
    steps = [session.step(p, f"+ {p[-1]}" if p else "base") for p in path]
    said = workspace.verdict
    origin = "these effects were added by hand" if said is None else said["stopped_because"]
    fits = tuple(session.fitted(p).fit for p in path)
    fall = Waterfall(tuple(steps), session.prepared.noise_floor, fits[-1].model, origin, fits)
    diagnosis = workspace.diagnoses.get(frozenset(names))
    now = session.fitted(names) if diagnosis is None else diagnosis.fitted_on(session.prepared)
    rms = ", ".join(
        f"{joint.name} {digits(error)} {joint.unit('tau')}"
        for joint, error in zip(session.model.joints, now.evaluation_rms, strict=True)
    )
    kind = "motion the fit has not seen" if session.prepared.verify else "the fitted motion"
    answer = f"The model with {', '.join(names) or 'no further effect'} leaves {rms} (RMS) on {kind}."
    if said is not None:
        answer = "" if diagnosis is not None else f"{WORDS.get(said['verdict'], said['verdict'])}. {said['sentence']}"
    shown = diagnosis or fall
    with DRAWING:
        comparison = session.compare()
        falls = (Picture(*comparison.before_and_after(now), "verdict"),) if len(shown.steps) > 1 else ()
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
    from exoid.workbench.exporting import exporter, formats
    from exoid.workbench.identified import Options, read_ready

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


def _shown(workspace: Workspace, path: Path, name: str) -> str:
    """Return the path of a file as a command takes it: of one that was dropped, its name."""
    return name if path.is_relative_to(workspace.place) else str(path)


def _recordings(workspace: Workspace) -> list[str]:
    """Return the recordings, and the options that say how they are read, as a command takes them."""
    named = [(entry, _shown(workspace, entry.path, entry.name)) for entry in workspace.given]
    out = [name for element, name in named if element.role == FIT]
    if verify := [name for entry, name in named if entry.role == VERIFY]:
        out += ["--verify", *verify]
    for said in [entry.told for entry in workspace.given if entry.told][:1]:
        for option, known in (("--map", said.columns), ("--units", said.units)):
            out += [option, ",".join(f"{name}={value}" for name, value in known.items())] if known else []
        out += ["--leg", said.leg] if said.leg else []
    only = next((entry.told.only for entry in workspace.given if entry.told.only), "")
    out += ["--only", only] if only else []
    rate = next((entry.told.rate for entry in workspace.given if entry.told.rate), 0.0)
    out += ["--rate", f"{rate:g}"] if rate else []
    for item, name in named:
        told = item.told
        out += ["--convention", f"{name}={told.convention}"] if told.convention else []
        for file, lag in told.join:
            out += ["--join", f"{name}={file}" + ("" if lag is None else f"@{lag:g}")]
        for joint in told.passive:
            out += ["--passive", f"{name}={joint}"]
        for load in told.payloads:
            out += ["--payload", f"{name}={load}"]
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
        lines += [f"    {_read(workspace, entry)}," for entry in workspace.given if entry.role == role]
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
    return text + "".join(f".with_payload({p.mass!r}, {p.along!r}, {p.link!r})" for p in one.told.payloads)
