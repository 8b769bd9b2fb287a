"""Contents of the page, as JSON: one picture of the whole workspace that every tab draws itself from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from exoid.apps.page import answers
from exoid.apps.page.given import VERIFY
from exoid.diagnosis.evidence.fitted import pooled_rms
from exoid.diagnosis.evidence.score import share_of_own_joints
from exoid.diagnosis.outside import ForceUse, force_uses
from exoid.diagnosis.report.sections.verdict import term
from exoid.diagnosis.sureness import MEANINGS
from exoid.diagnosis.write_up import best_first
from exoid.ground.errors import error_json
from exoid.ground.files import MODEL_FILES
from exoid.ground.plain import plain_dict
from exoid.ground.text import digits, printable
from exoid.measurement.reading.among import left_out_said
from exoid.measurement.reading.sources import suffixes
from exoid.optimisation.linear.links import tree_of
from exoid.symbolic.joints import HERE, Joint, parents
from exoid.symbolic.language.tree import CONSTANTS, FUNCTIONS, OPERATORS
from exoid.symbolic.mechanics.spatial import rotation
from exoid.symbolic.wording import called, number_said, the_joint, title_of
from exoid.workbench.exporting import formats

if TYPE_CHECKING:
    from exoid.apps.page.workspace import Workspace
    from exoid.diagnosis.evidence.fitted import FittedModel
    from exoid.diagnosis.evidence.score import Score
    from exoid.diagnosis.results import Accepted, Diagnosis
    from exoid.diagnosis.session import Ranking, Session
    from exoid.measurement.finding import Finding
    from exoid.measurement.recording import Recording
    from exoid.symbolic.effect import Effect

NOTHING_HELD_OUT = "Nothing is held out: hold a recording back to see whether it holds on unseen motion."
SURE = 1.96
"""Standard deviations of the interval of a p-value from a number of placebos."""


def state(workspace: Workspace) -> dict[str, Any]:
    """Return everything but the time series."""
    session, problem = workspace.session, workspace.problem or workspace.keeping.unkept
    for entry in workspace.given:
        problem = None if problem is None else problem.about(entry.name, entry.path)
    out: dict[str, Any] = {
        "version": workspace.version,
        "edits": len(workspace.edits),
        "files": [_file(item) for item in workspace.given if not (item.is_other and _reading(workspace))],
        "left_out": left_out_said(workspace.left_out, len(workspace.given) + len(workspace.left_out)),
        "model": workspace.model_name or "standard leg",
        "busy": printable(workspace.busy),
        "problem": None if problem is None else error_json(problem),
        "folder": str(workspace.keeping.folder or "exoid-session"),
        "saved": None if workspace.saved is None else str(workspace.saved),
        "kept": workspace.keeping.kept,
        "own": list(workspace.own_texts.values()),
        "formats": formats(),
        "suffixes": suffixes(),
        "model_suffixes": MODEL_FILES,
        "sureness": dict(MEANINGS),
        "words": sorted({"t", *CONSTANTS, *FUNCTIONS, *OPERATORS}),
        "ready": session is not None,
        "search": _search(workspace),
        "auto": {"on": workspace.judging.on, "running": workspace.judging.running},
        "tasks": {name: task.to_json() for name, task in workspace.tasks.items()},
    }
    if session is not None:
        out |= _session(workspace, session)
    return plain_dict(out)


def _reading(workspace: Workspace) -> bool:
    """Files are still to be read, so that nobody knows yet whether a recording is among them."""
    return not all(entry.read for entry in workspace.given)


def details(workspace: Workspace, name: str) -> dict[str, Any]:
    """Return the details of one suspect: what it means, what it cannot be distinguished from, what to measure."""
    ranking = workspace.ranking()
    score = None if ranking is None else ranking.score(name)
    effect = _effect(workspace, name)
    out: dict[str, Any] = {
        "explains": effect.explains,
        "tells_apart": effect.tells_apart,
        "reference": effect.reference,
        "name": name,
        "title": _title(effect, name),
        "torque": effect.torque if isinstance(effect.torque, str) else "",
        "alike": [],
        "numbers": [],
    }
    if ranking is not None and score is not None:
        out["alike"] = list(ranking.alike(name))
        found = answers.found(workspace, (*workspace.names, name))
        out["numbers"] = _numbers(score) if found is None else _told_numbers(effect, found.accepted[-1])
        out["rms"] = answers.error(workspace, (*workspace.names, name))
    return plain_dict(out)


def _file(one: Any) -> dict[str, Any]:
    findings = [f for recording in one.recordings for f in recording.findings]
    return {
        "id": one.id,
        "name": one.name,
        "role": one.role,
        "read": one.read,
        "error": None if one.error is None else error_json(one.error),
        "seconds": sum(r.duration for r in one.recordings),
        "rate": one.recordings[0].rate if one.recordings else None,
        "samples": sum(len(r) for r in one.recordings),
        "findings": [
            {"severity": f.severity, "what": printable(f.what), "remedy": printable(f.remedy)} for f in findings
        ],
    }


def _noted(workspace: Workspace, finding: Finding) -> str:
    """Return the text of an audit's finding, with the names of files as the user knows them."""
    text = str(finding)
    for entry in workspace.given:
        text = text.replace(str(entry.path), entry.name)
    return printable(text)


