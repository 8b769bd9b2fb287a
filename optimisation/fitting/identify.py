"""From recordings to a fitted model: SSE, thresholds δ from it, Huber; proof, intervals, plausibility.

The linear parameters are solved exactly (`linear.py`) and proven (`certificate.py`). NFO and IPOPT solve
the very same problems and are reported with their distance to the proven optimum; they are witnesses, not
the judge.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, cast

import numpy as np

from ground.errors import ExoidError, ExpressionError, NotEnoughDataError
from measurement.finding import Finding
from measurement.recording import Recording
from optimisation.fitting.assemble import Assembly, FilteredRecording, FittableModel, Settled, settle
from optimisation.fitting.fit import Fit, FitStage
from optimisation.fitting.local_shape import descend, own_shapes
from optimisation.fitting.plausibility import check_plausibility
from optimisation.fitting.shapes import GRID, STARTS, ShapeMethod, search_shape, to_unit
from optimisation.linear.certificate import certify
from optimisation.linear.fitness import population_fitness
from optimisation.linear.loss import huber
from optimisation.linear.physical import Held, Physics, certify_physical, physical_reference, physics, solve_physical
from optimisation.linear.problem import LinearData, huber_problem, sse_problem
from optimisation.linear.reference import Reference, solve_reference
from optimisation.linear.solve import delta_rule, solve_huber, solve_sse
from optimisation.linear.uncertainty import Covariance, covariance
from optimisation.optimiser import Optimiser, OptimiserRun, minimise
from optimisation.optimisers import optimisers as optimiser_kinds
from optimisation.optimisers.nfo import NFO
from optimisation.preparation.prepare import prepare
from symbolic.motion import Float
from symbolic.quantity import Estimate

if TYPE_CHECKING:
    from symbolic.model import Model


@dataclass(frozen=True)
class Search:
    """An optimiser and the coordinates it searches in."""

    optimiser: Optimiser
    whitened: bool = False


SEARCHES: Mapping[str, Search] = MappingProxyType(
    {"nfo": Search(NFO()), "nfo_whitened": Search(NFO(alpha=1.0), whitened=True)}
)
"""What `identify` runs unless told otherwise: NFO as printed, and NFO in whitened coordinates."""

Progress = Callable[[str], None]


def identify(
    model: FittableModel,
    data: Sequence[FilteredRecording] | Sequence[Recording],
    *,
    optimisers: Mapping[str, Search] | tuple[()] = SEARCHES,
    shape: Float | None = None,
    start: Float | None = None,
    delta: Float | None = None,
    seed: int = 0,
    physical: bool = False,
    shape_search: str = "multistart",
    progress: Progress | None = None,
) -> Fit:
    """Fit `model` to recordings, prepared or as they were read (they are then prepared), and return the Fit.

    `optimisers=()` is the light mode: no NFO and no IPOPT, the exact solution only. `shape` (S,) fixes the
    shape parameters instead of searching them, `start` ((S,) or (R, S)) searches them only from there,
    `delta` (J,) fixes the thresholds instead of the 14 % rule. `physical` looks for the best parameters that some leg
    could have (`optimisation.linear.physical`), by IPOPT with our certificate; NFO, which has no such conditions, is
    then left out. `Fit.held` says what that changed. `shape_search` is how shape parameters are found before the local
    searches: "multistart" (on a grid) or the name of an optimiser such as "nfo"; `Fit.agreeing` says how many of them
    ended in the same place.
    Refuses data that cannot determine as many parameters as the model has.
    """
    began = time.perf_counter()
    if not data:
        raise NotEnoughDataError("there is no recording to fit", remedy="give at least one recording")
    data = _prepared(model, data)
    say = progress or _silent
    searches = {} if physical else dict(optimisers)
    possible = physics(model) if physical else None
    method = _shape_method(shape_search, bool(optimisers), seed)
    infinite = np.full(2, np.inf)

    assembly = Assembly(model, data)
    scope = _scope(model, shape is not None)

    say("least squares")
    first_shape, first, leaders, agreeing = _solve_shape(
        assembly, infinite, shape, start, possible=possible, method=replace(method, refined=STARTS)
    )
    first.data.require_enough()
    sse = _stage("sse", first, _middle(first_shape), infinite, first.linear, searches, seed, say, scope, possible)
    limits = delta_rule(first.data.residual(first.linear), use=first.data.use) if delta is None else np.asarray(delta)

    say("Huber")
    if model.needs_reference or (model.shapes and shape is None):
        best_shape, best, _, agreeing = _solve_shape(assembly, limits, shape, leaders, first.linear, possible, method)
    else:  # the columns stay what they were
        best_shape = first_shape
        best = replace(first, linear=_solution(first.data, limits, possible, first.linear))
    # δ and the box of the Huber search come from least squares on the columns of the shape found last.
    centre = first.linear if best.data is first.data else solve_sse(best.data)
    stage = _stage("huber", best, _middle(best_shape), limits, centre, searches, seed, say, scope, possible)
    held = None if possible is None else _held(best, limits, possible)

    spread = _spread(assembly, best, best_shape, limits)
    estimates = _estimates(model, best.linear, best_shape, spread, possible)
    middle = _middle(best_shape)
    cautions = (
        *_numerical(model, best, middle, bool(model.shapes) and shape is None),
        *_unproven(stage),
        *_price(model, held),
        *check_plausibility(model, best.linear, estimates, middle),
    )
    return Fit(
        model=model,
        estimates=estimates,
        linear=best.linear,
        shape=middle,
        shapes=np.broadcast_to(best_shape, (len(data), middle.size)),
        delta=limits,
        rms=best.data.rms(best.linear),
        loss=stage.loss,
        runs=stage.runs,
        reference=stage.reference,
        certificate=stage.certificate,
        plausibility=cautions,
        sse=sse,
        data=best.data,
        covariance=spread.matrix,
        best_known=bool(model.shapes),
        lag=spread.lag,
        seconds=time.perf_counter() - began,
        recordings=tuple(one.name for one in data),
        held=held,
        agreeing=agreeing,
    )


MULTISTART = "multistart"
FULL_STARTS, FULL_APART = 6, 0.08
"""Starts of the local searches, and how far apart they begin, when more is asked for than the light mode."""


def _shape_method(name: str, full: bool, seed: int) -> ShapeMethod:
    """Return how shapes are searched; refuses a name that is neither "multistart" nor an optimiser."""
    known = optimiser_kinds()
    if name != MULTISTART and name not in known:
        raise ExoidError(
            f"there is no way to search shapes called {name!r}",
            where="shape_search",
            remedy=f"use {MULTISTART}, {', '.join(known)}",
        )
    if name == MULTISTART and not full:
        return GRID
    optimiser = None if name == MULTISTART else known[name]()
    return ShapeMethod(optimiser, FULL_STARTS, None, FULL_APART, seed)


def _solution(data: LinearData, delta: Float, possible: Physics | None, start: Float | None = None) -> Float:
    """Return the exact linear parameters (P,), among the possible ones where these are given."""
    if possible is not None:
        return solve_physical(data, delta, possible, start)
    return solve_sse(data) if np.isinf(delta).all() else solve_huber(data, delta, start)


def _held(found: Settled, delta: Float, possible: Physics) -> Held:
    free = solve_huber(found.data, delta, found.linear)
    least = huber(found.data.residual(free), delta)
    cost = huber(found.data.residual(found.linear), delta) / max(least, np.finfo(float).tiny) - 1.0
    return Held(free, possible.broken(free), max(cost, 0.0))


def _price(model: FittableModel, held: Held | None) -> list[Finding]:
    """Return in words what asking for a possible leg has changed."""
    if held is None or not held.broken:
        return []
    value = {p.name: f" ({v:.4g} {p.unit})" for p, v in zip(model.parameters, held.free, strict=True)}
    broken = ", ".join(name + value.get(name, "") for name in held.broken)
    what = f"without the demand for a possible leg the fit would violate: {broken}; the loss is {held.cost:.2%} higher"
    remedy = "an effect that is missing or a wrong sign hides in it: run `exoid diagnose`"
    return [Finding("possible", "warning", what, "physical", held.cost, 0.0, remedy)]


def _prepared(
    model: FittableModel, data: Sequence[FilteredRecording] | Sequence[Recording]
) -> Sequence[FilteredRecording]:
    """Return prepared recordings; those just read are prepared for `model`, with the cut-off chosen."""
    raw = [one for one in data if isinstance(one, Recording)]
    if not raw:
        return cast("Sequence[FilteredRecording]", data)
    return prepare(cast("Model", model), raw).train


def _scope(model: FittableModel, given: bool) -> str:
    """Return for what a certificate of this fit holds: a loss is convex in the linear parameters only."""
    scope = "all parameters"
    if model.shapes:
        scope = f"the linear parameters at the {'given' if given else 'best-known'} shape"
    return scope + (", the model's own torque held" if model.needs_reference else "")


def _middle(shape: Float) -> Float:
    """Return one row (S,) that stands for shape values (S,) or (R, S)."""
    return shape if shape.ndim == 1 else np.asarray(np.median(shape, axis=0))


def _silent(text: str) -> None:
    """Say nothing."""


def _solve_shape(
    assembly: Assembly,
    delta: Float,
    fixed: Float | None,
    starts: Sequence[Float] | Float | None,
    reference: Float | None = None,
    possible: Physics | None = None,
    method: ShapeMethod = GRID,
) -> tuple[Float, Settled, Sequence[Float] | Float, tuple[int, int] | None]:
    """Return the best shape values ((S,), or (R, S) where recordings have their own), the linear solution
    there, where a next stage may start, and how many of how many starts agree.
    """

    def solve(data: LinearData) -> Float:
        return _solution(data, delta, possible)

    def solved(shape: Float) -> Settled:
        return settle(assembly, shape, solve, reference)

    def loss(shape: Float) -> float:
        try:
            found = solved(shape)
        except ExpressionError:  # the torque is not finite there: no place to look for the optimum
            return float("inf")
        return huber(found.data.residual(found.linear), delta)

    shapes = [s.shape for s in assembly.model.shapes]
    if not shapes or fixed is not None:
        values = np.zeros(0) if not shapes else np.asarray(fixed, dtype=float)
        return values, solved(values), [values], None
    model, prepared = assembly.model, assembly.prepared
    own = bool(own_shapes(model))
    if isinstance(starts, np.ndarray) or own:
        began = np.asarray(starts, dtype=float) if isinstance(starts, np.ndarray) else np.array([])
        if not began.size:
            began = search_shape(loss, shapes, None, method).best
        rows = np.broadcast_to(began, (len(prepared) if own else 1, len(shapes)))
        found = descend(_Rows(assembly, loss, solved, own), model, prepared, rows, delta)
        best = found if own else found[0]
        return best, solved(best), best, None
    search = search_shape(loss, shapes, starts, method)
    # Far apart again, so that what they agree on is agreed on by starts of their own.
    leaders = search.leaders(6) if method.apart <= 0.0 else [search.best, *search.began]
    return search.best, solved(search.best), leaders, search.agreeing


@dataclass(frozen=True, eq=False)
class _Rows:
    """A fit as a descent over shapes sees it: always (R, S), though a model without own shapes takes one row."""

    assembly: Assembly
    at: Callable[[Float], float]
    solved: Callable[[Float], Settled]
    own: bool

    def _form(self, shapes: Float) -> Float:
        return shapes if self.own else shapes[0]

    def loss(self, shapes: Float) -> float:
        return self.at(self._form(shapes))

    def linear(self, shapes: Float) -> Float:
        return self.solved(self._form(shapes)).linear

    def data(self, shapes: Float, linear: Float) -> LinearData:
        return self.assembly.data(self._form(shapes), linear if self.assembly.model.needs_reference else None)


def _stage(
    kind: str,
    found: Settled,
    shape: Float,
    delta: Float,
    centre: Float,
    searches: Mapping[str, Search],
    seed: int,
    say: Progress,
    scope: str,
    possible: Physics | None = None,
) -> FitStage:
    """Certify the exact solution and let the optimisers and IPOPT solve the same problem."""
    data = found.data
    runs: dict[str, OptimiserRun] = {}
    reference: Reference | None = None
    if possible is not None:
        scope = f"{scope}, among those a leg can have"
        certificate = certify_physical(data, found.linear, delta, possible, scope=scope)
        say(f"IPOPT ({kind})")
        reference = physical_reference(data, delta, possible, solve_sse(data))
        floor = max(certificate.primal, np.finfo(float).tiny)
        reference = replace(reference, gap=(reference.loss - certificate.primal) / floor)
        return FitStage(kind, found.linear, shape, delta, certificate.primal, runs, reference, certificate)
    certificate = certify(data, found.linear, delta, scope=scope)
    if searches:
        compiled = population_fitness(data)
        if kind == "sse":
            problem = sse_problem(data, compiled.sse)
        else:
            problem = huber_problem(data, lambda x: compiled.huber(x, delta), delta, centre)
        floor = max(certificate.primal, np.finfo(float).tiny)
        for name, search in searches.items():
            say(f"{name} ({kind})")
            run = minimise(problem.whitened() if search.whitened else problem, search.optimiser, name=name, seed=seed)
            runs[name] = replace(run, gap=(huber(data.residual(run.x), delta) - certificate.primal) / floor)
        say(f"IPOPT ({kind})")
        reference = solve_reference(data, delta)
        reference = replace(reference, gap=(reference.loss - certificate.primal) / floor)
    return FitStage(kind, found.linear, shape, delta, certificate.primal, runs, reference, certificate)


def _spread(assembly: Assembly, found: Settled, shape: Float, delta: Float) -> Covariance:
    """Return the joint covariance of linear and shape parameters, through the Jacobian of the torque."""
    model, columns, linear = assembly.model, found.data.columns, found.linear
    if not shape.size and not model.needs_reference:
        residual = found.data.residual(linear)
        return covariance(columns, residual, delta, found.data.groups, factor=found.data.factor)

    def predicted(values: Float, at: Float) -> Float:
        return -assembly.data(at, values if model.needs_reference else None).residual(values)  # up to a constant

    slopes = []
    for index, entry in enumerate(model.shapes):
        step = 1e-4 * (entry.shape.max - entry.shape.min)
        up, down = shape.copy(), shape.copy()
        up[..., index] = np.minimum(shape[..., index] + step, entry.shape.max)
        down[..., index] = np.maximum(shape[..., index] - step, entry.shape.min)
        # A value each recording has to itself is not one number with one interval.
        flat = bool(entry.shape.choices) or entry.shape.per_recording
        slopes.append(
            np.zeros_like(found.data.tau)
            if flat
            else (predicted(linear, up) - predicted(linear, down)) / np.mean(up[..., index] - down[..., index])
        )
    total = columns
    if model.needs_reference:
        total = np.empty_like(columns)
        size = np.maximum(np.abs(linear), 1e-3 * max(1e-12, float(np.abs(linear).max())))
        for p in range(linear.size):
            step_p = np.zeros(linear.size)
            step_p[p] = 1e-5 * size[p]
            total[:, :, p] = (predicted(linear + step_p, shape) - predicted(linear - step_p, shape)) / (2.0 * step_p[p])
    extra = np.stack(slopes, axis=2) if slopes else np.zeros((*found.data.tau.shape, 0))
    jacobian = np.concatenate([total, extra], axis=2)
    jacobian = jacobian * found.data.use[:, :, None]
    instruments = np.concatenate([columns, extra], axis=2) if model.needs_reference else None
    return covariance(jacobian, found.data.residual(linear), delta, found.data.groups, instruments)


def _estimates(
    model: FittableModel, linear: Float, shape: Float, spread: Covariance, possible: Physics | None = None
) -> tuple[Estimate, ...]:
    half = spread.half_widths()
    middle = _middle(shape)
    named = [(p.name, p.unit) for p in model.parameters] + [(s.name, s.shape.unit) for s in model.shapes]
    values = np.concatenate([linear, middle])
    low, high = values - half, values + half
    if possible is not None:  # an interval goes no further than a leg can
        count = linear.size
        low[:count] = np.clip(low[:count], possible.low, possible.high)
        high[:count] = np.clip(high[:count], possible.low, possible.high)
    for index, entry in enumerate(model.shapes):
        place = linear.size + index
        # A choice is not estimated by a derivative; what each recording has to itself spans a range.
        if entry.shape.choices:
            low[place] = high[place] = values[place]
        elif entry.shape.per_recording and shape.ndim == 2:
            low[place], high[place] = shape[:, index].min(), shape[:, index].max()
    return tuple(
        Estimate(name, float(v), unit, float(a), float(b))
        for (name, unit), v, a, b in zip(named, values, low, high, strict=True)
    )


def _numerical(model: FittableModel, found: Settled, shape: Float, searched: bool) -> list[Finding]:
    """Return what went wrong in the computation: no rank, no fixed point, a shape at its bound."""
    cautions = []
    factor = found.data.factor
    if factor.unexcited:
        names = ", ".join(found.data.names[p] for p in factor.unexcited)
        what = "nothing in these recordings depends on these parameters, so they are given as 0, without an interval"
        remedy = "record a motion in which the joint they belong to moves"
        cautions.append(Finding("unexcited", "warning", what, names, remedy=remedy))
    together = [p for p in factor.undetermined if p not in factor.unexcited]
    if together:
        names = ", ".join(found.data.names[p] for p in together)
        what = "these recordings do not determine these parameters one by one; the smallest fit is given"
        remedy = "record motion that excites them separately, or remove an effect the others already contain"
        cautions.append(Finding("rank", "warning", what, names, remedy=remedy))
    if not found.converged:
        what = f"the torque the model feeds back into itself did not settle in {found.rounds} rounds"
        cautions.append(Finding("fixed_point", "warning", what, model.name, remedy="leave that effect out"))
    for entry, value in zip(model.shapes if searched else (), shape, strict=False):
        unit = 0.5 if entry.shape.choices else to_unit(entry.shape, float(value))
        if min(unit, 1.0 - unit) < 1e-3:
            limit = entry.shape.min if unit < 0.5 else entry.shape.max
            what = f"{value:.4g} {entry.shape.unit} is at the edge of its search range"
            remedy = "the effect may stand in for another one; compare its look-alikes with `exoid diagnose`"
            cautions.append(Finding("edge", "warning", what, entry.name, float(value), limit, remedy))
    return cautions


def _unproven(stage: FitStage) -> list[Finding]:
    """Return a warning where the optimum could not be proven."""
    if stage.certificate.holds:
        return []
    what = f"the optimum is not proven: relative duality gap {stage.certificate.gap:.1e}"
    remedy = "look for parameters of extreme size or recordings with hardly any motion"
    value, limit = stage.certificate.gap, stage.certificate.tolerance
    return [Finding("certificate", "warning", what, stage.kind, value, limit, remedy)]
