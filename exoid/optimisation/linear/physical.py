"""The best fit that some machine could have: positive masses and inertias, friction that brakes, effects of their sign.

Least squares may answer with a machine that cannot exist: a negative viscosity, inertias no positive mass has. Here the
same loss is minimised over the parameters that can. That set is convex, so the answer has a proof again:

    bounds    low ≤ Φ_p ≤ high for every parameter that has them
    masses    [[Φ2, Φ3], [Φ3, Φ1 - Φ2]] ⪰ m 1  and  [[Φ2, Φ3], [Φ3, Φ1 - Φ2 + Φ4]] ⪰ m 1

The two matrix inequalities say Φ3²/Φ2 ≤ Φ1 - Φ2 + min(0, Φ4), which holds exactly for what positive m, l, I give (see
`plausibility`), and make M(θ) positive definite in every posture. The margin m keeps it from being nearly singular.

Of a machine that is not the leg, the base parameters are sums over its links (`Model.mixture`), Φ = A x, and the
condition is that of each link's pseudo-inertia (Wensing, Kim, Slotine, IEEE Robotics and Automation Letters 3(1),
2018), of a planar body on its axis, or of one in space:

    links     [[J, X], [X, m]]  or  [[½ tr(I) 1 - I, h], [hᵀ, m]]  ⪰ m 1   for some x with A x = Φ

The same problem is then solved with those numbers of links in the place of Φ (`interior.py`). The proof is ours
(`certificate`). Of the leg, every vector v makes vᵀF(Φ)v ≥ 0 a condition linear in Φ, as a bound is one. Of links, a
half-space holds all possible machines: its normal is the slope of the loss at the optimum claimed, and where it ends is
told by the eigenvalues of the normal in every link (`Inequality.least`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from exoid.ground.plain import AsJson
from exoid.ground.ties import index_of_least
from exoid.optimisation.linear.bodies import gyration
from exoid.optimisation.linear.certificate import Certificate, Condition, certify
from exoid.optimisation.linear.inequality import Inequality
from exoid.optimisation.linear.interior import Region, least_loss
from exoid.optimisation.linear.links import EXACT, nearest_matrices, tree_of
from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.reference import column_scale
from exoid.optimisation.linear.solve import solve_huber, solve_sse
from exoid.symbolic.mechanics.newton_euler import PARAMETERS
from exoid.symbolic.mechanics.spatial import KINDS
from exoid.symbolic.mechanics.spatial_energy import pseudo_inertia
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion

MARGIN = 1e-4
"""Least eigenvalue of the two mass matrices, kg·m², or of a link in units of a rod of `MASS` kg."""
THIN = 1e-5
"""The same of a link in space, in units of a usual body of `MASS` kg: where joints are 0.3 m apart, what a rod of
0.1 kg and 5 mm radius has across its axis."""
MASS, LENGTH, LARGEST = 4.0, 0.3, 1e3
"""kg and m of a rod in whose units numbers of links are, and how many times its trace a link has at most: where nothing
shows them, mass and size would grow without end."""
STATES = 64
"""Random postures and rates over which a kinetic energy is averaged."""
PUSH = {"J": 1.0, "m": 1.0, "XX": 2.0, "YY": 2.0, "ZZ": 2.0, "M": 1.0}
"""What raises all eigenvalues of a link's pseudo-inertia by one."""
ACTIVE = 1e-5
"""Relative distance to a condition up to which it may have a multiplier."""
PROVEN = 1e-7
"""Relative duality gap up to which it is proven: usually 1e-9; where masses all but vanish, it is near 1e-8."""
INNER = 1e-3
"""Least eigenvalue of a matrix, of its largest, from which a search inside begins."""
SNAP = 1e-9
"""Distance to a bound, of a parameter's own scale, at which a number is at it."""
ANGLES = 33
"""Vectors v tried around the one a matrix inequality is tightest for: they take up what rounding leaves."""


