"""The model's torque as one expression that can be stepped through time: the rigid leg, friction and every
effect.

The rigid part is the model's own derived expression, the effects are its torque texts; both are the sources
of the columns that are identified later. Operators with memory (`play`, `dahl`) become states of the
simulation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from exoid.measurement.bench.hidden import TrueModel
from exoid.measurement.bench.plant import REMEMBERED, step_function
from exoid.symbolic.codegen.equation import model_expressions
from exoid.symbolic.codegen.fingerprint import model_key
from exoid.symbolic.language.torque import torques
from exoid.symbolic.language.tree import OPERATORS, Call
from exoid.symbolic.language.words import MODEL_TORQUE
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float
from exoid.symbolic.term import Term


def belongs_to_channel(term: Term) -> bool:
    """True if a term acts on the measured torque rather than on the leg.

    It does when it speaks of `tau_model`, or has an operator that works on a finished signal (delay, ddt, or
    one operator inside another).
    """

    def finished(node: Any) -> bool:
        if not (isinstance(node, Call) and node.function in OPERATORS):
            return False
        nested = frozenset().union(*(argument.calls() for argument in node.arguments)) & OPERATORS.keys()
        return node.function not in REMEMBERED or bool(nested)

    return term.effect.deflection is None and any(
        torque.names & MODEL_TORQUE or any(finished(node) for node in torque.node.walk()) for torque in torques(term)
    )


def split_channel(true: TrueModel) -> tuple[TrueModel, TrueModel]:
    """Return the model the leg obeys, and the same with the terms of the torque channel.

    Without what stands between link and encoder, which is told in `deflection.py`.
    """
    heard = _kept(true, lambda term: term.effect.deflection is None)
    return _kept(heard, lambda term: not belongs_to_channel(term)), heard


def _kept(true: TrueModel, wanted: Callable[[Term], bool]) -> TrueModel:
    """Return the model with those terms that are `wanted`; itself where these are all."""
    others = [term.name for term in true.model.terms if not wanted(term)]
    if not others:
        return true
    model = true.model.without(*others)
    numbers = true.numbers()
    linear = np.array([numbers[entry.name] for entry in model.parameters])
    return TrueModel(model, linear, np.array([numbers[entry.name] for entry in model.shapes], dtype=float))


@dataclass(frozen=True, eq=False)
class Stepper:
    """The step function of a model for one step length, and what its memories start from."""

    step: Any
    memory_start: Any

    def start(
        self, t: float, q: Float, dq: Float, ddq: Float, linear: Float, shape: Float, base: Float, force: Float
    ) -> Float:
        """Return the state in which the leg is on its path and its operators have just been switched on.

        `base` (5, or 0 where it stands) is how the base moves then, `force` (C,) what pushes.
        """
        memory = np.asarray(self.memory_start(t, q, dq, ddq, linear, shape, base, force)).ravel()
        return np.concatenate([q, dq, ddq, np.sign(dq), q, dq, memory])


_RECENT: dict[tuple[str, float], Stepper] = {}


def stepper(model: Model, dt: float) -> Stepper:
    """Return the step function of `model` (no terms of the torque channel); built once per process and model."""
    key = (model_key(model), dt)
    if key not in _RECENT:
        while len(_RECENT) >= 64:
            _RECENT.pop(next(iter(_RECENT)))
        _RECENT[key] = _build(model, dt)
    return _RECENT[key]


def _build(model: Model, dt: float) -> Stepper:
    import casadi as ca

    form = model_expressions(model)
    arguments = ca.vertcat(ca.SX(0, 1), *(memory.argument for memory in form.memories))
    values = ca.vertcat(ca.SX(0, 1), *(REMEMBERED[item.operator][0](item.argument) for item in form.memories))
    given = [form.t, form.q, form.dq, form.ddq, form.linear, form.shape, form.base_motion, form.force]
    first = ca.Function("first", given, [ca.vertcat(arguments, values)])
    return Stepper(step_function(form, dt, [joint.reach for joint in model.joints]), first)
