"""The answer in one word and one sentence, and what to do next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from workbench.report.material import Material

TITLE = "Answer"
ORDER = 10

WORDS = {
    "adequate": "The model is adequate",
    "missing": "An effect is missing",
    "ambiguous": "An effect is missing, and these data cannot tell which of its look-alikes",
    "unexplained": "Something is left that no known effect explains",
}
"""What each verdict means, in words."""


def context(material: Material) -> Mapping[str, Any] | None:
    """Return verdict, sentences, accepted effects and the next experiment."""
    found = material.diagnosis
    if found is None and not material.answer:
        return None
    accepted = [] if found is None else found.to_json().get("accepted", [])
    return {
        "verdict": "" if found is None else found.verdict,
        "words": "" if found is None else WORDS.get(found.verdict, found.verdict),
        "sentence": material.answer or ("" if found is None else found.sentence),
        "rule": "" if found is None else found.rule,
        "accepted": [{"sentence": "", "never_separable": (), **one, "term": term(one)} for one in accepted],
        "next_experiment": "" if found is None else str(found.next_experiment or ""),
        "biased": [] if found is None else list(found.biased),
        "ending": "" if found is None else found.stopped_because,
        "truth": material.truth,
    }


def term(entry: Mapping[str, Any]) -> str:
    """Return "stribeck:knee" for an entry of the JSON."""
    return f"{entry['effect']}:{entry['joint']}" if entry.get("joint") else str(entry["effect"])
