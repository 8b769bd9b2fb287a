"""After the catalogue: is there still structure, and what does it depend on?

A smooth curve with no physics in it (cubic B-splines) in one variable at a time is weighed exactly like a candidate:
on unseen motion, against placebos of itself. If one counts, the remainder is reported with joint, variable, share, the
learnt curve, and closed forms that come close, written in the torque language so that they can be pasted into a model.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from diagnosis.evidence.candidates import Candidate, candidate_columns, own_torques
from diagnosis.evidence.columns import Columns
from diagnosis.evidence.fitted import FittedModel
from diagnosis.evidence.gain import Evidence, Gain
from diagnosis.evidence.look_alikes import block_losses
from diagnosis.evidence.score import weigh
from diagnosis.evidence.splines import spline_columns
from diagnosis.plots import curve
from diagnosis.rules import RULES, Rules
from ground.engines.forks import allowed_processes, first_passing, share_out
from ground.html import bullets, lines
from optimisation.preparation.filtering import PreparedRecording
from optimisation.preparation.prepare import Prepared
from symbolic.effect import Coefficient, Effect, Shape
from symbolic.joints import LEG, UNITS, Joint
from symbolic.motion import Float
from symbolic.term import Term

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BUMP_LEVELS = np.linspace(0.06, 0.94, 23)
"""Quantiles of a path at which bumps are tried."""
_WORDS = {"q": ("angle", "position"), "dq": ("velocity", "velocity"), "ddq": ("acceleration", "acceleration")}


@lru_cache(maxsize=32)
def variables(joints: tuple[Joint, ...] = LEG) -> Mapping[str, tuple[str, str]]:
    """Return the variables a remainder may depend on, {"dq2": (name in words, unit)}."""
    found = {
        f"{stem}{k + 1}": (f"{joint.name} {words[not joint.turns]}", UNITS[stem][not joint.turns])
        for stem, words in _WORDS.items()
        for k, joint in enumerate(joints)
    }
    return {**found, "load": ("rigid-body torque of the joint", "N·m"), "t": ("time", "s")}


def split_variable(variable: str) -> tuple[str, int]:
    """Return ("dq", 1) for "dq2"; ("load", -1) for one without a joint's number."""
    stem = variable.rstrip("0123456789")
    return stem, int(variable[len(stem) :] or 0) - 1


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
        """Whether it turns its sign with the direction of motion."""
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
        return curve(self.joint, variable, self.x, self.y, self.band, factor, unit)

    def _repr_html_(self) -> str:
        texts = [f"torque = {s.text} ({100 * s.share:.0f} % of the curve)" for s in self.suggestions]
        return lines(strong=self.sentence) + bullets(texts)


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

    A curve is tried twice: common to all recordings and judged on held-out recordings; and with each recording having
    its own, judged on held-out blocks of it (where an effect sits may move with strapping and encoder zero).
    """
    common = [_Judge(evidence, tuple(range(len(evidence.blocks))))]
    owns = _own_judges(now, evidence)
    seen = np.any([p.use.any(axis=0) for p in now.prepared.train], axis=0)
    places = [k for k, name in enumerate(now.model.joint_names) if seen[k] and name in (joints or [name])]
    asked = [(place, variable, factor) for place in places for variable, factor in _tried(now.model.joints)]
    answers: dict[int, list[dict[str, Any]]] = {}

    def weighed(k: int) -> list[dict[str, Any]]:
        place, variable, factor = asked[k]
        splines = _splines(now, variable, place, factor, evidence.rules.knots)
        modes = _modes(variable, factor, common, owns) if splines is not None else ()
        return [_weigh(judges, splines, place, own) for own, judges in modes if splines is not None]

    many = allowed_processes()
    share_out(weighed, range(len(asked)), answers.__setitem__, many)
    found = []
    for k, (place, variable, factor) in enumerate(asked):
        for answer in answers[k]:
            arrays = {name: np.array(answer[name]) for name in ("x", "y", "band")}
            joint = now.model.joint_names[place]
            one = Remainder(joint, variable, factor, p_value=None, joints=now.model.joints, **{**answer, **arrays})
            found.append(one)
    # A curve of its own for each recording must earn that freedom.
    found.sort(key=lambda one: -one.share * (evidence.rules.own_handicap if one.own else 1.0))
    telling = [k for k, one in enumerate(found[:placebos]) if one.share >= evidence.rules.curve_share]

    def chance(k: int) -> float:
        one = found[k]
        splines = _splines(now, one.variable, one.index, one.factor, evidence.rules.knots)
        return _p_value(owns if one.own else common, splines.columns if splines is not None else (), one.share)

    def settled(k: int, p_value: float) -> None:
        found[k] = replace(found[k], p_value=p_value)

    share_out(chance, telling, settled, many)
    return found


def _tried(joints: tuple[Joint, ...]) -> tuple[tuple[str, str], ...]:
    """Return (variable, factor). A velocity with the sign of motion is |θ'| with the sign of θ': it may jump at
    standstill.
    """
    known = variables(joints)
    return (
        *((v, "") for v in known),
        *((v, "sign") for v in known if v != "t" and not v.startswith("ddq")),
        *((v, "speed") for v in known if split_variable(v)[0] == "q"),
    )


def _may_move(variable: str, factor: str) -> bool:
    """Whether strapping can move a curve in this variable: the place of a stop or a bump, on the path."""
    return split_variable(variable)[0] == "q" and not factor


def _modes(
    variable: str, factor: str, common: list[_Judge], owns: list[_Judge]
) -> tuple[tuple[bool, list[_Judge]], ...]:
    """Return the ways to judge a curve."""
    return ((False, common), (True, owns)) if _may_move(variable, factor) else ((False, common),)


@dataclass(frozen=True, eq=False)
class _Judge:
    """Evidence on some of the recordings (`which`, indices)."""

    evidence: Evidence
    which: tuple[int, ...]
    trained: bool = True

    @property
    def curve_ridge(self) -> float:
        return self.evidence.rules.curve_ridge

    def columns(self, columns: Sequence[Columns]) -> list[Columns]:
        return [columns[i] for i in self.which]

    def gain(self, splines: Sequence[Columns]) -> Gain:
        """Return what a curve gains."""
        return self.evidence.gain(self.evidence.plain(self.columns(splines)), self.curve_ridge)


@dataclass(frozen=True, eq=False)
class _Splines:
    """Filtered spline columns per recording, and the basis (M, m) on a grid `x` (M,) over the range."""

    columns: tuple[Columns, ...]
    x: Float
    basis: Float


def _own_judges(now: FittedModel, evidence: Evidence) -> list[_Judge]:
    """Return a judge for each recording, to whom the zeros of its torque sensors are no news."""
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
        out.append(_Judge(alone, (index,), index < len(now.prepared.train)))
    return out


def _weigh(judges: Sequence[_Judge], splines: _Splines, index: int, own: bool) -> dict[str, Any]:
    """Return what judges say of a curve at the joint `index`, as JSON can write it."""
    gains = [j.gain(splines.columns) for j in judges]
    fall = sum(float(g.total[0]) for g, j in zip(gains, judges, strict=True) if j.trained)
    loss = sum(float(j.evidence.fold_losses.sum()) for j in judges if j.trained)
    each = np.sum([j.evidence.joint_losses for j in judges if j.trained], axis=0)
    if own:
        fresh = [(float(g.total[0]), float(j.evidence.fold_losses.sum())) for g, j in zip(gains, judges, strict=True)]
        unseen = sum(f for (f, _), j in zip(fresh, judges, strict=True) if not j.trained)
        against = sum(w for (_, w), j in zip(fresh, judges, strict=True) if not j.trained)
        best = max(range(len(judges)), key=lambda i: fresh[i][0])
    else:
        unseen, against, best = float(gains[0].unseen[0]), judges[0].evidence.unseen_loss, 0
    share = fall / loss if loss else 0.0
    y, band = _curve(judges[best], splines)
    return {
        "own": own,
        "share": share,
        "unseen": unseen / against if against else share,
        "joint_share": min(1.0, share * float(each.sum() / each[index])) if each[index] else 0.0,
        "x": splines.x.tolist(),
        "y": y.tolist(),
        "band": band.tolist(),
    }


def _p_value(judges: Sequence[_Judge], columns: Sequence[Columns], share: float) -> float:
    trained = [j for j in judges if j.trained]
    null = sum(j.evidence.gain(j.evidence.shifted(j.columns(columns), 0), j.curve_ridge).total[1:] for j in trained)
    loss = sum(float(j.evidence.fold_losses.sum()) for j in trained)
    return (1 + int(np.count_nonzero(null >= share * loss))) / (1 + trained[0].evidence.draws)


CONSTANT = 1e-4
"""Relative variation below which a column is constant: the filter leaves some."""


@dataclass(frozen=True, eq=False)
class Winner:
    """A curve without physics that beat a term: its columns (one node) on every recording, and who judged it."""

    columns: tuple[Columns, ...]
    judges: tuple[_Judge, ...]
    ridge: float | None
    share: float

    def leaves(self, term: Sequence[Columns]) -> float:
        """Return the share of the loss that a term (one node) still explains beside the curve."""
        both = [_beside(c, t) for c, t in zip(self.columns, term, strict=True)]
        return _share(self.judges, both, self.ridge) - self.share

    def supersedes(self, term: Sequence[Columns]) -> bool:
        """Whether a term adds less than half of its own gain to the curve.

        A constant adds nothing to any curve, each of which contains it: there the curve has to gain clearly more; and
        where recordings have offsets of their own, a constant says nothing.
        """
        rules, alone = self.judges[0].evidence.rules, _share(self.judges, term)
        if all(np.ptp(one.values, axis=2).max() < CONSTANT * np.abs(one.values).max() for one in term):
            return rules.least_share <= alone < rules.near * self.share
        return self.leaves(term) < rules.superseded * alone


def beaten(now: FittedModel, evidence: Evidence, joint: str, term: Sequence[Columns], numbers: int) -> Winner | None:
    """Return the curve without physics at `joint` that clearly beats the columns (one node) of a term, judged alike.

    Beaten is a term that a curve gains clearly more than, in the scatter of blocks of time, or that a single bump with
    fewer numbers than the `numbers` of the term gains as much as; and that adds little to that curve: it was a
    stand-in. A term beside which something else is left adds nearly as much to a curve as it gains alone. `now` and
    `evidence` are of the model without the term.
    """
    rules = evidence.rules
    common = (_Judge(evidence, tuple(range(len(evidence.blocks)))),)
    contests: list[Callable[[], Winner | None]] = []
    for judges, own in ((common, False), (tuple(_own_judges(now, evidence)), True)):
        mine, losses = _share(judges, term), _blocks(judges, term)

        def by_curve(
            variable: str, factor: str, judges: Sequence[_Judge] = judges, mine: float = mine, losses: Float = losses
        ) -> Winner | None:
            splines = _splines(now, variable, now.model.joint_names.index(joint), factor, rules.knots)
            if splines is None:
                return None
            share = _share(judges, splines.columns, rules.curve_ridge)
            curve = Winner(splines.columns, tuple(judges), rules.curve_ridge, share)
            if curve.share <= mine + rules.beaten_share:
                return None
            lead = losses - _blocks(judges, splines.columns, rules.curve_ridge)
            clear = lead.sum() >= rules.beaten * np.sqrt(np.sum((lead - lead.mean()) ** 2))
            return curve if clear and curve.supersedes(term) else None

        tried = (pair for pair in _tried(now.model.joints) if not own or _may_move(*pair))
        contests += [partial(by_curve, variable, factor) for variable, factor in tried]
    alone = _share(common, term)

    def by_bump(candidate: Candidate) -> Winner | None:
        columns = [
            candidate_columns(candidate, nodes, one, now)
            for nodes, one in zip(candidate.nodes, now.prepared.all, strict=True)
        ]
        score = weigh(evidence, candidate, columns)
        best = tuple(c.node(int(n)) for c, n in zip(columns, score.nodes, strict=True))
        bump = Winner(best, common, None, score.share)
        as_good = score.share >= rules.as_good * alone and candidate.numbers < numbers
        return bump if as_good and bump.supersedes(term) else None

    contests += [partial(by_bump, candidate) for candidate in _bumps(now, joint)]
    won = first_passing(lambda k: contests[k]() is not None, len(contests), allowed_processes())
    return None if won is None else contests[won]()


def _bumps(now: FittedModel, joint: str) -> list[Candidate]:
    """Return single bumps in the angles and in the joint's own velocity, as candidates at `joint`."""
    own, known = now.model.joint_names.index(joint) + 1, variables(now.model.joints)
    others = [k for k in range(1, len(now.model.joints) + 1) if k != own]
    out = []
    for word, variable in (*((f"theta{k}", f"q{k}") for k in (own, *others)), (f"dtheta{own}", f"dq{own}")):
        paths = [signal_of(p, now, variable, own - 1) for p in now.prepared.all]
        low, high = np.quantile(np.concatenate(paths), (0.02, 0.98))
        if not high - low > 1e-9:
            continue
        effect = Effect(
            f"bump_in_{variable}",
            "a single bump, no physics",
            f"c * exp(-(({word} - m)/w)**2)",
            None,
            (joint,),
            {"c": Coefficient(UNITS["tau"][not now.model.joints[own - 1].turns])},
            {
                "m": Shape(known[variable][1], low, high, per_recording=variable.startswith("q")),
                "w": Shape(known[variable][1], 0.05 * (high - low), 0.3 * (high - low), spacing="log"),
            },
            custom=True,
        )
        widths = np.geomspace(0.05, 0.3, 5) * (high - low)
        pooled = [np.quantile(np.concatenate(paths), BUMP_LEVELS)] * len(paths)
        each_own = [np.quantile(path, BUMP_LEVELS) for path in paths]
        tried = [each_own, pooled] if variable.startswith("q") else [pooled]
        nodes = np.concatenate(
            [np.array([[(m, w) for m in places for w in widths] for places in each]) for each in tried], axis=1
        )
        out.append(Candidate(Term(effect, joint, now.model.joints), nodes, False))
    return out