def _session(workspace: Workspace, session: Session) -> dict[str, Any]:
    names = workspace.names
    now = session.known(names)
    ranking = workspace.ranking()
    prepared = session.prepared
    error = answers.error(workspace, names)
    base = answers.error(workspace, ())
    judged = None if names else workspace.judging.answer(session)
    said = workspace.verdict or (None if names else workspace.judging.told(session))
    floor = prepared.noise_floor if said is None else said.get("noise_floor") or prepared.noise_floor
    after = None if judged is None or len(judged.steps) < 2 else judged.steps[-1].evaluation_rms
    lengths, above = _lengths(session.model), parents(session.model.joints)
    shown = prepared.verify or prepared.train
    signal = pooled_rms([item.torque for item in shown], shown)
    return {
        "joints": [
            {
                "name": joint.name,
                "kind": joint.kind,
                "unit": joint.unit("tau"),
                "length": lengths[j],
                "parent": above[j],
                "space": _in_space(joint),
                "error": None if error is None else error[j],
                "first": None if base is None else base[j],
                "after": None if after is None else after[j],
                "noise": floor[j],
                "signal": signal[j],
            }
            for j, joint in enumerate(session.model.joints)
        ],
        "judged": "unseen" if prepared.verify else "fitted",
        "recordings": [
            {
                "name": printable(entry.name),
                "role": VERIFY if k >= len(prepared.train) else "fit",
                "file": _file_of(workspace, recording),
            }
            for k, (entry, recording) in enumerate(
                zip(prepared.all, (*session.recordings, *session.verify), strict=True)
            )
        ],
        "filter": prepared.choice.reason,
        "audit": [_noted(workspace, f) for f in prepared.findings if f.severity != "info"],
        "forces": [printable(force.sentence) for force in _forces(now or session.fitted())],
        "fitted": now is not None,
        "key": ",".join(names) if now is not None else f"{','.join(names)}?",
        "failed": None if names not in workspace.failed else error_json(workspace.failed[names]),
        "layers": _layers(workspace, session),
        "history": _history(workspace, session),
        "verdict": _verdict(workspace, session),
        "ranking": None if ranking is None else {
            "weighed": ranking.weighed, "finished": ranking.finished,
            "suspects": best_first(
                (_as_judged(_suspect(ranking, score), judged) for score in ranking.scores),
                lambda one: one["sureness"], lambda one: one["share"] or 0.0,
            ),
        },
    }


@lru_cache(maxsize=2)
def _forces(now: FittedModel) -> tuple[ForceUse, ...]:
    """Return the uses of the measured forces of a fitted model, once for all the times that the page asks."""
    return force_uses(now)


def _file_of(workspace: Workspace, recording: Recording) -> int | None:
    """Return the number of the file in which a recording stands."""
    held = (entry.id for entry in workspace.given if any(r.source == recording.source for r in entry.recordings))
    return next(held, None)


