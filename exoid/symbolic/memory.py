"""Operators with memory of a whole model, computed over a recording before the pointwise equations are."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from exoid.symbolic.evaluation import base_places, feedback, motion_words, shape_values, shaped
from exoid.symbolic.language.instant import Operation, split_memory
from exoid.symbolic.language.lower import to_numpy
from exoid.symbolic.language.operators import MEMORY
from exoid.symbolic.language.torque import torques
from exoid.symbolic.language.words import FEEDBACK
from exoid.symbolic.motion import Float, Motion

if TYPE_CHECKING:
    from exoid.symbolic.model_structure import ModelStructure
    from exoid.symbolic.term import Term


def memory_operations(model: ModelStructure) -> list[tuple[Term, int, Operation]]:
    """Return (term, joint, operation) of every operator, in the order of the generated code's `memory`."""
    found: list[tuple[Term, int, Operation]] = []
    for term in model.terms:
        for torque in torques(term):
            _, operations = split_memory(torque.node, len(found))
            found += [(term, torque.joint, operation) for operation in operations]
    return found


def memory_signals(
    model: ModelStructure, motion: Motion, shapes: Float, linear: Float, base_columns: Callable[[], Float]
) -> Float:
    """Return the operators' values (N, K) along `motion`, taken as one uninterrupted recording.

    `base_columns` gives the columns (J, N, P) from which the model's own torque is computed where a text
    feeds it to an operator.
    """
    operations = memory_operations(model)
    values = np.zeros((len(motion), len(operations)))
    if not operations:
        return values
    env, at = motion_words(motion), shape_values(model, shapes)
    if any(operation.argument.names() & FEEDBACK for _, _, operation in operations):
        env |= feedback(model, model.terms, base_columns()[:, :, base_places(model)], linear, motion)
    for k, (term, _, operation) in enumerate(operations):
        words = {**env, **shaped(term, at)}
        argument = to_numpy(operation.argument, words, motion.signs)
        signal = np.broadcast_to(argument, motion.t.shape)
        extra = [] if operation.parameter is None else [float(to_numpy(operation.parameter, words))]
        values[:, k] = MEMORY[operation.operator](motion.t, signal, *extra)
        env[operation.name] = values[:, k]
    return values
