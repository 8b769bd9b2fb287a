"""Consistency between recordings: a parameter that one recording wants different from all the others.

One model is fitted to all recordings. Then each of its parameters (a load that was not named changes inertias), and the
offset of each torque sensor, may for once differ in one recording; all else is refitted. A difference that is neither
within the interval (valid under autocorrelation, `exoid.optimisation.linear.uncertainty`; widened for the number of
questions) nor too small to matter is named: something was changed between the recordings, or the effect is not what it
seems.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import Evidence, RecordingEvidence, robust_weight
from exoid.diagnosis.evidence.gram import weighted_fit
from exoid.diagnosis.rules import Rules
from exoid.ground.plain import AsJson
from exoid.optimisation.linear.uncertainty import FIXED_B, block_length, block_outer
from exoid.symbolic.joints import UNITS
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float


@dataclass(frozen=True)
class Differing(AsJson):
    """A number `name` that recording `recording` wants to be `value` and the others `others`, both in `unit`.

    `half_width` is that of the difference (95 % for all questions asked together), `share` what the difference explains
    of the recording's weighted squared error.
    """

    recording: str
    name: str
    value: float
    others: float
    half_width: float
    unit: str
    share: float

    @property
    def sentence(self) -> str:
        """The difference in words."""
        unit = "" if self.unit in ("", "1") else f" {self.unit}"
        kind, _, joint = self.name.partition(":")
        if kind == "zero":
            side = "above" if self.value > 0.0 else "below"
            return (
                f"{self.recording}: the {joint} torque lies {abs(self.value):.2g}{unit} {side} what the others say "
                "(another zero of the sensor, a load that --payload should name?)"
            )
        return (
            f"{self.recording}: {self.name} is {self.value:.3g} there, {self.others:.3g}{unit} in the others "
            f"(difference known to ± {self.half_width:.2g})"
        )

    def _json(self) -> dict[str, Any]:
        return {
            "recording": self.recording, "parameter": self.name, "value": self.value, "others": self.others,
            "half_width": self.half_width, "unit": self.unit, "explained_share": self.share, "sentence": self.sentence,
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Question:
    """One number that may differ: its value now, its unit, its place among the model's columns, or a joint's zero."""

    name: str
    value: float
    unit: str
    index: int | None
    joint: int = 0

    def column(self, block: RecordingEvidence) -> Float:
        """Return its column (J, K)."""
        if self.index is not None:
            return np.asarray(block.columns[:, :, self.index])
        out = np.zeros(block.residual.shape)
        out[self.joint] = 1.0
        return out


def differing(now: FittedModel, evidence: Evidence) -> tuple[Differing, ...]:
    """Return what single recordings want different, largest share first; () where there is only one recording.

    `evidence` is that of `now`. All recordings are asked, verification ones too: nothing is decided by the answer. What
    differs most is granted before the rest is asked again, or one odd recording would make all others look odd.
    """
    blocks, questions = list(evidence.blocks), _questions(now.model, now.linear, now.shapes)
    rules = evidence.rules
    if not 2 <= len(blocks) <= rules.differing_recordings:
        return ()
    inverse = NormalDist().inv_cdf
    strict = inverse(0.025 / (len(questions) * len(blocks))) / inverse(0.025)
    prior = evidence.prior
    out: dict[tuple[int, str], Differing] = {}
    while len(out) < rules.differing_named:
        pooled = _Pooled(blocks, evidence.sigma, prior, rules)
        found: tuple[Differing, int, _Question] | None = None
        for number, one in enumerate(now.prepared.all):
            for question in questions:
                answer = None if (number, question.name) in out else pooled.answer(number, question)
                if answer is None:
                    continue
                change, half, share, moved = answer
                others = question.value + (0.0 if question.index is None else moved[question.index])
                small = question.index is not None and abs(change) < rules.little * abs(others)
                matters = share >= rules.worth_telling and abs(change) > strict * half and not small
                if matters and (found is None or share > found[0].share):
                    text = question.name, others + change, others, strict * half, question.unit, share
                    found = Differing(one.name, *text), number, question
        if found is None:
            break
        named, number, question = found
        out[number, question.name] = named
        own = question.column(blocks[number])
        blocks = [_with_column(b, own if k == number else np.zeros(b.residual.shape)) for k, b in enumerate(blocks)]
        prior = np.append(prior, 0.0)
    return tuple(out.values())


def _with_column(block: RecordingEvidence, column: Float) -> RecordingEvidence:
    return replace(block, columns=np.concatenate([block.columns, column[:, :, None]], axis=2))


def _questions(model: Model, linear: Float, shapes: Float) -> list[_Question]:
    """Return the parameters of the model that are the same in all recordings, and the torques' offsets."""
    count = len(model.parameters)
    out = [_Question(p.name, float(linear[k]), p.unit, k) for k, p in enumerate(model.parameters)]
    for k, entry in enumerate(model.shapes):
        if not entry.shape.choices and not entry.shape.per_recording:
            out.append(_Question(entry.name, float(shapes[0, k]), entry.shape.unit, count + k))
    return out + [
        _Question(f"zero:{joint.name}", 0.0, UNITS["tau"][not joint.turns], None, k)
        for k, joint in enumerate(model.joints)
    ]


class _Pooled:
    """The model fitted to all recordings together (weighted, linearised at its shapes), ready to be asked."""

    def __init__(self, blocks: list[RecordingEvidence], sigma: Float, prior: Float, rules: Rules) -> None:
        self.blocks, self.rules = blocks, rules
        self.weights = [robust_weight(b, sigma, rules) / sigma[:, None] ** 2 for b in self.blocks]
        columns, residuals = [b.columns for b in blocks], [b.residual for b in blocks]
        self.inverse, step = weighted_fit(columns, self.weights, residuals, prior)
        self.left = [b.residual - b.columns @ step for b in self.blocks]

    def answer(self, number: int, question: _Question) -> tuple[float, float, float, Float] | None:
        """Return the change that recording `number` wants, its 95 % half-width, the share of the recording's loss that
        it explains, and how all columns' numbers (P,) then move in the others. None where it cannot be told; a share
        that matters to nobody has an infinite half-width.
        """
        block, weight = self.blocks[number], self.weights[number]
        own = question.column(block)
        lean = self.inverse @ np.einsum("jkp,jk,jk->p", block.columns, weight, own, optimize=True)
        rest = [-(b.columns @ lean) for b in self.blocks]
        rest[number] = rest[number] + own
        power = self._sum(rest, rest)
        loss = float(np.sum(weight * self.left[number] ** 2))
        if loss <= 0.0 or power <= self.rules.negligible * float(np.sum(weight * own * own)):
            return None
        change = self._sum(rest, self.left) / power
        share = change**2 * power / loss
        if share < self.rules.worth_telling:
            return change, np.inf, share, -lean * change
        score = np.concatenate(
            [np.sum(w * x * (r - change * x), axis=0) for w, x, r in zip(self.weights, rest, self.left, strict=True)]
        )[:, None]
        groups = np.repeat(np.arange(len(self.blocks)), [b.residual.shape[1] for b in self.blocks])
        lag = block_length(score, groups)
        critical = float(np.polynomial.polynomial.polyval(min(lag / len(score), 1.0), FIXED_B))
        half = critical * float(np.sqrt(block_outer(score, groups, lag)[0, 0])) / power
        return change, half, share, -lean * change

    def _sum(self, x: list[Float], y: list[Float]) -> float:
        return float(sum(np.sum(w * a * b) for w, a, b in zip(self.weights, x, y, strict=True)))