def _lengths(model: Any) -> list[float]:
    """Return the length at which each link is drawn, m; the last one, whose length nobody needs to know, like the one
    before.
    """
    given = [joint.length for joint in tree_of(model)]
    known = [length for length in given if length]
    usual = known[-1] if known else 0.4
    return [length or usual for length in given]


def _in_space(joint: Joint) -> dict[str, Any] | None:
    """Return the pose of a joint on the link that carries it: turned (3, 3), place (3,) m, axis (3,); None in a plane.
    """
    if joint.axis is None:
        return None
    origin = joint.origin or HERE
    return {"turned": rotation(origin), "place": origin.xyz, "axis": joint.axis}


def _layers(workspace: Workspace, session: Session) -> list[dict[str, Any]]:
    now = session.known(workspace.names)
    estimates = {} if now is None else {e.name: e for e in now.fit.estimates}
    out = []
    for layer in workspace.history.now.layers:
        effect = _effect(workspace, layer.name)
        mine = [e for name, e in estimates.items() if name.startswith(f"{layer.name}.")]
        out.append(
            {
                "name": layer.name,
                "on": layer.on,
                "title": _title(effect, layer.name),
                "explains": effect.explains,
                "numbers": [{**e.to_json(), **_said(effect, e)} for e in mine],
            }
        )
    return out


def _said(effect: Effect, estimate: Any) -> dict[str, str]:
    """Return the name of a number of an effect, and what it is in words."""
    name = estimate.name.rpartition(".")[2]
    return {"name": name, "said": number_said(effect, name, estimate.value, estimate.unit)}


def _history(workspace: Workspace, session: Session) -> dict[str, Any]:
    history = workspace.history
    return {
        "at": history.at,
        "undo": history.at > 0,
        "redo": history.at < len(history.steps) - 1,
        "steps": [
            {
                "label": step.label,
                "effects": list(step.names),
                "rms": answers.error(workspace, step.names),
                "provisional": answers.told(workspace, step.names) is None and session.known(step.names) is None,
            }
            for step in history.steps
        ],
    }


def _verdict(workspace: Workspace, session: Session) -> dict[str, Any]:
    """Return the verdict of a search where it is about the present effects; else what can be said without one."""
    names = workspace.names
    found = workspace.verdict
    judged = workspace.judging.told(session) if found is None and not names else None
    found = found or judged
    if found is not None:
        held_out = "" if session.prepared.verify else f" {NOTHING_HELD_OUT}"
        return {
            "proposed": judged is not None,
            "steps": [{"label": s["model"], "rms": s["verify_rms"] or s["train_rms"]} for s in found["steps"]],
            "accepted": [{"name": term(effect), "title": _called(workspace, effect)} for effect in found["accepted"]],
            "kind": found["verdict"],
            "headline": found.get("headline", ""),
            "sureness": found.get("sureness", ""),
            "sentence": _further(found) + held_out,
            "why": found["rule"],
            "next": found["next_experiment"],
            "stability": [
                f"{_called(workspace, item)}: {item['stability']}" for item in found["accepted"] if item["stability"]
            ],
            "possible": [f"{_called(workspace, entry)}: {entry['reason']}" for entry in found["possible"]],
            "judged": True,
        }
    if names in workspace.failed:
        return {"kind": "unknown", "sentence": str(workspace.failed[names].what), "judged": False}
    error = answers.error(workspace, names)
    if error is None:
        return {"kind": "unknown", "sentence": "Fitting …", "judged": False}
    floor = session.prepared.noise_floor
    times = [e / max(float(n), 1e-9) for e, n in zip(error, floor, strict=True)]
    worst = max(range(len(times)), key=times.__getitem__)
    joint = session.model.joints[worst]
    kind = "unseen" if session.prepared.verify else "fitted"
    size = f"{digits(error[worst])} {joint.unit('tau')} on {kind} motion, {digits(times[worst], 2)} times its noise"
    text = f"The error of the model at {the_joint(joint.name)} is {size}."
    if not session.prepared.verify:
        text += f" {NOTHING_HELD_OUT}"
    return {"kind": "open", "sentence": text, "judged": False,
            "next": "Discover searches the whole catalogue and judges it."}  # fmt: skip


