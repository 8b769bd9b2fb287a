"""The best fit that some leg could have: positive masses and inertias, friction that brakes, effects of their sign.

Least squares may answer with a leg that cannot exist: a negative viscosity, inertias no positive mass has. Here the
same loss is minimised over the parameters that can. That set is convex, so the answer has a proof again:

    bounds    low ≤ Φ_p ≤ high for every parameter that has them
    masses    [[Φ2, Φ3], [Φ3, Φ1 - Φ2]] ⪰ m 1  and  [[Φ2, Φ3], [Φ3, Φ1 - Φ2 + Φ4]] ⪰ m 1

The two matrix inequalities say Φ3²/Φ2 ≤ Φ1 - Φ2 + min(0, Φ4), which holds exactly for what positive m, l, I give (see
`plausibility`), and make M(θ) positive definite in every posture. The margin m keeps it from being nearly singular.

Of a machine that is not the leg, the base parameters are sums over its links (`Model.mixture`), Φ = A (J, X, m), and
the condition is that of each link (Wensing, Kim, Slotine, IEEE Robotics and Automation Letters 3(1), 2018; here of a
planar body on its axis):

    links     [[J_k, X_k], [X_k, m_k]] ⪰ m 1   for some J, X, m with A (J, X, m) = Φ

The same problem is then solved, and proven, with those numbers of links in the place of Φ.

IPOPT solves it. The proof is ours (`certificate`): every vector v makes vᵀF(Φ)v ≥ 0 a condition linear in Φ, as a bound
is one.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from exoid.ground.errors import EffectError
from exoid.ground.plain import AsJson
from exoid.optimisation.linear.certificate import Certificate, Condition, certify
from exoid.optimisation.linear.factor import factorise
from exoid.optimisation.linear.links import nearest_links, tree_of
from exoid.optimisation.linear.loss import huber
from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.reference import OPTIONS, Reference, column_scale, ended_at, loss_expression
from exoid.optimisation.linear.solve import solve_huber, solve_sse
from exoid.symbolic.mechanics.newton_euler import PARAMETERS
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

MARGIN = 1e-4
"""Least eigenvalue of the two mass matrices, kg·m², or of a link in units of a rod of `MASS` kg."""
MASS, LENGTH, HEAVIEST = 4.0, 0.3, 1e3
"""kg and m of a rod in whose units numbers of links are, and how many times its mass a link has at most: where nothing
shows it, it would grow without end."""
ACTIVE = 1e-5
"""Relative distance to a condition up to which it may have a multiplier."""
PROVEN = 1e-7
"""Relative duality gap up to which it is proven: usually 1e-11; where masses all but vanish, IPOPT ends near 1e-8."""
ANGLES = 33
"""Vectors v tried around the one a matrix inequality is tightest for: they take up what rounding leaves."""


@dataclass(frozen=True, eq=False)
class Inequality:
    """A 2×2 matrix [[a, b], [b, c]] ⪰ MARGIN·1 with a, b, c linear in Φ; each is a row (P,).

    `push` (P,) added to Φ raises both its eigenvalues by one at least.
    """

    name: str
    a: Float
    b: Float
    c: Float
    push: Float

    def matrix(self, linear: Float) -> Float:
        """Return the matrix (2, 2) at `linear`, the margin taken off."""
        a, b, c = (float(row @ linear) for row in (self.a, self.b, self.c))
        return np.array([[a - MARGIN, b], [b, c - MARGIN]])

    def condition(self, v: Float) -> Condition:
        """Return vᵀF(Φ)v ≥ 0, linear in Φ."""
        row = v[0] ** 2 * self.a + 2.0 * v[0] * v[1] * self.b + v[1] ** 2 * self.c
        return row, -MARGIN * float(v @ v)


@dataclass(frozen=True, eq=False)
class Physics:
    """What is possible for a model: `low`, `high` (P,), and matrix inequalities, or those of the links behind it."""

    names: tuple[str, ...]
    low: Float
    high: Float
    inequalities: tuple[Inequality, ...]
    lift: Lift | None = None

    @property
    def machine(self) -> str:
        """What has to be possible, in a word."""
        return "leg" if self.lift is None else "machine"

    def conditions(self, linear: Float) -> list[Condition]:
        """Return every linear condition on Φ that is tight near `linear`."""
        out: list[Condition] = []
        size = np.maximum(np.abs(linear), 1e-3 * np.max(np.abs(linear), initial=1e-9))
        for p in range(linear.size):
            unit = np.zeros(linear.size)
            unit[p] = 1.0
            if linear[p] - self.low[p] <= ACTIVE * size[p]:
                out.append((unit, -float(self.low[p])))
            if self.high[p] - linear[p] <= ACTIVE * size[p]:
                out.append((-unit, float(self.high[p])))
        for one in self.inequalities:
            matrix = one.matrix(linear)
            value, vectors = np.linalg.eigh(matrix)
            tight = ACTIVE * max(abs(value[1]), MARGIN)
            turn = np.arctan2(vectors[1, 0], vectors[0, 0])
            steps = np.concatenate([[0.0], 10.0 ** np.linspace(-9.0, 0.0, ANGLES // 2)])
            # All round as well: a matrix that is all but zero is tight for every v.
            every = np.linspace(0.0, np.pi, ANGLES, endpoint=False)
            for angle in np.unique(np.concatenate([turn + steps, turn - steps, every])):
                v = np.array([np.cos(angle), np.sin(angle)])
                if v @ matrix @ v <= tight:
                    out.append(one.condition(v))
        return out

    def broken(self, linear: Float) -> tuple[str, ...]:
        """Return the names of what `linear` (P,) violates."""
        out = [n for n, x, a, b in zip(self.names, linear, self.low, self.high, strict=True) if not a <= x <= b]
        out += [i.name for i in self.inequalities if np.linalg.eigvalsh(i.matrix(linear))[0] < 0.0]
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


@dataclass(frozen=True, eq=False)
class Lift:
    """Parameters (P,) as `matrix` (P, Q) times numbers of links and all others, of which `inner` says what is possible.

    `unit` (3 J,) are those of the links' numbers (J, X, m, link after link).
    """

    model: Model
    matrix: Float
    unit: Float
    inner: Physics
    _known: dict[bytes, Float] = field(default_factory=dict)

    def data(self, data: LinearData) -> LinearData:
        """Return the same data with columns for the numbers of links."""
        return replace(
            data,
            columns=data.columns @ self.matrix,
            names=self.inner.names,
            units=("",) * len(self.inner.names),
            factoriser=factorise,
        )

    def start(self, linear: Float) -> Float:
        """Return numbers (Q,) to begin from: rods, and all others of `linear` (P,)."""
        rods = np.tile([1.0, 0.5 * np.sqrt(3.0), 1.0], len(self.unit) // 3)
        return np.concatenate([rods, linear[len(self.model.inertial) :]])

    def lowered(self, numbers: Float) -> Float:
        """Return the parameters (P,) of `numbers` (Q,), and remember whose they are."""
        linear = np.asarray(self.matrix @ numbers)
        self._known[linear.tobytes()] = numbers
        return linear

    def raised(self, linear: Float) -> Float | None:
        """Return numbers (Q,) that have these parameters (P,), None where no possible ones do."""
        if linear.tobytes() not in self._known:
            count = len(self.model.inertial)
            links = nearest_links(self.model, np.asarray(linear[:count]))
            if links is None:
                return None
            own = np.array([(one.inertia, one.along, one.mass) for one in links]).ravel() / self.unit
            numbers = np.concatenate([own, linear[count:]])
            if self.inner.broken(numbers):
                return None
            self._known[linear.tobytes()] = numbers
        return self._known[linear.tobytes()]


def physics(model: Model) -> Physics:
    """Return what is possible for `model`: the bounds of its parameters, and of its masses where it has Φ1 to Φ4;
    EffectError for a spatial machine.
    """
    names = tuple(p.name for p in model.parameters)
    low = np.array([-np.inf if p.min is None else p.min for p in model.parameters], dtype=float)
    high = np.array([np.inf if p.max is None else p.max for p in model.parameters], dtype=float)
    if model.spatial:
        raise EffectError(
            "a fit among possible machines alone is made of planar ones, and this one is spatial",
            where=model.name,
            remedy="leave physical out; what is impossible about the numbers is said of every fit",
        )
    if model.chain:
        return Physics(names, low, high, (), _lift(model, names, low, high))
    if any(f"Phi{k}" not in names for k in range(1, 5)):
        return Physics(names, low, high, ())
    one, two, three, four = (np.array([float(n == f"Phi{k}") for n in names]) for k in range(1, 5))
    low[names.index("Phi3")] = max(low[names.index("Phi3")], 0.0)
    heavier = two + 2.0 * one
    return Physics(
        names,
        low,
        high,
        (
            Inequality("Phi1 to Phi3: no positive masses", two, three, one - two, heavier),
            Inequality("Phi1 to Phi4: no positive masses", two, three, one - two + four, heavier),
        ),
    )


def _lift(model: Model, names: tuple[str, ...], low: Float, high: Float) -> Lift:
    """Return the parameters of a machine as numbers of its links, in units of rods of `MASS` kg."""
    joints, count = tree_of(model), len(model.inertial)
    rods = [(joint.length or LENGTH) / np.sqrt(3.0) for joint in joints]
    unit = np.array([(MASS * a**2, MASS * a, MASS) for a in rods]).ravel()
    others = len(names) - count
    matrix = np.zeros((len(names), unit.size + others))
    matrix[:count, : unit.size] = model.mixture.reshape(count, -1) * unit
    matrix[count:, unit.size :] = np.eye(others)
    called = tuple(f"{joint.name}.{kind}" for joint in joints for kind in PARAMETERS)
    eye = np.eye(matrix.shape[1])
    inequalities = []
    for k, joint in enumerate(joints):
        a, b, c = (eye[3 * k + PARAMETERS.index(kind)] for kind in ("J", "X", "m"))
        inequalities.append(Inequality(f"link of {joint.name}: no positive mass and inertia", a, b, c, a + c))
    heaviest = np.where([name.endswith(".m") for name in called], HEAVIEST, np.inf)
    inner = Physics(
        (*called, *names[count:]),
        np.concatenate([np.full(unit.size, -np.inf), low[count:]]),
        np.concatenate([heaviest, high[count:]]),
        tuple(inequalities),
    )
    return Lift(model, matrix, unit, inner)


@dataclass(frozen=True, eq=False)
class Held(AsJson):
    """What asking for a possible leg changed: the parameters without it, {name: value}, what they violated, and its
    price.

    `cost` is the relative rise of the loss; 0 where the free optimum was possible already.
    """

    free: Mapping[str, float]
    broken: tuple[str, ...]
    cost: float

    def _json(self) -> dict[str, Any]:
        return {"violated": self.broken, "cost": self.cost, "parameters_without": self.free}


def solve_physical(data: LinearData, delta: Float, possible: Physics, start: Float | None = None) -> Float:
    """Return the possible parameters (P,) of least loss; those of the free optimum where it is possible."""
    free = solve_sse(data) if np.isinf(delta).all() else solve_huber(data, delta, start)
    return free if not possible.broken(free) else physical_reference(data, delta, possible, free).x


def physical_reference(data: LinearData, delta: Float, possible: Physics, start: Float) -> Reference:
    """Solve the problem with its conditions by IPOPT, from `start` (P,); infinite thresholds give SSE."""
    import casadi as ca

    if (lift := possible.lift) is not None:
        raised = physical_reference(lift.data(data), delta, lift.inner, lift.start(np.asarray(start, dtype=float)))
        return replace(raised, x=lift.lowered(raised.x))
    began = time.perf_counter()
    scale = column_scale(data)
    x = ca.MX.sym("x", scale.size)
    conditions, lower = [], []
    for one in possible.inequalities:
        a, b, c = (ca.DM(row * scale).T @ x for row in (one.a, one.b, one.c))
        unit = max(abs(float(one.a @ start)), abs(float(one.c @ start)), 10.0 * MARGIN)
        conditions += [(a - MARGIN) / unit, (c - MARGIN) / unit, ((a - MARGIN) * (c - MARGIN) - b * b) / unit**2]
        lower += [0.0, 0.0, 0.0]
    problem: Any = {"x": x, "f": loss_expression(data, delta, x, scale), "g": ca.vertcat(*conditions)}
    options = {**OPTIONS, "ipopt.max_iter": 500, "ipopt.bound_relax_factor": 0.0, "ipopt.tol": 1e-13}
    solver = ca.nlpsol("physical", "ipopt", problem, options)
    first = possible.inside(np.asarray(start, dtype=float))
    answer = solver(
        x0=first / scale, lbx=possible.low / scale, ubx=possible.high / scale, lbg=lower, ubg=[np.inf] * len(lower)
    )
    found = np.asarray(answer["x"]).reshape(-1) * scale
    for bound in (possible.low, possible.high):  # an interior point ends a hair inside
        found = np.where(np.abs(found - bound) <= 1e-10 * scale, bound, found)
    found = possible.inside(found)
    return ended_at(found, solver, huber(data.residual(found), delta), began)


def certify_physical(
    data: LinearData, linear: Float, delta: Float, possible: Physics, *, scope: str = ""
) -> Certificate:
    """Return the Certificate of a claimed optimum `linear` (P,) among the possible ones; `delta` (J,), ∞ means SSE.

    A claim outside the possible set gets an infinite gap.
    """
    if (lift := possible.lift) is not None:
        numbers = lift.raised(linear)
        if numbers is not None:
            data, linear, possible = lift.data(data), numbers, lift.inner
    return certify(
        data, linear, delta, possible.conditions(linear),
        tolerance=PROVEN, scope=scope or "all possible parameters", possible=not possible.broken(linear),
    )  # fmt: skip