def _blocks(judges: Sequence[_Judge], columns: Sequence[Columns], ridge: float | None = None) -> Float:
    """Return the losses of columns (one node) in blocks of time, on all that the judges hold out."""
    trained = [(j.evidence, j.columns(columns)) for j in judges if j.trained]
    return np.concatenate([block_losses(e, e.plain(c), c, ridge) for e, c in trained])


def _beside(curve: Columns, term: Columns) -> Columns:
    """Return both as one candidate, the term's columns scaled like the curve's so that the ridge treats them alike."""
    size = np.sqrt(np.mean(curve.values**2)) / max(float(np.sqrt(np.mean(term.values**2))), 1e-300)
    joints = 1 + max(*curve.joints, *term.joints)
    both = np.concatenate([curve.full(0, joints), size * term.full(0, joints)], axis=2)
    return Columns(tuple(range(len(both))), both[None])


def _share(judges: Sequence[_Judge], columns: Sequence[Columns], ridge: float | None = None) -> float:
    """Return the share of the loss on held-out units that columns (one node) explain."""
    trained = [j for j in judges if j.trained]
    fall = sum(float(j.evidence.gain(j.evidence.plain(j.columns(columns)), ridge).total[0]) for j in trained)
    return fall / sum(float(j.evidence.fold_losses.sum()) for j in trained)


