"""After the catalogue: is there still structure, and what does it depend on?

A smooth curve with no physics in it (cubic B-splines) in one variable at a time is weighed exactly like a candidate:
on unseen motion, against placebos of itself. If one counts, the remainder is reported with joint, variable, share, the
learnt curve, and closed forms that come close, written in the torque language so that they can be pasted into a model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.curves import Splines, may_move, splines_along, tried_curves, variables
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.gram import Gain
from exoid.diagnosis.plots import curve
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.html import bullets, lines, picture
from exoid.ground.ties import ascending, index_of_greatest
from exoid.symbolic.joints import LEG, Joint, names
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Remainder:
    """A curve in one variable at one joint, times a `factor`: nothing, or "sign" or "speed" of the joint's motion.

    `share` of the weighted unseen loss of all joints, `joint_share` of that of its own; `x` (M,), `y` (M,) N·m and
    `band` (M,) (95 %) are the learnt curve. `own`: every recording has a curve of its own (that of the recording which
    shows it best is given).
    """

    joint: str
    variable: str
    factor: str
    share: float
    unseen: float
    p_value: float | None
    x: Float = field(repr=False)
    y: Float = field(repr=False)
    band: Float = field(repr=False)
    own: bool = False
    suggestions: tuple[Suggestion, ...] = ()
    joints: tuple[Joint, ...] = LEG
    joint_share: float = 0.0

    @property
    def index(self) -> int:
        """Index of its joint."""
        return [joint.name for joint in self.joints].index(self.joint)

    @property
    def directed(self) -> bool:
        """True if it turns its sign with the direction of motion."""
        return self.factor == "sign"

    @property
    def variables(self) -> list[str]:
        """Return all variables it depends on."""
        own = self.index + 1
        return list(dict.fromkeys([self.variable, *([f"dq{own}"] if self.factor else [])]))

    @property
    def sentence(self) -> str:
        """Say what is left in words."""
        words, _ = variables(self.joints)[self.variable]
        turned = {"sign": ", with the sign of the motion", "speed": ", times its velocity"}.get(self.factor, "")
        moved = ", at a place that differs between recordings" if self.own else ""
        return f"{self.joint}: {100 * self.joint_share:.0f} % of what is left follows the {words}{turned}{moved}"

    def plot(self) -> Figure:
        """Draw the learnt curve with its band."""
        factor = {"sign": " × sign of motion", "speed": " × velocity"}.get(self.factor, "")
        unit = self.joints[self.index].unit("tau")
        words, own = variables(self.joints)[self.variable]
        variable = words, unit if self.variable == "load" else own
        return curve(self.joint, variable, self.x, self.y, self.band, factor, names(self.joints), unit)

    def _repr_html_(self) -> str:
        texts = [f"torque = {s.text} ({100 * s.share:.0f} % of the curve)" for s in self.suggestions]
        return lines(strong=self.sentence) + picture(self.plot(), self.sentence) + bullets(texts)


@dataclass(frozen=True)
class Suggestion:
    """A closed form that comes close: torque text with numbers as coefficients and shapes; `share` of the curve."""

    text: str
    share: float
    coefficients: Mapping[str, str]
    shape: Mapping[str, tuple[str, float, float, float]]

    def to_toml(self, joint: str, own: bool = False, identifier: str = "my_effect") -> str:
        """Return a `[[custom_effects]]` block for a model file; `own`: its place differs between recordings."""
        moves = ", per_recording = true" if own else ""
        numbers = ", ".join(f'{k} = {{ unit = "{unit}" }}' for k, unit in self.coefficients.items())
        lines = [
            "[[custom_effects]]",
            f'id = "{identifier}"',
            f'joint = "{joint}"',
            f'torque = "{self.text}"',
            f"coefficients = {{ {numbers} }}",
        ]
        if self.shape:
            shapes = ", ".join(
                f'{k} = {{ unit = "{unit}", min = {low:.4g}, max = {high:.4g}{moves if k == "m" else ""} }}'
                for k, (unit, low, high, _) in self.shape.items()
            )
            lines.append(f"shape = {{ {shapes} }}")
        lines.append('explains = "found as a remainder; say here what it is"')
        return "\n".join(lines) + "\n"


def remainders(
    now: FittedModel,
    evidence: Evidence,
    joints: Sequence[str] | None = None,
    *,
    placebos: int = 3,
) -> list[Remainder]:
    """Return every remainder tried at `joints` (default: all), the most telling first, the best `placebos` of them with
    p-values.

    A curve is tried twice: common to all recordings and evaluated on held-out recordings; and with each recording
    having its own, evaluated on held-out blocks of it (where an effect sits may move with strapping and encoder zero).
    """
    common = [CurveData(evidence, tuple(range(len(evidence.blocks))))]
    owns = curve_data_per_recording(now, evidence)
    seen = np.any([p.used.any(axis=1) for p in now.prepared.train], axis=0)
    places = [k for k, name in enumerate(now.model.joint_names) if seen[k] and name in (joints or [name])]
    asked = [(place, variable, factor) for place in places for variable, factor in tried_curves(now.model.joints)]
    found = []
    for place, variable, factor in asked:
        splines = splines_along(now, variable, place, factor, evidence.rules.knots)
        if splines is not None:
            for own, parts in _modes(variable, factor, common, owns):
                gained = _weigh(parts, splines, place, own)
                joint = now.model.joint_names[place]
                found.append(Remainder(joint, variable, factor, p_value=None, joints=now.model.joints, **gained))
    # A curve of its own for each recording must earn that freedom.
    found = ascending(found, lambda remainder: -remainder.share * (evidence.rules.most if remainder.own else 1.0), 1.0)
    for k, remainder in enumerate(found[:placebos]):
        if remainder.share >= least_of_a_curve(evidence.rules):
            splines = splines_along(now, remainder.variable, remainder.index, remainder.factor, evidence.rules.knots)
            columns = splines.columns if splines is not None else ()
            found[k] = replace(remainder, p_value=_p_value(owns if remainder.own else common, columns, remainder.share))
    return found


def _modes(
    variable: str, factor: str, common: list[CurveData], owns: list[CurveData]
) -> tuple[tuple[bool, list[CurveData]], ...]:
    """Return the ways to evaluate a curve: common to all recordings, and, where it may move, one in each."""
    return ((False, common), (True, owns)) if may_move(variable, factor) else ((False, common),)


@dataclass(frozen=True, eq=False)
class CurveData:
    """Evidence that curves are evaluated on: that of some of the recordings (`which`, indices)."""

    evidence: Evidence
    which: tuple[int, ...]
    trained: bool = True

    @property
    def curve_ridge(self) -> float:
        """Relative ridge of a curve."""
        return self.evidence.rules.curve_ridge

    def columns(self, columns: Sequence[Columns]) -> list[Columns]:
        """Return those of its recordings."""
        return [columns[i] for i in self.which]

    def gain(self, splines: Sequence[Columns]) -> Gain:
        """Gain of a curve."""
        return self.evidence.gain(self.evidence.plain(self.columns(splines)), self.curve_ridge)


def curve_data_per_recording(now: FittedModel, evidence: Evidence) -> list[CurveData]:
    """Return the evidence of each recording alone, with a torque offset of its own among the columns."""
    out = []
    joints = len(now.model.joints)
    prior = np.append(evidence.prior, np.zeros(joints))
    for index, block in enumerate(evidence.blocks):
        samples = block.residual.shape[1]
        zeros = np.repeat(np.eye(joints)[:, None, :], samples, axis=1)
        columns = np.concatenate([block.columns, zeros], axis=2)
        folded = replace(block, columns=columns, fold=np.arange(samples) * evidence.rules.blocks // samples)
        alone = Evidence(
            [folded], [], seed=index, draws=evidence.draws, sigma=evidence.sigma, prior=prior, rules=evidence.rules
        )
        out.append(CurveData(alone, (index,), index < len(now.prepared.train)))
    return out


def _weigh(parts: Sequence[CurveData], splines: Splines, index: int, own: bool) -> dict[str, Any]:
    """Gain of a curve on the `parts`, at the joint `index`, as fields of a Remainder."""
    gains = [j.gain(splines.columns) for j in parts]
    fall = sum(float(g.total[0]) for g, j in zip(gains, parts, strict=True) if j.trained)
    loss = sum(float(j.evidence.fold_losses.sum()) for j in parts if j.trained)
    each = np.sum([j.evidence.joint_losses for j in parts if j.trained], axis=0)
    if own:
        fresh = [(float(g.total[0]), float(j.evidence.fold_losses.sum())) for g, j in zip(gains, parts, strict=True)]
        unseen = sum(f for (f, _), j in zip(fresh, parts, strict=True) if not j.trained)
        against = sum(w for (_, w), j in zip(fresh, parts, strict=True) if not j.trained)
        best = index_of_greatest([fall for fall, _ in fresh])
    else:
        unseen, against, best = float(gains[0].unseen[0]), parts[0].evidence.unseen_loss, 0
    share = fall / loss if loss else 0.0
    y, band = _curve(parts[best], splines)
    return {
        "own": own,
        "share": share,
        "unseen": unseen / against if against else share,
        "joint_share": min(1.0, share * float(each.sum() / each[index])) if each[index] else 0.0,
        "x": splines.x,
        "y": y,
        "band": band,
    }


def _p_value(parts: Sequence[CurveData], columns: Sequence[Columns], share: float) -> float:
    trained = [j for j in parts if j.trained]
    null = sum(j.evidence.shifted_gains(j.columns(columns), 0, j.curve_ridge) for j in trained)
    loss = sum(float(j.evidence.fold_losses.sum()) for j in trained)
    return (1 + int(np.count_nonzero(null >= share * loss))) / (1 + trained[0].evidence.draws)


def least_of_a_curve(rules: Rules) -> float:
    """Return the share of the loss that a curve explains at least: it bends as filter and derivatives err, too."""
    return rules.artefact * rules.least_share


def significant(one: Remainder, rules: Rules = RULES) -> bool:
    """True if a remainder is certain enough to be reported as structure that nobody explains."""
    enough = one.share >= least_of_a_curve(rules) and one.unseen >= rules.least_share
    return one.p_value is not None and one.p_value <= rules.strict_level and enough


def _curve(part: CurveData, splines: Splines) -> tuple[Float, Float]:
    """Return the learnt curve and the half-width of its 95 % band from the spread over held-out fits (jackknife)."""
    grams = part.evidence.plain(part.columns(splines.columns))
    curves = part.evidence.leave_one_out(grams, part.curve_ridge) @ splines.basis.T
    y = splines.basis @ part.evidence.gain(grams, part.curve_ridge).coefficients[0]
    count = len(curves)
    spread = np.sqrt((count - 1) / count * np.sum((curves - curves.mean(axis=0)) ** 2, axis=0))
    return y - y.mean(), 1.96 * spread
