"""Time series as bytes for the page: a short head of JSON, then arrays of 32-bit floats, one joint after the other."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from exoid.apps.page.answers import trial as trial_of
from exoid.ground.errors import RecordingError

if TYPE_CHECKING:
    import numpy as np

    from exoid.apps.page.workspace import Workspace
    from exoid.diagnosis.evidence.fitted import FittedModel
    from exoid.diagnosis.session import Session


def packed(head: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> bytes:
    """Return the bytes: length of the head (4 bytes, little endian), head, padding, arrays in its order."""
    import numpy as np

    places, parts, offset = {}, [], 0
    for name, array in arrays.items():
        data = np.ascontiguousarray(array, dtype="<f4")
        places[name] = {"offset": offset, "shape": list(data.shape)}
        offset += data.size
        parts.append(data.tobytes())
    text = json.dumps({**head, "arrays": places}).encode()
    text += b" " * (-(4 + len(text)) % 4)
    return struct.pack("<I", len(text)) + text + b"".join(parts)


def motion_of(session: Session, index: int) -> bytes:
    """Return the measurements of a recording: torque, motion and load (J, K), and which samples count."""
    import numpy as np

    from exoid.diagnosis.evidence.curves import signal_of

    recording, base = _recording(session, index), session.fitted()
    motion = recording.motion
    arrays = {
        "torque": recording.torque,
        "use": recording.used,
        "angle": motion.q[recording.kept].T,
        "velocity": motion.dq[recording.kept].T,
        "acceleration": motion.ddq[recording.kept].T,
        "load": np.stack([signal_of(recording, base, "load", j)[recording.kept] for j in range(len(recording.torque))]),
    }
    return packed({"recording": index, **_clock(recording)}, arrays)


def error_of(workspace: Workspace, session: Session, index: int) -> bytes:
    """Return the error (J, K) N·m of the present model on a recording; provisional where it is not fitted yet."""
    names = workspace.names
    now = session.known(names)
    head = {"recording": index, **_clock(_recording(session, index))}
    if now is not None:
        return packed({**head, "provisional": False}, {"error": now.residuals[index]})
    trial = trial_of(workspace, names)
    residuals = _on_whole(session, trial.residuals, index) if trial else session.fitted().residuals[index]
    return packed({**head, "provisional": True}, {"error": residuals})


def strides(workspace: Workspace, session: Session) -> dict[str, Any]:
    """Return torque, present model and error over the stride; {"strides": None} where the motion has no strides."""
    from exoid.diagnosis.evidence.strides import strides_of

    found = strides_of(session.known(workspace.names) or session.fitted())
    return {"strides": None if found is None else found.to_json()}


def preview_of(workspace: Workspace, session: Session, name: str, index: int) -> bytes:
    """Return the error (J, K) N·m as it would become with one more effect, and between which its placebos stay."""
    _recording(session, index)
    ranking = workspace.ranking()
    trial = None if ranking is None else ranking.trial(name)
    if ranking is None or trial is None:
        raise RecordingError(f"{name} is not weighed yet", where=name, remedy="wait a moment")
    low, high = ranking.band(name) or (trial.residuals, trial.residuals)
    arrays = {
        "error": _on_whole(session, trial.residuals, index),
        "low": _on_whole(session, low, index),
        "high": _on_whole(session, high, index),
    }
    return packed({"recording": index, "effect": name, "rms": trial.evaluation_rms.tolist()}, arrays)


def other_error_of(workspace: Workspace, session: Session, index: int) -> bytes:
    """Return the error (J, K) N·m beside the present one: of the model as it was given where effects were added to it,
    else of the one that Discover found by itself.
    """
    _recording(session, index)
    other = session.known(()) if workspace.names else workspace.judging.after(session)
    if other is None:
        raise RecordingError("nothing is judged yet", remedy="wait a moment")
    return packed({"recording": index}, {"error": other.residuals[index]})


def column_of(workspace: Workspace, session: Session, index: int, name: str) -> bytes:
    """Return any column of the file of a recording (1, K), as it stands there, at the instants of the plots."""
    import numpy as np

    from exoid.measurement.reading.mapping import numbered
    from exoid.measurement.reading.read import open_table

    shown = _recording(session, index)
    recording = (*session.recordings, *session.verify)[index]
    file = next(f for f in workspace.given if any(r.source == recording.source for r in f.recordings))
    table = open_table(file.path)
    names = numbered(table.names)
    if name not in names:
        raise RecordingError(f"there is no column {name[:40]!r}", where=file.name, remedy="choose another one")
    place = np.searchsorted(table.row, recording.row)
    inside = place < table.row.size
    inside[inside] = table.row[place[inside]] == recording.row[inside]
    values = table.columns[names.index(name)].values[place[inside]]
    t, good = recording.t[inside], np.isfinite(values)
    if good.sum() < 2:
        raise RecordingError(f"the column {name[:40]!r} has no numbers", where=file.name, remedy="choose another one")
    drawn = np.interp(shown.t, t[good], values[good], left=np.nan, right=np.nan)
    unit = table.columns[names.index(name)].unit
    return packed({"recording": index, "column": name, "unit": unit, **_clock(shown)}, {"values": drawn[None, :]})


def explained(
    workspace: Workspace,
    session: Session,
    spans: Sequence[tuple[int, float, float]],
    joint: int | None,
    box: Mapping[str, Any] | None,
) -> dict[str, float]:
    """Return the share of the error in a selection that each suspect would take away: stretches of time, or a box in
    the plane of a variable and the error of a joint.
    """
    import numpy as np

    if joint is not None and not 0 <= joint < len(session.model.joints):
        raise RecordingError("there is no such joint", remedy="reload the page")
    ranking = workspace.ranking()
    if ranking is None:
        return {}
    selected = []
    for place, item in enumerate(session.searched.all):
        origin = session.origins[place]
        chosen = np.zeros(item.used.shape, dtype=bool)
        for recording, low, high in spans:
            if recording == origin:
                chosen |= ((item.t >= low) & (item.t <= high))[None, :]
        if box is not None and joint is not None:
            x = _variable(session, place, ranking.fitted, str(box["variable"]), joint)
            y = ranking.fitted.residuals[place][joint]
            inside = (x >= box["x"][0]) & (x <= box["x"][1]) & (y >= box["y"][0]) & (y <= box["y"][1])
            chosen[joint] |= inside
        elif joint is not None:
            chosen[np.arange(len(chosen)) != joint] = False
        selected.append(chosen)
    return ranking.explained(selected)


def _variable(session: Session, place: int, fitted: FittedModel, variable: str, joint: int) -> np.ndarray:
    from exoid.diagnosis.evidence.curves import signal_of

    recording = session.searched.all[place]
    if variable == "time":
        return recording.t - float(session.prepared.all[session.origins[place]].t[0])
    kind, _, of = variable.partition(":")
    stem, names = {"angle": "q", "velocity": "dq", "acceleration": "ddq"}.get(kind), session.model.joint_names
    if variable != "load" and (stem is None or of not in names):
        raise RecordingError(f"there is no variable {variable[:40]!r}", remedy="reload the page")
    name = variable if stem is None else f"{stem}{names.index(of) + 1}"
    values: np.ndarray = signal_of(recording, fitted, name, joint)[recording.kept]
    return values


def _recording(session: Session, index: int) -> Any:
    if not 0 <= index < len(session.prepared.all):
        raise RecordingError("there is no such recording", remedy="reload the page")
    return session.prepared.all[index]


def _clock(one: Any) -> dict[str, Any]:
    return {"t0": float(one.t[0]), "dt": 1.0 / one.kept_rate, "count": len(one.t)}


def _on_whole(session: Session, parts: Sequence[np.ndarray], index: int) -> np.ndarray:
    """Return residuals of stretches in the place they have in the whole recording, not a number in between."""
    import numpy as np

    recording = session.prepared.all[index]
    if session.searched is session.prepared:
        return parts[index]
    out = np.full(recording.used.shape, np.nan)
    for place, origin in enumerate(session.origins):
        if origin == index:
            first = int(np.searchsorted(recording.t, session.searched.all[place].t[0] - 1e-9))
            out[:, first : first + parts[place].shape[1]] = parts[place]
    return out
