"""After the catalogue: is there still structure, and what does it depend on?

A smooth curve with no physics in it (cubic B-splines) in one variable at a time is weighed exactly like a candidate:
on unseen motion, against placebos of itself. If one counts, the remainder is reported with joint, variable, share, the
learnt curve, and closed forms that come close, written in the torque language so that they can be pasted into a model.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.curves import Splines, may_move, splines_along, split_variable, tried_curves, variables
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.gram import RIDGE
from exoid.diagnosis.evidence.look_alikes import joint_losses
from exoid.diagnosis.plots import curve
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.html import bullets, lines, picture
from exoid.ground.ties import ascending, index_of_greatest, index_of_least
from exoid.symbolic.joints import LEG, Joint, names
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PLACES, WIDTHS = np.linspace(0.02, 0.98, 25), np.geomspace(0.01, 0.9, 9)
"""Where between its bounds a number is tried first: the place of a curve, and its width."""
ABOUT, FINER, ROUNDS = np.linspace(-0.1, 0.1, 7), 0.7, 40
"""Where about the best one numbers are tried next, how much nearer every time, and how many times."""


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
    now: FittedModel, evidence: Evidence, joints: Sequence[str] | None = None, *, placebos: int = 3
) -> list[Remainder]:
    """Return every remainder tried at `joints` (default: all), the most telling first, the best `placebos` of them with
    p-values.

    A curve is tried twice: common to all recordings and evaluated on held-out recordings; and with each recording
    having its own, evaluated on held-out blocks of it (where an effect sits may move with strapping and encoder zero).
    """
    judges = (CurveData((evidence,)), curve_data_per_recording(now, evidence))
    seen = np.any([p.used.any(axis=1) for p in now.prepared.train], axis=0)
    places = [k for k, name in enumerate(now.model.joint_names) if seen[k] and name in (joints or [name])]
    found = []
    for place, (variable, factor) in itertools.product(places, tried_curves(now.model.joints)):
        splines = splines_along(now, variable, place, factor, evidence.rules.knots)
        for data in judges if may_move(variable, factor) else judges[:1]:
            if splines is not None:
                remainder = _weighed(now.model.joints, place, variable, factor, data, splines)
                found.append((remainder, data, splines.columns))
    # A curve of its own for each recording must earn that freedom.
    found = ascending(found, lambda item: -item[0].share * (evidence.rules.most if item[0].own else 1.0), 1.0)
    least = least_of_a_curve(evidence.rules)
    return [
        replace(remainder, p_value=data.p_value(columns, remainder.share))
        if k < placebos and remainder.share >= least
        else remainder
        for k, (remainder, data, columns) in enumerate(found)
    ]


@dataclass(frozen=True, eq=False)
class CurveData:
    """Evidence that curves are weighed by: of all recordings together, or, with `own` curves, of one after the other,
    of which the first `fitted` are fitted.
    """

    parts: tuple[Evidence, ...]
    fitted: int = 1
    own: bool = False

    def of(self, columns: Sequence[Columns]) -> list[tuple[Evidence, Sequence[Columns]]]:
        """Return each evidence with the columns on its recordings."""
        return [(part, columns[k : k + 1] if self.own else columns) for k, part in enumerate(self.parts)]

    def loss(self, parts: slice) -> float:
        """Loss on held-out units without any curve."""
        return sum(float(part.fold_losses.sum()) for part in self.parts[parts])

    def share(self, columns: Sequence[Columns], ridge: float = RIDGE) -> float:
        """Share of the loss on held-out units of what is fitted that columns (one node) explain."""
        falls = [float(part.gain(part.plain(some), ridge).total[0]) for part, some in self.of(columns)[: self.fitted]]
        return sum(falls) / max(self.loss(slice(self.fitted)), 1e-300)

    def losses(self, columns: Sequence[Columns], ridge: float = RIDGE) -> Float:
        """Losses with columns (one node) in blocks of time, on all that is held out."""
        every = self.of(columns)[: self.fitted]
        return np.concatenate([joint_losses(part, some, ridge).sum(axis=0) for part, some in every])

    def p_value(self, columns: Sequence[Columns], share: float) -> float:
        """Share of the placebos of a curve that explain as large a `share`, the curve itself counted among them."""
        ridge, every = self.parts[0].rules.curve_ridge, self.of(columns)[: self.fitted]
        null = sum(part.shifted_gains(some, 0, ridge) for part, some in every)
        as_good = int(np.count_nonzero(null >= share * self.loss(slice(self.fitted))))
        return (1 + as_good) / (1 + self.parts[0].draws)


def curve_data_per_recording(now: FittedModel, evidence: Evidence) -> CurveData:
    """Return the evidence of each recording alone, with a torque offset of its own among the columns."""
    out, joints, rules = [], range(len(now.model.joints)), evidence.rules
    prior = np.append(evidence.prior, np.zeros(len(joints)))
    for index, block in enumerate(evidence.blocks):
        samples = block.residual.shape[1]
        folded = [replace(block.beside_offsets(joints), fold=np.arange(samples) * rules.blocks // samples)]
        out.append(
            Evidence(folded, [], seed=index, draws=evidence.draws, sigma=evidence.sigma, prior=prior, rules=rules)
        )
    return CurveData(tuple(out), len(now.prepared.train), own=True)


def _weighed(
    joints: tuple[Joint, ...], index: int, variable: str, factor: str, data: CurveData, splines: Splines
) -> Remainder:
    """Return a curve at the joint `index` with what it gains, without a p-value."""
    seen, held, ridge = slice(data.fitted), slice(data.fitted, None), data.parts[0].rules.curve_ridge
    gains = [part.gain(part.plain(some), ridge) for part, some in data.of(splines.columns)]
    falls, loss = np.array([float(gain.total[0]) for gain in gains]), data.loss(seen)
    each = np.sum([part.joint_losses for part in data.parts[seen]], axis=0)
    if data.own:
        unseen, against = float(falls[held].sum()), data.loss(held)
    else:
        unseen, against = float(gains[0].unseen[0]), data.parts[0].unseen_loss
    share = float(falls[seen].sum()) / loss if loss else 0.0
    y, band = _curve(*data.of(splines.columns)[index_of_greatest(falls)], splines.basis)
    told = unseen / against if against else share
    of_joint = min(1.0, share * float(each.sum() / each[index])) if each[index] else 0.0
    found = joints[index].name, variable, factor, share, told, None, splines.x, y, band, data.own
    return Remainder(*found, joints=joints, joint_share=of_joint)


def least_of_a_curve(rules: Rules) -> float:
    """Return the share of the loss that a curve explains at least: it bends as filter and derivatives err, too."""
    return rules.artefact * rules.least_share


def significant(one: Remainder, rules: Rules = RULES) -> bool:
    """True if a remainder is certain enough to be reported as structure that nobody explains."""
    enough = one.share >= least_of_a_curve(rules) and one.unseen >= rules.least_share
    return one.p_value is not None and one.p_value <= rules.strict_level and enough


def _curve(evidence: Evidence, columns: Sequence[Columns], basis: Float) -> tuple[Float, Float]:
    """Return the learnt curve and the half-width of its 95 % band from the spread over held-out fits (jackknife)."""
    ridge, grams = evidence.rules.curve_ridge, evidence.plain(columns)
    curves = evidence.leave_one_out(grams, ridge) @ basis.T
    y = basis @ evidence.gain(grams, ridge).coefficients[0]
    count = len(curves)
    spread = np.sqrt((count - 1) / count * np.sum((curves - curves.mean(axis=0)) ** 2, axis=0))
    return y - y.mean(), 1.96 * spread


def suggest(one: Remainder) -> tuple[Suggestion, ...]:
    """Return closed forms for a learnt curve, best first: a bump, a step, a wave, powers."""
    word = _word(one)
    x, y = one.x, one.y - one.y.mean()
    torque = one.joints[one.index].unit("tau")
    unit = torque if one.variable == "load" else variables(one.joints)[one.variable][1]
    per = f"{torque}·s/{one.joints[one.index].unit('q')}" if one.factor == "speed" else torque
    span = float(np.ptp(x))
    factor = {"sign": " * sgn(dtheta)", "speed": " * dtheta"}.get(one.factor, "")
    forms = (
        (f"c * exp(-(({word} - m)/w)**2){factor}", lambda p: np.exp(-(((x - p[0]) / p[1]) ** 2)), ""),
        (f"c * tanh(({word} - m)/w){factor}", lambda p: np.tanh((x - p[0]) / p[1]), ""),
        (f"c * ({word} - m)**2{factor}", lambda p: (x - p[0]) ** 2, f"/({unit})²"),
        (f"c * ({word} - m)**3{factor}", lambda p: (x - p[0]) ** 3, f"/({unit})³"),
    )
    out = []
    total = float(np.sum(y**2))
    if not total:
        return ()
    for text, shape, power in forms:
        numbers = 1 if power else 2
        low = np.array([x.min() - 0.2 * span, 0.02 * span][:numbers])
        high = np.array([x.max() + 0.2 * span, 1.5 * span][:numbers])

        def misfit(p: Float, shape: Any = shape) -> Float:
            g = shape(p[..., None])
            g = g - g.mean(axis=-1, keepdims=True)
            c = (g @ y) / np.maximum(np.sum(g * g, axis=-1), 1e-300)
            return np.asarray(y - c[..., None] * g)

        best, left = _least_squares(misfit, low, high)
        values = {key: (unit, low[k], high[k], float(best[k])) for k, key in enumerate("mw"[:numbers])}
        out.append(Suggestion(text, 1.0 - left / total, {"c": per + power}, values))
    return tuple(ascending((s for s in out if s.share > 0.3), lambda s: -s.share, 1.0))


def _least_squares(misfit: Callable[[Float], Float], low: Float, high: Float) -> tuple[Float, float]:
    """Point between `low` and `high` (S,) where the sum of squares of `misfit`, which takes (S, ...), is lowest, and
    that sum: the best of a grid over all of it, then of finer and finer ones about the best.
    """
    tried = np.array(list(itertools.product(PLACES, WIDTHS)))[:, : len(low)]
    about = np.array(list(itertools.product(*[ABOUT] * len(low))))
    for k in range(ROUNDS):
        squares = np.sum(misfit((low + tried * (high - low)).T) ** 2, axis=1)
        best = index_of_least(squares)
        at, left = tried[best], float(squares[best])
        tried = np.clip(at + FINER**k * about, 0.0, 1.0)
    return low + at * (high - low), left


def _word(one: Remainder) -> str:
    kind, index = split_variable(one.variable)
    stem = {"q": "theta", "dq": "dtheta", "ddq": "ddtheta", "load": "tau_rigid", "t": "t"}[kind]
    word = stem if index in (one.index, -1) else f"{stem}{index + 1}"
    return f"abs({word})" if one.directed and kind == "dq" else word