def _further(found: Mapping[str, Any]) -> str:
    """Return the sentence of an answer beyond its headline."""
    named = "; ".join(effect.get("sentence", "") for effect in found["accepted"])
    return str(found["sentence"]).removeprefix(f"Missing: {named}. ").removeprefix("Check the channels. ")


def _called(workspace: Workspace, one: Mapping[str, Any]) -> str:
    name = term(one)
    return called(name, lambda identifier: _effect(workspace, identifier))


def _suspect(ranking: Ranking, score: Score) -> dict[str, Any]:
    term = score.candidate.term
    draws = ranking.draws.get(score.name, 0)
    low, high = interval(score.p_value, draws)
    agreement = score.agreement
    return {
        "name": score.name,
        "p": score.p_value,
        "significant": score.significant,
        "caution": score.caution,
        "share": share_of_own_joints(score, ranking.fitted.evaluation_rms, ranking.fitted.prepared.noise_floor),
        "sureness": ranking.sureness(score.name),
        "effect": term.effect.id,
        "joint": term.joint,
        "explains": term.effect.explains,
        "custom": term.effect.custom,
        "title": _title(term.effect, score.name),
        "p_low": low,
        "p_high": high,
        "draws": draws,
        "splits": None if agreement is None or agreement.share is None else [agreement.accepted, agreement.of],
    }


def _as_judged(suspect: dict[str, Any], judged: Diagnosis | None) -> dict[str, Any]:
    """Return a suspect with the share and the word that the answer has for it, where there is one."""
    if judged is None:
        return suspect
    said = {item.name: item for item in judged.suspects}.get(suspect["name"])
    return {**suspect, "sureness": ""} if said is None else {
        **suspect, "share": said.explained_share, "sureness": said.sureness
    }  # fmt: skip


def _told_numbers(effect: Effect, accepted: Accepted) -> list[dict[str, Any]]:
    """Return the numbers of an effect as the sentence of the answer names them."""
    said = {k: number_said(effect, k, e.value, e.unit, 0.5 * (e.high - e.low)) for k, e in accepted.parameters.items()}
    numbers = accepted.parameters.items()
    return [{"name": name, "unit": e.unit, "value": e.value, "said": said[name]} for name, e in numbers]


def _numbers(score: Score) -> list[dict[str, Any]]:
    """Return the coefficients and shape values that the ranking found."""
    effect = score.candidate.term.effect
    shape = score.shape[0]
    if score.candidate.tangent:
        shape = score.coefficients[:1]
    units = {key: entry.unit for key, entry in effect.coefficients.items()}
    bent = {key: entry.unit for key, entry in effect.shape.items()}
    pairs = (*zip(units.items(), score.coefficients, strict=False), *zip(bent.items(), shape, strict=False))
    return [
        {"name": key, "unit": unit, "value": float(value), "said": number_said(effect, key, float(value), unit)}
        for (key, unit), value in pairs
    ]


def interval(p: float | None, draws: int) -> tuple[float | None, float | None]:
    """Return the 95 % interval (Wilson 1927) of a p-value that comes from so many placebos."""
    if p is None or draws <= 0:
        return None, None
    n, z = draws + 1, SURE
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return max(0.0, middle - half), min(1.0, middle + half)


def _search(workspace: Workspace) -> dict[str, Any]:
    search = workspace.search
    running = search is not None and search.running
    steps = search.steps if search is not None and running else []
    return {
        "fraction": search.fraction if search is not None and running else 0.0,
        "text": search.text if search is not None and running else "",
        "running": running,
        "steps": [{"label": s["model"], "rms": s["verify_rms"] or s["train_rms"]} for s in steps],
        "message": printable(workspace.search_message),
    }


def _effect(workspace: Workspace, name: str) -> Effect:
    identifier = name.partition(":")[0]
    own = workspace.own.get(identifier)
    return own if own is not None else workspace.model.find_effect(identifier)


def _title(effect: Effect, name: str) -> str:
    return title_of(effect, name.partition(":")[2] or None)