def significant(one: Remainder, rules: Rules = RULES) -> bool:
    """Whether a remainder is certain enough to be reported as structure that nobody explains."""
    fresh = one.unseen >= 0.5 * rules.curve_share
    return one.p_value is not None and one.p_value <= rules.curve_level and one.share >= rules.curve_share and fresh


def signal_of(one: PreparedRecording, now: FittedModel, variable: str, joint: int, factor: str = "") -> Float:
    """Return a variable (N,) along the motion of a recording; its size where a curve in it turns with the motion."""
    motion = one.motion
    if variable == "t":
        return motion.t - motion.t[0]
    if variable == "load":
        return own_torques(now, one)[f"tau_rigid{joint + 1}"]
    stem, index = split_variable(variable)
    signal = {"q": motion.q, "dq": motion.dq, "ddq": motion.ddq}[stem][:, index]
    return np.abs(signal) if factor == "sign" and stem == "dq" else signal


_KEPT: WeakKeyDictionary[Prepared, dict[tuple[str, int, str, int], _Splines | None]] = WeakKeyDictionary()
"""Splines on recordings that are still in use: a search asks for the same ones against every model."""


def _splines(now: FittedModel, variable: str, joint: int, factor: str, knots: int) -> _Splines | None:
    """Return splines over the range of `variable` on the training motion; None where it does not vary or apply."""
    if variable == "load":  # that of the model at its numbers
        return _made(now, variable, joint, factor, knots)
    kept, key = _KEPT.setdefault(now.prepared, {}), (variable, joint, factor, knots)
    if key not in kept:
        kept[key] = _made(now, variable, joint, factor, knots)
    return kept[key]


