"""Operators with memory of a whole model, computed over a recording before the pointwise equations are."""

from __future__ import annotations

from collections.abc import Callable
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from exoid.symbolic.evaluation import base_places, feedback, motion_words, shape_values, shaped
from exoid.symbolic.language.instant import Operation, split_memory
from exoid.symbolic.language.lower import to_numpy
from exoid.symbolic.language.operators import MEMORY
from exoid.symbolic.language.torque import by_stage, is_transform, torques
from exoid.symbolic.language.words import FEEDBACK
from exoid.symbolic.motion import Float, Motion

if TYPE_CHECKING:
    from exoid.symbolic.model_structure import ModelStructure
    from exoid.symbolic.term import Term


def memory_operations(model: ModelStructure) -> list[tuple[Term, int, Operation]]:
    """Return (term, joint, operation) of every operator, in the order of the generated code's `memory`: those of
    transforms last, since they act on what the others make.
    """
    found: list[tuple[Term, int, Operation]] = []
    for term in chain(*by_stage(model.terms)):
        for torque in torques(term):
            _, operations = split_memory(torque.node, len(found))
            found += [(term, torque.joint, operation) for operation in operations]
    return found


def sensor_delays(model: ModelStructure, shapes: Float) -> list[tuple[int, float]]:
    """Return (joint, s) of every delay by which a transform shows a joint's torque later, or, below 0, earlier."""
    at = shape_values(model, shapes)
    return [
        (joint, float(to_numpy(operation.parameter, dict(shaped(term, at)))))
        for term, joint, operation in memory_operations(model)
        if operation.operator == "delay" and operation.parameter is not None and is_transform(term)
    ]


def memory_signals(
    model: ModelStructure, motion: Motion, shapes: Float, linear: Float, columns: Callable[[Float], Float]
) -> Float:
    """Return the operators' values (N, K) along `motion`, taken as one uninterrupted recording.

    `columns` gives the columns (J, N, P) at such values, before transforms, from which the model's own torque is
    computed where a text feeds it to an operator.
    """
    operations = memory_operations(model)
    values = np.zeros((len(motion), len(operations)))
    if not operations:
        return values
    env, at = motion_words(motion), shape_values(model, shapes)
    if any(operation.argument.names() & FEEDBACK for _, _, operation in operations):
        env |= feedback(model, model.terms, columns(values)[:, :, base_places(model)], linear, motion)
    whole: dict[str, Float] = {}
    for k, (term, _, operation) in enumerate(operations):
        if not whole and is_transform(term):
            found = columns(values)
            every = np.append(linear, np.ones(found.shape[2] - len(linear)))
            whole = {f"tau_model{j + 1}": torque @ every for j, torque in enumerate(found)}
        words = {**env, **whole, **shaped(term, at)}
        argument = to_numpy(operation.argument, words, motion.signs)
        signal = np.broadcast_to(argument, motion.t.shape)
        extra = [] if operation.parameter is None else [float(to_numpy(operation.parameter, words))]
        values[:, k] = MEMORY[operation.operator](motion.t, signal, *extra)
        env[operation.name] = values[:, k]
    return values
