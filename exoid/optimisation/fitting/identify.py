"""From recordings to a fitted model: SSE, thresholds δ from it, Huber; proof, intervals, plausibility.

The linear parameters are solved exactly (`linear.py`) and proven (`certificate.py`). NFO and IPOPT solve
the very same problems and are reported with their distance to the proven optimum; they confirm, the proof decides.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from exoid.ground.errors import NotEnoughDataError
from exoid.measurement.forces import pushed_model
from exoid.measurement.reading.given import Given, machine_of, question_of
from exoid.optimisation.fitting.assemble import Assembly, Settled
from exoid.optimisation.fitting.cautions import held, numerical, own_numbers, price, unproven
from exoid.optimisation.fitting.fit import Fit, FitStage
from exoid.optimisation.fitting.intervals import estimates_of, middle, spread_of
from exoid.optimisation.fitting.plausibility import check_plausibility
from exoid.optimisation.fitting.settings import FitOptions, FitSettings, Search
from exoid.optimisation.fitting.shape_fit import shape_method, solve_shape
from exoid.optimisation.fitting.shape_problem import solution
from exoid.optimisation.fitting.shapes import STARTS
from exoid.optimisation.linear.certificate import Certificate, certify
from exoid.optimisation.linear.loss import huber, joint_weights
from exoid.optimisation.linear.physical import Physics, certify_physical, physics
from exoid.optimisation.linear.problem import huber_problem, sse_problem
from exoid.optimisation.linear.reference import Reference, solve_reference
from exoid.optimisation.linear.solve import delta_rule, solve_sse
from exoid.optimisation.optimiser import OptimiserRun, minimise
from exoid.optimisation.optimisers.nfo import NFO
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.optimisation.preparation.prepare import Prepared, prepare
from exoid.symbolic.codegen.fitness import fitness
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    from exoid.symbolic.model import Model


SEARCHES: Mapping[str, Search] = MappingProxyType(
    {"nfo": Search(NFO()), "nfo_whitened": Search(NFO(alpha=1.0), whitened=True)}
)
"""What `identify` runs unless told otherwise: NFO as printed, and NFO in whitened coordinates."""

Progress = Callable[[str], None]


def identify(
    model: Model | Given | None = None,
    data: Sequence[PreparedRecording] | Given | None = None,
    settings: FitSettings | None = None,
    *,
    progress: Progress | None = None,
    **changes: Unpack[FitOptions],
) -> Fit:
    """Fit `model` to recordings, prepared or as `exoid.measurement.reading.given` takes them (they are then prepared),
    and return the Fit.

    `physical` looks for the best parameters that some machine could have (`exoid.optimisation.linear.physical`), with
    our certificate; NFO and IPOPT are then left out. `Fit.held` says what that changed. Shape
    parameters are found on a grid or by an optimiser, and then by local searches; `Fit.agreeing` says how many of them
    ended in the same place.
    Refuses data that cannot determine as many parameters as the model has.
    """
    began = time.perf_counter()
    asked = FitSettings.chosen(settings, changes)
    if isinstance(data, (list, tuple)) and not data:
        raise NotEnoughDataError("there is no recording to fit", remedy="give at least one recording")
    model, data = _prepared(model, data)
    possible = physics(model) if asked.physical else None
    assembly = Assembly(model, data)
    found = _stages(assembly, asked, possible, progress or (lambda text: None))
    best, best_shape, delta, stage = found.best, found.shape, found.huber.delta, found.huber
    limits = delta * assembly.weight
    changed = None if possible is None else held(best, limits, possible)

    spread = spread_of(assembly, best, best_shape, limits)
    fitted = best.data.weighted(1.0 / assembly.weight)
    estimates = estimates_of(model, best.linear, best_shape, spread, possible)
    centre_shape = middle(best_shape)
    known = possible is not None and not possible.broken(best.linear)
    cautions = (
        *numerical(model, best, centre_shape, bool(model.shapes) and asked.shape is None),
        *unproven(stage),
        *price(model, changed, best.linear, spread.half_widths()),
        *own_numbers(model),
        *check_plausibility(model, best.linear, estimates, centre_shape, realisable=known),
    )
    return Fit(
        model=model,
        estimates=estimates,
        linear=best.linear,
        shape=centre_shape,
        shapes=np.broadcast_to(best_shape, (len(data), centre_shape.size)),
        delta=delta,
        weight=assembly.weight,
        rms=fitted.rms(best.linear),
        loss=stage.loss,
        runs=stage.runs,
        reference=stage.reference,
        certificate=stage.certificate,
        plausibility=cautions,
        sse=found.sse,
        data=fitted.alone,
        covariance=spread.matrix,
        best_known=bool(model.shapes),
        lag=spread.lag,
        seconds=time.perf_counter() - began,
        recordings=tuple(recording.name for recording in data),
        held=changed,
        agreeing=found.agreeing,
        spacing=_spacing(data[0]),
    )


@dataclass(frozen=True)
class _Stages:
    """Least squares and Huber, the solution `best` of the second at its `shape`, and how many starts agree on that."""

    sse: FitStage
    huber: FitStage
    best: Settled
    shape: Float
    agreeing: tuple[int, int] | None


def _stages(assembly: Assembly, asked: FitSettings, possible: Physics | None, say: Progress) -> _Stages:
    """Fit by least squares, take the thresholds δ from what that leaves, and fit by Huber; prove both."""
    model, shape = assembly.model, asked.shape
    optimisers = SEARCHES if asked.optimisers is None else asked.optimisers
    searches = dict(optimisers) if possible is None else {}
    method = shape_method(asked.shape_search, bool(optimisers), asked.seed)
    proof = _Proof(searches, asked.seed, _scope(model, shape is not None), possible, say)
    infinite = np.full(len(model.joints), np.inf)

    say("least squares")
    first_shape, first, leaders, agreeing = solve_shape(
        assembly, infinite, shape, asked.start, possible=possible, method=replace(method, refined=STARTS)
    )
    first.data.require_enough(model.joints)
    sse = proof.stage("sse", first, middle(first_shape), infinite, first.linear)
    left = delta_rule(first.data.residual(first.linear), use=first.data.use)
    delta = left if asked.delta is None else np.asarray(asked.delta)
    if asked.weighted:
        assembly.weight = joint_weights(left)
        first = replace(first, data=first.data.weighted(assembly.weight))
    limits = delta * assembly.weight

    say("Huber")
    if model.needs_reference or (model.shapes and shape is None):
        best_shape, best, _, agreeing = solve_shape(assembly, limits, shape, leaders, first.linear, possible, method)
    else:  # the columns stay what they were
        best_shape = first_shape
        best = replace(first, linear=solution(first.data, limits, possible, first.linear))
    # The box of the Huber search comes from least squares on the columns of the shape found last.
    squares = first.linear if best.data is first.data and not asked.weighted else solve_sse(best.data)
    stage = proof.stage("huber", best, middle(best_shape), limits, squares)
    return _Stages(sse, replace(stage, delta=delta), best, best_shape, agreeing)


def _spacing(one: PreparedRecording) -> float:
    """Return s between the samples kept: those of the motion, or every second, third, ... of them."""
    t = one.motion.t
    return float(t[-1] - t[0]) / max(1, len(t) - 1) * max(1, round(len(t) / max(1, len(one.kept))))


def _prepared(model: Any, data: Any) -> tuple[Model, Sequence[PreparedRecording]]:
    """Return the model and prepared recordings; those just read are prepared for it, with the cut-off chosen, and it
    gets the forces that they have measured.
    """
    data = data.train if isinstance(data, Prepared) else data
    if isinstance(data, (list, tuple)) and all(hasattr(recording, "motion") for recording in data):
        return model, data
    asked, raw, _ = question_of(model, data)
    model = pushed_model(machine_of(asked), raw)
    return model, prepare(model, raw).train


def _scope(model: Model, given: bool) -> str:
    """Return for what a certificate of this fit holds: a loss is convex in the linear parameters only."""
    scope = "all parameters"
    if model.shapes:
        scope = f"the linear parameters at the {'given' if given else 'best-known'} shape"
    return scope + (", the model's own torque held" if model.needs_reference else "")


@dataclass(frozen=True)
class _Proof:
    """Solution and proof of both stages: the optimisers by name, their seed, what the certificate holds for, and the
    conditions of a leg that could exist, if asked for.
    """

    searches: Mapping[str, Search]
    seed: int
    scope: str
    possible: Physics | None
    say: Progress

    def stage(self, kind: str, found: Settled, shape: Float, delta: Float, centre: Float) -> FitStage:
        """Certify the exact solution and let the optimisers and IPOPT solve the same problem."""
        runs: dict[str, OptimiserRun] = {}
        reference = None
        if self.possible is not None:
            scope = f"{self.scope}, among those a {self.possible.machine} can have"
            certificate = certify_physical(found.data, found.linear, delta, self.possible, scope=scope)
        else:
            certificate, runs, reference = self._free(kind, found, delta, centre)
        if reference is not None:
            reference = replace(reference, gap=_gap(reference.loss, certificate))
        return FitStage(kind, found.linear, shape, delta, certificate.primal, runs, reference, certificate)

    def _free(self, kind: str, found: Settled, delta: Float, centre: Float) -> _Solved:
        data = found.data
        certificate = certify(data, found.linear, delta, scope=self.scope)
        if not self.searches:
            return certificate, {}, None
        compiled = fitness(data.columns, data.tau)
        if kind == "sse":
            problem = sse_problem(data, compiled.sse)
        else:
            problem = huber_problem(data, lambda x: compiled.huber(x, delta), delta, centre)
        runs: dict[str, OptimiserRun] = {}
        for name, search in self.searches.items():
            self.say(f"{name} ({kind})")
            run = minimise(
                problem.whitened() if search.whitened else problem, search.optimiser, name=name, seed=self.seed
            )
            runs[name] = replace(run, gap=_gap(huber(data.residual(run.x), delta), certificate), state=None)
        self.say(f"IPOPT ({kind})")
        return certificate, runs, solve_reference(data, delta)


_Solved = tuple[Certificate, dict[str, OptimiserRun], Reference | None]


def _gap(loss: float, certificate: Certificate) -> float:
    """Distance of `loss` above the certified one, relative to it."""
    return (loss - certificate.primal) / max(certificate.primal, np.finfo(float).tiny)