def _made(now: FittedModel, variable: str, joint: int, factor: str, knots: int) -> _Splines | None:
    if factor and variable.startswith("dq") and variable != f"dq{joint + 1}":
        return None  # the direction is that of the joint itself
    prepared = now.prepared.all
    if variable in ("load", f"ddq{joint + 1}") and not any(p.driven[joint] for p in prepared):
        return None  # where no drive acts, both are made by whatever is missing: it would explain itself
    signals = [signal_of(p, now, variable, joint, factor) for p in prepared]
    train = np.concatenate(signals[: len(now.prepared.train)])
    low, high = np.quantile(train, (0.002, 0.998))
    if not high - low > 1e-9:
        return None
    order = 3
    levels = np.linspace(0.0, 1.0, knots - order + 1)
    # Half even, half where the motion is: what happens near standstill is narrow, and much time is spent there.
    inner = 0.5 * (low + levels * (high - low)) + 0.5 * np.quantile(np.clip(train, low, high), levels)
    inner[[0, -1]] = low, high  # exactly, or rounding leaves samples outside
    positions = np.concatenate([[low] * order, inner, [high] * order])

    def design(x: Float) -> Float:
        return spline_columns(np.clip(x, low, high), positions, order)

    out = []
    for one, signal in zip(prepared, signals, strict=True):
        raw = design(signal)
        if factor:
            raw = raw * (one.motion.sign if factor == "sign" else one.motion.dq)[:, [joint]]
        out.append(Columns((joint,), one.smooth(raw[:, None], (joint,))[:, 0][None, None]))
    grid = np.linspace(low, high, 121)
    return _Splines(tuple(out), grid, design(grid))