@dataclass(frozen=True, eq=False)
class Physics:
    """Physical limits of a model: `low`, `high` (P,), and matrix inequalities, or those of the links behind it."""

    names: tuple[str, ...]
    low: Float
    high: Float
    inequalities: tuple[Inequality, ...]
    lift: Lift | None = None

    @property
    def machine(self) -> str:
        """Word for the machine that has to be possible."""
        return "leg" if self.lift is None else "machine"

    def conditions(self, linear: Float, slope: Float) -> list[Condition]:
        """Return every linear condition on Φ that is tight near `linear`, where the loss has this `slope` (P,); the
        inequalities in Φ itself, the leg's, are of 2×2 matrices.
        """
        out: list[Condition] = []
        size = np.maximum(np.abs(linear), 1e-3 * np.max(np.abs(linear), initial=1e-9))
        for p in range(linear.size):
            unit = np.zeros(linear.size)
            unit[p] = 1.0
            if linear[p] - self.low[p] <= ACTIVE * size[p]:
                out.append((unit, -float(self.low[p])))
            if self.high[p] - linear[p] <= ACTIVE * size[p]:
                out.append((-unit, float(self.high[p])))
        for inequality in self.inequalities:
            matrix = inequality.matrix(linear)
            value, vectors = np.linalg.eigh(matrix)
            tight = ACTIVE * max(abs(value[1]), MARGIN)
            turn = np.arctan2(vectors[1, 0], vectors[0, 0])
            steps = np.concatenate([[0.0], 10.0 ** np.linspace(-9.0, 0.0, ANGLES // 2)])
            # All round as well: a matrix that is all but zero is tight for every v.
            every = np.linspace(0.0, np.pi, ANGLES, endpoint=False)
            for angle in np.unique(np.concatenate([turn + steps, turn - steps, every])):
                v = np.array([np.cos(angle), np.sin(angle)])
                if v @ matrix @ v <= tight:
                    out.append(inequality.condition(v))
        return out if self.lift is None else [*out, self.lift.half_space(slope, linear)]

    def broken(self, linear: Float) -> tuple[str, ...]:
        """Return the names of what `linear` (P,) violates."""
        out = [n for n, x, a, b in zip(self.names, linear, self.low, self.high, strict=True) if not a <= x <= b]
        out += [inequality.name for inequality in self.inequalities if not inequality.holds(linear)]
        if self.lift is not None and self.lift.raised(linear) is None:
            out.append("inertial parameters: no links of positive mass have them")
        return tuple(out)

    def inside(self, linear: Float) -> Float:
        """Return `linear` put back inside: bounds exactly, matrices by adding as little inertia as rounding needs."""
        out = np.clip(linear, self.low, self.high)
        for _ in range(8):
            least = [float(np.linalg.eigvalsh(i.matrix(out))[0]) for i in self.inequalities]
            if min(least, default=0.0) >= 0.0:
                break
            worst = int(np.argmin(least))
            out = out + (1.5 * abs(least[worst]) + 1e-16) * self.inequalities[worst].push
        return out

    def within(self, linear: Float, scale: Float) -> Float:
        """Return `linear` moved strictly inside, a tenth of `scale` (P,) from bounds where there is so much room."""
        room = np.minimum(0.1 * np.where(np.isfinite(scale), scale, 1.0), 0.25 * (self.high - self.low))
        out = np.clip(linear, self.low + room, self.high - room)
        for _ in range(60):
            short = []
            for inequality in self.inequalities:
                values = np.linalg.eigvalsh(inequality.matrix(out))
                short.append(values[0] - INNER * max(values[-1], inequality.margin))
            if min(short, default=0.0) >= 0.0:
                break
            worst = int(np.argmin(short))
            out = out + 2.0 * abs(short[worst]) * self.inequalities[worst].push
        return out


@dataclass(frozen=True, eq=False)
class Lift:
    """Parameters (P,) as `matrix` (P, Q) times numbers of links and all others, of which `inner` says what is possible.

    `usual` (L,) are the links' numbers, link after link, of links that nobody knows better, in units in which they are
    near one; `inertial` is how many of the parameters are made of them, and `energy` (P,) twice the kinetic energy that
    one of each has, on average over postures and rates.
    """

    matrix: Float
    inertial: int
    usual: Float
    energy: Float
    inner: Physics
    _known: dict[bytes, Float] = field(default_factory=dict)

    def start(self, linear: Float) -> Float:
        """Return numbers (Q,) to begin from: usual links, and all others of `linear` (P,)."""
        return np.concatenate([self.usual, linear[self.inertial :]])

    def lowered(self, numbers: Float) -> Float:
        """Return the parameters (P,) of `numbers` (Q,), and remember whose they are."""
        linear = np.asarray(self.matrix @ numbers)
        self._known[linear.tobytes()] = numbers
        return linear

    def raised(self, linear: Float) -> Float | None:
        """Return numbers (Q,) that have these parameters (P,), None where no possible ones do."""
        if linear.tobytes() not in self._known:
            numbers = self._nearest(np.asarray(linear, dtype=float))
            if numbers is None or self.inner.broken(numbers):
                return None
            self._known[linear.tobytes()] = numbers
        return self._known[linear.tobytes()]

    def _nearest(self, linear: Float) -> Float | None:
        """Return numbers (Q,) with these parameters (P,), their links nearest to the usual ones; None for none."""
        rows, middle = self.matrix[: self.inertial], self.start(linear)
        size = np.maximum(np.abs(rows).max(axis=1), np.abs(linear[: self.inertial]))
        maps = [inequality.entries.reshape(-1, middle.size) for inequality in self.inner.inequalities]
        back = [np.linalg.pinv(item) for item in maps]
        shape = self.inner.inequalities[0].entries.shape[:2]
        weights = np.array([[(inverse.T @ row).reshape(shape) for inverse in back] for row in rows / size[:, None]])
        before = np.array([entry.matrix(middle) for entry in self.inner.inequalities])
        margins = np.array([element.margin * np.eye(element.size) for element in self.inner.inequalities])
        values = linear[: self.inertial] / size - np.einsum("pkij,kij->p", weights, margins)
        found = nearest_matrices(before, weights, values)
        if found is None:
            return None
        blocks = zip(back, found.real + margins, strict=True)
        links = np.sum([inverse @ block.ravel() for inverse, block in blocks], axis=0)
        links = links - np.linalg.pinv(rows) @ (rows @ links - linear[: self.inertial])
        wrong = np.abs(rows @ links - linear[: self.inertial])
        if np.any(wrong > EXACT * np.maximum(np.abs(rows) @ np.abs(links), np.abs(linear[: self.inertial]))):
            return None
        return np.concatenate([links[: self.usual.size], linear[self.inertial :]])

    def half_space(self, slope: Float, linear: Float) -> Condition:
        """Return a half-space, in parameters (P,), that holds all possible links, with a normal next to `slope` (P,),
        as tight at `linear` (P,) as can be.

        What rounding makes negative in a link's normal would count as often as a link may be large, unless a little of
        the kinetic energy, which is positive for all links, is added.
        """
        given = np.concatenate([slope[: self.inertial], np.zeros(len(slope) - self.inertial)])
        size = float(np.abs(given @ self.matrix).max()) / float(np.abs(self.energy @ self.matrix).max())
        tried = [given + share * size * self.energy for share in (0.0, *np.logspace(-14.0, -4.0, 41))]
        ends = [self._least(normal) for normal in tried]
        best = index_of_least(np.array([normal @ linear - end for normal, end in zip(tried, ends, strict=True)]))
        return tried[best], -ends[best]

    def _least(self, normal: Float) -> float:
        """Return the least that normal · Φ can be for possible links."""
        pulled = normal @ self.matrix
        parts = [np.where(np.any(item.entries, axis=(0, 1)), pulled, 0.0) for item in self.inner.inequalities]
        return sum(inequality.least(part) for inequality, part in zip(self.inner.inequalities, parts, strict=True))


def physics(model: Model) -> Physics:
    """Physical limits of `model`: the bounds of its parameters, and of its masses where it has Φ1 to Φ4."""
    names = tuple(p.name for p in model.parameters)
    low = np.array([-np.inf if p.min is None else p.min for p in model.parameters], dtype=float)
    high = np.array([np.inf if p.max is None else p.max for p in model.parameters], dtype=float)
    if model.chain:
        return Physics(names, low, high, (), _lift(model, names, low, high))
    if any(f"Phi{k}" not in names for k in range(1, 5)):
        return Physics(names, low, high, ())
    phi1, phi2, phi3, phi4 = (np.array([float(n == f"Phi{k}") for n in names]) for k in range(1, 5))
    low[names.index("Phi3")] = max(low[names.index("Phi3")], 0.0)
    heavier = phi2 + 2.0 * phi1
    masses = (
        Inequality("Phi1 to Phi3: no positive masses", np.array([[phi2, phi3], [phi3, phi1 - phi2]]), heavier, MARGIN),
        Inequality(
            "Phi1 to Phi4: no positive masses", np.array([[phi2, phi3], [phi3, phi1 - phi2 + phi4]]), heavier, MARGIN
        ),
    )
    return Physics(names, low, high, masses)


def _lift(model: Model, names: tuple[str, ...], low: Float, high: Float) -> Lift:
    """Return the parameters of a machine as numbers of its links, in units of usual ones of `MASS` kg."""
    kinds, margin = (KINDS, THIN) if model.spatial else (PARAMETERS, MARGIN)
    joints, count = tree_of(model), len(model.inertial)
    if model.spatial:
        long, power = [gyration(model)] * len(joints), [2] * 6 + [1] * 3 + [0]
        usual = np.tile([PUSH.get(kind, 0.0) for kind in kinds], len(joints))
    else:
        long, power = [(joint.length or LENGTH) / np.sqrt(3.0) for joint in joints], [2, 1, 0]
        usual = np.tile([1.0, 0.5 * np.sqrt(3.0), 1.0], len(joints))
    unit = np.array([MASS * a**n for a in long for n in power])
    others = len(names) - count
    matrix = np.zeros((len(names), unit.size + others))
    matrix[:count, : unit.size] = model.mixture.reshape(count, -1) * unit
    matrix[count:, unit.size :] = np.eye(others)
    eye = np.eye(matrix.shape[1])
    inequalities = []
    for k, joint in enumerate(joints):
        own = dict(zip(kinds, eye[k * len(kinds) :], strict=False))
        entries = np.array(pseudo_inertia(own) if model.spatial else [[own["J"], own["X"]], [own["X"], own["m"]]])
        push = sum((own[kind] * n for kind, n in PUSH.items() if kind in own), 0.0 * eye[0])
        inequalities.append(
            Inequality(f"link of {joint.name}: no positive mass and inertia", entries, push, margin, LARGEST)
        )
    inner = Physics(
        (*(f"{joint.name}.{kind}" for joint in joints for kind in kinds), *names[count:]),
        np.concatenate([np.full(unit.size, -np.inf), low[count:]]),
        np.concatenate([np.full(unit.size, np.inf), high[count:]]),
        tuple(inequalities),
    )
    return Lift(matrix, count, usual, _energy(model), inner)


def _energy(model: Model) -> Float:
    """Return twice the kinetic energy per parameter (P,), on average over random postures and rates."""
    count, bare = len(model.joints), model.unpushed.base()
    base = np.zeros((STATES, len(model.base_state))) if model.moving_base else None
    q, rate = np.random.default_rng(0).uniform(-np.pi, np.pi, (2, STATES, count))
    still = 0.0 * q
    times = 0.01 * np.arange(STATES, dtype=float)
    found, rest = (bare.columns(Motion(times, q, still, way, still, base=base)) for way in (rate, still))
    inertial = np.einsum("kj,jkp->p", rate, found - rest)[: len(model.inertial)] / STATES
    return np.concatenate([inertial, np.zeros(len(model.parameters) - len(inertial))])


@dataclass(frozen=True, eq=False)
class Held(AsJson):
    """Changes from asking for a possible `machine`: the parameters without it, {name: value}, what they violated, and
    its price.

    `cost` is the relative rise of the loss; 0 where the free optimum was possible already.
    """

    free: Mapping[str, float]
    broken: tuple[str, ...]
    cost: float
    machine: str = "leg"

    def _json(self) -> dict[str, Any]:
        return {"violated": self.broken, "cost": self.cost, "parameters_without": self.free}


def solve_physical(data: LinearData, delta: Float, possible: Physics, start: Float | None = None) -> Float:
    """Return the possible parameters (P,) of least loss; those of the free optimum where it is possible."""
    free = solve_sse(data) if np.isinf(delta).all() else solve_huber(data, delta, start)
    return free if not possible.broken(free) else _least(data, delta, possible, free)


def _least(data: LinearData, delta: Float, possible: Physics, near: Float) -> Float:
    """Return the possible parameters (P,) of least loss, from the middle of what is possible `near` some (P,)."""
    lift, scale = possible.lift, column_scale(data)
    if lift is None:
        inner, lead, begin, towards = possible, np.eye(near.size), possible.inside(near), np.zeros(near.size)
    else:
        inner, lead, begin = lift.inner, lift.matrix, lift.start(near)
        scale = np.concatenate([np.full(lift.usual.size, np.inf), scale[lift.inertial :]])
        towards = sum(
            np.einsum("ij,ijq->q", np.linalg.inv(item.matrix(begin)), item.entries) for item in inner.inequalities
        )
    region = Region(inner.low, inner.high, inner.inequalities, inner.within(begin, scale), towards, scale**-2.0)
    found = least_loss(data, delta, lead, region)
    for bound in (inner.low, inner.high):  # what ends a hair inside a bound is at it
        found = np.where(np.isfinite(bound) & (np.abs(found - bound) <= SNAP * scale), bound, found)
    return found if lift is None else lift.lowered(found)


def certify_physical(
    data: LinearData, linear: Float, delta: Float, possible: Physics, *, scope: str = ""
) -> Certificate:
    """Return the Certificate of a claimed optimum `linear` (P,) among the possible ones; `delta` (J,), ∞ means SSE.

    A claim outside the possible set gets an infinite gap.
    """
    limit = np.asarray(delta, dtype=float)[:, None]
    score = np.clip(data.residual(linear), -limit, limit)
    conditions = possible.conditions(linear, -2.0 * np.einsum("jkp,jk->p", data.columns, score))
    inside, said = not possible.broken(linear), scope or "all possible parameters"
    # Where no condition presses, what rounding leaves is no multiplier: the better of two proofs counts.
    held, free = (
        certify(data, linear, delta, given, tolerance=PROVEN, scope=said, possible=inside)
        for given in (conditions, ())
    )
    return held if held.gap <= free.gap else free
