"""Cautions beside the numbers of a fit: no rank, no proof, an edge that was reached, what physics cost."""

from __future__ import annotations

import numpy as np

from exoid.measurement.finding import Finding
from exoid.optimisation.fitting.assemble import Settled
from exoid.optimisation.fitting.fit import FitStage
from exoid.optimisation.fitting.shapes import to_unit
from exoid.optimisation.linear.loss import huber
from exoid.optimisation.linear.physical import Held, Physics
from exoid.optimisation.linear.solve import solve_huber
from exoid.symbolic.mechanics.body import TABLE
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float


def numerical(model: Model, found: Settled, shape: Float, searched: bool) -> list[Finding]:
    """Findings of what went wrong in the computation: no rank, no fixed point, a shape at its bound."""
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


def own_numbers(model: Model) -> list[Finding]:
    """Return that a wearer is taken off the numbers, where one is known."""
    if model.wearer is None:
        return []
    what = f"the parameters are those of the machine alone: the limb of a wearer ({model.wearer}; {TABLE}) is taken off"
    consequence = "how far persons differ from the table is in the intervals"
    return [Finding("wearer", "info", what, model.name, consequence=consequence)]


def unproven(stage: FitStage) -> list[Finding]:
    """Return a warning where the optimum could not be proven."""
    if stage.certificate.holds:
        return []
    what = f"the optimum is not proven: relative duality gap {stage.certificate.gap:.1e}"
    remedy = "look for parameters of extreme size or recordings with hardly any motion"
    value, limit = stage.certificate.gap, stage.certificate.tolerance
    return [Finding("certificate", "warning", what, stage.kind, value, limit, remedy)]


def price(model: Model, held: Held | None, linear: Float, half: Float) -> list[Finding]:
    """Return in words what asking for a possible machine has changed: a warning unless `linear` (P,) is as near to the
    fit without it as the intervals of `half` widths (P or more,) reach.
    """
    if held is None or not held.broken:
        return []
    free = np.array([held.free[p.name] for p in model.parameters])
    open_ = bool(np.all(np.abs(free - linear) <= half[: free.size]))
    value = {p.name: f" ({held.free[p.name]:.4g} {p.unit})" for p in model.parameters}
    broken = ", ".join(name + value.get(name, "") for name in held.broken)
    what = f"without the demand for a possible {held.machine} the fit would violate: {broken}; the loss is "
    what += f"{held.cost:.2%} higher"
    remedy = "an effect that is missing or a wrong sign hides in it: run `exoid diagnose`"
    if open_:
        what += ", and every parameter stays within its interval"
        remedy = "nothing need be done; faster motion, of the last joints above all, determines small inertias"
    return [Finding("possible", "info" if open_ else "warning", what, "physical", held.cost, 0.0, remedy)]


def held(found: Settled, delta: Float, possible: Physics) -> Held:
    """Change that asking for a machine that could exist has made in `found`."""
    free = solve_huber(found.data, delta, found.linear)
    broken = possible.broken(free)
    least = huber(found.data.residual(free), delta)
    cost = huber(found.data.residual(found.linear), delta) / max(least, np.finfo(float).tiny) - 1.0
    return Held(dict(zip(found.data.names, map(float, free), strict=True)), broken, max(cost, 0.0) if broken else 0.0,
                possible.machine)  # fmt: skip