def _curve(judge: _Judge, splines: _Splines) -> tuple[Float, Float]:
    """Return the learnt curve and the half-width of its 95 % band from the spread over held-out fits (jackknife)."""
    grams = judge.evidence.plain(judge.columns(splines.columns))
    curves = judge.evidence.leave_one_out(grams, judge.curve_ridge) @ splines.basis.T
    y = splines.basis @ judge.evidence.gain(grams, judge.curve_ridge).coefficients[0]
    count = len(curves)
    spread = np.sqrt((count - 1) / count * np.sum((curves - curves.mean(axis=0)) ** 2, axis=0))
    return y - y.mean(), 1.96 * spread


def suggest(one: Remainder) -> tuple[Suggestion, ...]:
    """Return closed forms for a learnt curve, best first: a bump, a step, a wave, powers."""
    from scipy.optimize import least_squares

    word = _word(one)
    x, y = one.x, one.y - one.y.mean()
    unit, torque = variables(one.joints)[one.variable][1], UNITS["tau"][not one.joints[one.index].turns]
    span, middle = float(np.ptp(x)), float(x.mean())
    peak = float(x[np.argmax(np.abs(y))])
    factor = {"sign": " * sgn(dtheta)", "speed": " * dtheta"}.get(one.factor, "")
    forms = (
        (f"c * exp(-(({word} - m)/w)**2){factor}", lambda p: np.exp(-(((x - p[0]) / p[1]) ** 2)), (peak, 0.15 * span)),
        (f"c * tanh(({word} - m)/w){factor}", lambda p: np.tanh((x - p[0]) / p[1]), (middle, 0.2 * span)),
        (f"c * ({word} - m)**2{factor}", lambda p: (x - p[0]) ** 2 + 0.0 * p[1], (middle, 1.0)),
        (f"c * ({word} - m)**3{factor}", lambda p: (x - p[0]) ** 3 + 0.0 * p[1], (middle, 1.0)),
    )
    out = []
    total = float(np.sum(y**2)) or 1.0
    for text, shape, start in forms:
        low = [x.min() - 0.2 * span, 0.02 * span if "/w" in text else 0.5]
        high = [x.max() + 0.2 * span, 1.5 * span if "/w" in text else 2.0]

        def misfit(p: Float, shape: Any = shape) -> Float:
            g = shape(p) - shape(p).mean()
            c = float(g @ y) / max(float(g @ g), 1e-300)
            return y - c * g

        found = least_squares(misfit, np.clip(start, low, high), bounds=(low, high))
        share = 1.0 - 2.0 * float(found.cost) / total
        values = {"m": (unit, low[0], high[0], float(found.x[0]))}
        if "/w" in text:
            values["w"] = (unit, low[1], high[1], float(found.x[1]))
        power = {"**2": "²", "**3": "³"}
        speed = UNITS["q"][not one.joints[one.index].turns]
        per = f"{torque}·s/{speed}" if one.factor == "speed" else torque
        per += f"/({unit}){power[text.split('- m)')[1][:3]]}" if "/w" not in text else ""
        out.append(Suggestion(text, share, {"c": per}, values))
    return tuple(sorted((s for s in out if s.share > 0.3), key=lambda s: -s.share))


def _word(one: Remainder) -> str:
    if one.variable == "load":
        return "tau_rigid"
    if one.variable == "t":
        return "t"
    kind, index = split_variable(one.variable)
    stem = {"q": "theta", "dq": "dtheta", "ddq": "ddtheta"}[kind]
    word = stem if index == one.index else f"{stem}{index + 1}"
    return f"abs({word})" if one.directed and stem == "dtheta" else word
