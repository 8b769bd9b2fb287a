"""Was the diagnosis right? The truth under the seal against what was accepted.

A hidden effect is *found* when it is an accepted one, and found *in a class* when it is among the look-alikes of one:
the data could not distinguish them, and the diagnosis said so. Each accepted effect answers for one hidden effect at
most; what answers for none is *extra*.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from exoid.ground.errors import ExoidError
from exoid.ground.plain import AsJson
from exoid.measurement.bench.seal import Truth

SCHEMA = "exoid.discovery/"


class ScoreError(ExoidError):
    """A file that is no diagnosis."""


@dataclass(frozen=True)
class HiddenParameter(AsJson):
    """A hidden number: its `true` value, the estimate and its 95 % interval."""

    name: str
    true: float
    value: float
    low: float
    high: float

    @property
    def inside(self) -> bool:
        """True if the interval contains the truth."""
        return self.low <= self.true <= self.high

    def _json(self) -> dict[str, Any]:
        return {**super()._json(), "inside": self.inside}


@dataclass(frozen=True)
class GradedEffect(AsJson):
    """One hidden effect: `outcome` is "found", "in a class" or "missed"; `by` the accepted one that answers for it."""

    name: str
    outcome: str
    by: str | None
    numbers: tuple[HiddenParameter, ...] = ()


@dataclass(frozen=True)
class Grade(AsJson):
    """Grade of a diagnosis: every hidden effect, the `extra` ones it accepted, its `verdict`, and if it was `right`."""

    hidden: tuple[GradedEffect, ...]
    extra: tuple[str, ...]
    verdict: str

    @property
    def right(self) -> bool:
        """True if everything hidden was found, nothing else was, and nothing hidden was called adequate."""
        all_found = all(effect.outcome != "missed" for effect in self.hidden)
        return all_found and not self.extra and (bool(self.hidden) or self.verdict == "adequate")

    @property
    def lines(self) -> tuple[str, ...]:
        """Say it in words, a line each."""
        said = []
        for effect in self.hidden:
            named = effect.outcome == "in a class"
            said.append(f"{effect.name}: {f'named as a look-alike of {effect.by}' if named else effect.outcome}")
            for n in effect.numbers:
                where = "inside" if n.inside else "outside"
                said.append(f"  {n.name}: true {n.true:.4g}, found {n.value:.4g}, {where} {n.low:.4g} to {n.high:.4g}")
        said += [f"{name}: accepted, but not there" for name in self.extra]
        if not self.hidden and self.verdict != "adequate":
            said.append(f"nothing was hidden, and the verdict is {self.verdict}")
        return (*said, "the diagnosis was right" if self.right else "the diagnosis was wrong")

    def _json(self) -> dict[str, Any]:
        return {"right": self.right, "verdict": self.verdict, "extra": self.extra, "hidden": self.hidden}


def match(hidden: Sequence[str], accepted: Sequence[tuple[str, Sequence[str]]]) -> dict[str, str | None]:
    """Return for each hidden effect the accepted one that answers for it; `accepted` holds (name, look-alikes).

    Those accepted by name come first, so that a class does not take the place of another hidden effect.
    """
    left = list(accepted)
    out: dict[str, str | None] = dict.fromkeys(hidden)
    for by_name in (True, False):
        for name in hidden:
            if out[name] is not None:
                continue
            answer = next((a for a in left if (a[0] == name if by_name else name in a[1])), None)
            if answer is not None:
                out[name] = answer[0]
                left.remove(answer)
    return out


def score(truth: Truth, found: Mapping[str, Any], where: str = "") -> Grade:
    """Score `found`, the JSON of `exoid diagnose` or `discover`, against `truth`; ScoreError for anything else."""
    try:
        if not str(found["schema"]).startswith(SCHEMA):
            raise KeyError("schema")
        verdict = str(found["verdict"])
        parts = {
            a["effect"] + (f":{a['joint']}" if a["joint"] else ""): (list(a["look_alikes"]), dict(a["parameters"]))
            for a in found["accepted"]
        }
        answers = match(truth.terms, [(name, alike) for name, (alike, _) in parts.items()])
        scored = []
        for effect in truth.effects:
            by = answers[effect.term]
            outcome = "missed" if by is None else "found" if by == effect.term else "in a class"
            numbers = _numbers(effect.values, parts[effect.term][1]) if outcome == "found" else ()
            scored.append(GradedEffect(effect.term, outcome, by, numbers))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ScoreError(
            "this is not the JSON of exoid diagnose or discover",
            where=where,
            remedy="write it with: exoid discover REC... --json found.json",
        ) from error
    used = {by for by in answers.values() if by is not None}
    return Grade(tuple(scored), tuple(name for name in parts if name not in used), verdict)


def _numbers(true: Mapping[str, float], found: Mapping[str, Any]) -> tuple[HiddenParameter, ...]:
    return tuple(
        HiddenParameter(name, float(value), *(float(found[name][key]) for key in ("value", "low", "high")))
        for name, value in true.items()
        if name in found and all(found[name].get(key) is not None for key in ("value", "low", "high"))
    )
