"""The answer in one word and one sentence, and what to do next."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from exoid.diagnosis.report.material import Context, Material
from exoid.diagnosis.report.wording import effect_of, said_of
from exoid.diagnosis.sureness import meanings_of
from exoid.symbolic.formula import formula
from exoid.symbolic.wording import number_said, title_of

TITLE = "Answer"
ORDER = 10

COMMAND = re.compile(r"`([^`]+)`|(exoid design --separate \S+)")
WORDS = {
    "adequate": "Nothing missing",
    "missing": "Found",
    "ambiguous": "Found, with look-alikes",
    "unexplained": "Not explained",
    "check_channels": "Check the channels",
}
"""The verdict in a word or two; what is told of it is the headline of the answer."""


def context(material: Material) -> Context:
    """Return verdict, sentences, accepted effects and the next experiment."""
    found = material.diagnosis
    if found is None and not material.answer:
        return None
    said = {} if found is None else found.to_json()
    next_experiment = "" if found is None else str(found.next_experiment or "")
    words = "" if found is None else WORDS.get(found.verdict, found.verdict)
    headline = "" if found is None else found.headline.removeprefix("Found: ").removeprefix(f"{words}: ")
    return {
        "tiles": tiles(material),
        "verdict": "" if found is None else found.verdict,
        "words": words,
        "headline": f"{headline[:1].upper()}{headline[1:]}",
        "meanings": [] if found is None else meanings_of([found.sureness]),
        "sentence": material.answer or ("" if found is None else found.further),
        "rule": "" if found is None else found.rule,
        "accepted": [accepted_entry(item, material.model) for item in said.get("accepted", ())],
        "possible": [f"{title(term(p), material.model)}: {p['reason']}" for p in said.get("possible", ())],
        # in parts: words, a command, words, a command, ...
        "next_experiment": [part for part in COMMAND.split(next_experiment) if part is not None],
        "biased": [] if found is None else list(found.biased),
        "of_recordings": [entry["sentence"] for entry in said.get("of_recordings", ())],
        "ending": "" if found is None else found.stopped_because,
        "truth": material.truth,
        "pictures": material.pictures_in("verdict"),
        "more": found is not None or bool(material.truth),
    }


def tiles(material: Material) -> list[Mapping[str, Any]]:
    """Return per joint the error before and after the steps (unseen motion where there is some), and the floor, N·m."""
    if (fall := material.fall) is None:
        return []
    first, last = fall.steps[0], fall.steps[-1]
    return [
        {
            "joint": joint,
            "before": float(first.evaluation_rms[j]),
            "after": None if last is first else float(last.evaluation_rms[j]),
            "floor": float(fall.noise_floor[j]),
            "unit": fall.unit,
            "kind": f"on {'the ' * (first.judged == 'fitted')}{first.judged} motion",
        }
        for j, joint in enumerate(fall.joints)
    ]


def accepted_entry(one: Mapping[str, Any], model: Any) -> Mapping[str, Any]:
    """Return an accepted effect of the JSON with what the catalogue says about it."""
    name = term(one)
    effect = effect_of(name, model)
    torques = {} if effect is None else formula(effect)
    alike = {key: [title(other, model) for other in one.get(key) or ()] for key in ("look_alikes", "never_separable")}
    return {
        "stability": "", "sureness": "", **one, **alike, "term": name, "title": title(name, model),
        "meaning": said_of(name, model),
        "torque": "; ".join(f"{joint}: {text}" if joint else text for joint, text in torques.items()),
        "numbers": numbers(one.get("parameters") or {}, effect),
    }  # fmt: skip


def numbers(parameters: Mapping[str, Mapping[str, Any]], effect: Any) -> list[Mapping[str, Any]]:
    """Return words, name, value, unit and interval of each parameter of an effect, the name without the effect's."""
    out: list[Mapping[str, Any]] = []
    for full, p in parameters.items():
        name = full.rsplit(".", 1)[-1]
        half = math.inf if p["low"] is None and p["high"] is None else None
        words = name if effect is None else number_said(effect, name, p["value"], p["unit"], half)
        out.append({**p, "name": name, "words": words, "unit": "" if p["unit"] == "1" else p["unit"]})
    return out


def title(name: str, model: Any) -> str:
    """Title in words of an effect such as "stribeck:knee"; the name itself where nobody knows the effect."""
    effect = effect_of(name, model)
    return name if effect is None else title_of(effect, name.partition(":")[2] or None)


def term(entry: Mapping[str, Any]) -> str:
    """Return "stribeck:knee" for an entry of the JSON."""
    return f"{entry['effect']}:{entry['joint']}" if entry.get("joint") else str(entry["effect"])
