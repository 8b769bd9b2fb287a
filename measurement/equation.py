"""The model's torque as one expression that can be stepped through time: the rigid leg, friction and every
effect.

The rigid part is the model's own derived expression, the effects are its torque texts; both are the sources
of the columns that are identified later. Operators with memory (`play`, `dahl`) become states of the
simulation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from measurement.hidden import TrueModel
from measurement.plant import Equation, Memory, Symbols, step_function
from symbolic.model import Model
from symbolic.quantity import JOINTS
from symbolic.term import Term

if TYPE_CHECKING:
    from symbolic.torque import Torque

Array = NDArray[np.float64]

REMEMBERED = ("play", "dahl")
"""Operators that the leg itself can have: their state moves with the joint."""

OF_THE_CHANNEL = ("delay", "ddt")
"""Operators on a finished signal: a torque written with them belongs to the torque channel, not to the leg.
"""


def belongs_to_channel(term: Term) -> bool:
    """Whether a term acts on the measured torque rather than on the leg: it speaks of `tau_model`, delay or
    ddt.
    """
    from symbolic.torque import MODEL_TORQUE, torques

    return any(
        torque.names & MODEL_TORQUE or any(call.name in OF_THE_CHANNEL for call in _calls(torque.node))
        for torque in torques(term)
    )


def split_channel(true: TrueModel) -> tuple[TrueModel, bool]:
    """Return the model the leg obeys, without the terms of the torque channel, and whether there were any."""
    kept = [term for term in true.model.terms if not belongs_to_channel(term)]
    if len(kept) == len(true.model.terms):
        return true, False
    model = true.model
    for term in true.model.terms:
        if term not in kept:
            model = model.without(term.name)
    numbers = true.numbers()
    linear = np.array([numbers[entry.name] for entry in model.parameters])
    return TrueModel(
        model, linear, np.array([numbers[entry.name] for entry in model.shapes], dtype=float)
    ), True


@dataclass(frozen=True, eq=False)
class Stepper:
    """The step function of a model for one step length, and what its memories start from."""

    step: Any
    memory_start: Any

    def start(self, t: float, q: Array, dq: Array, ddq: Array, linear: Array, shape: Array) -> Array:
        """Return the state in which the leg is on its path and its operators have just been switched on."""
        memory = np.asarray(self.memory_start(t, q, dq, ddq, linear, shape)).ravel()
        return np.concatenate([q, dq, ddq, np.sign(dq), q, dq, memory])


_RECENT: dict[tuple[str, float], Stepper] = {}


def stepper(model: Model, dt: float) -> Stepper:
    """Return the step function of `model` (no terms of the torque channel); built once per process and model.
    """
    key = (model.key(), dt)
    if key not in _RECENT:
        while len(_RECENT) >= 64:
            _RECENT.pop(next(iter(_RECENT)))
        _RECENT[key] = _build(model, dt)
    return _RECENT[key]


def _build(model: Model, dt: float) -> Stepper:
    import casadi as ca

    equation = equation_of(model)
    sym = equation.symbols
    arguments = ca.vertcat(ca.SX(0, 1), *(entry.argument for entry in equation.memories))
    values = ca.vertcat(ca.SX(0, 1), *(entry.start(entry.argument) for entry in equation.memories))
    first = ca.Function(
        "first",
        [sym.t, sym.q, sym.dq, sym.ddq, sym.linear, sym.shape],
        [ca.vertcat(arguments, values)],
    )
    return Stepper(step_function(equation, dt), first)


def equation_of(model: Model) -> Equation:
    """Return the torque (2,) of `model`, all its terms included, with an entry of memory per `play` or
    `dahl`.
    """
    import casadi as ca

    from symbolic.rigid_columns import rigid_columns
    from symbolic.torque import torques

    size = {"q": 2, "dq": 2, "ddq": 2, "sign": 2, "linear": len(model.parameters), "shape": len(model.shapes)}
    count = sum(len(_remembered(torque.node)) for term in model.terms for torque in torques(term))
    sym = Symbols(
        t=ca.SX.sym("t"),
        memory=ca.SX.sym("memory", count),
        **{name: ca.SX.sym(name, length) for name, length in size.items()},
    )
    place = {entry.name: k for k, entry in enumerate(model.parameters)}
    at = {entry.name: k for k, entry in enumerate(model.shapes)}
    form = rigid_columns(model)
    rigid = ca.vertcat(*(sym.linear[place[name]] for name in form.names))
    shapes = ca.vertcat(ca.SX(0, 1), *(sym.shape[at[name]] for name in form.shapes))
    values = form.function(ca.vertcat(sym.t, sym.q, sym.dq, sym.ddq), shapes, rigid)
    tau_rigid = [ca.SX(0), ca.SX(0)]
    for k, (joint, column) in enumerate(form.entries):
        tau_rigid[joint] += values[k] * rigid[column]
    friction = [
        sym.sign[j] * sym.linear[place[f"coulomb:{joint}"]]
        + sym.dq[j] * sym.linear[place[f"viscous:{joint}"]]
        for j, joint in enumerate(JOINTS)
    ]
    words: dict[str, Any] = {"t": sym.t}
    for j in range(len(JOINTS)):
        words |= {
            f"theta{j + 1}": sym.q[j],
            f"dtheta{j + 1}": sym.dq[j],
            f"ddtheta{j + 1}": sym.ddq[j],
            f"tau_rigid{j + 1}": tau_rigid[j],
        }
    total = [tau_rigid[j] + friction[j] for j in range(len(JOINTS))]
    memories: list[Memory] = []
    for term in model.terms:
        numbers = {key: sym.linear[place[f"{term.name}.{key}"]] for key in term.effect.coefficients}
        numbers |= {key: sym.shape[at[f"{term.name}.{key}"]] for key in term.effect.shape}
        for torque in torques(term):
            total[torque.joint] += _text(torque, {**words, **numbers}, sym, memories)
    return Equation(sym, ca.vertcat(*total), tuple(memories))


def _calls(node: Any) -> list[Any]:
    return []


def _remembered(node: Any) -> list[Any]:
    return []


def _text(torque: Torque, words: Mapping[str, Any], sym: Symbols, memories: list[Memory]) -> Any:
    """Return a torque text as CasADi SX; each of its operators is appended to `memories` and read from there.
    """
    from symbolic.lower import to_casadi

    from symbolic.torque import own_names

    own = {
        word: words[canonical] for word, canonical in own_names(torque.joint).items() if canonical in words
    }
    names = {**words, **own}
    return to_casadi(torque.node, names)
