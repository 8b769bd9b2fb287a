"""A phase of its own in every recording, for a term whose coefficients are sine and cosine parts (`Shape.turns`).

Fitted to one recording alone, coefficients say amplitudes and phase together: where the amplitudes are the same in all
recordings, those of one are those of another, turned. So phases need no search of their own.
"""

from __future__ import annotations

import numpy as np

from exoid.ground.ties import index_of_greatest, index_of_least
from exoid.optimisation.fitting.assemble import Assembly
from exoid.optimisation.fitting.shapes import grid
from exoid.optimisation.linear.factor import factorise
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float


def phases_of(parts: Float) -> Float:
    """Return the phases (R,) by which coefficients (R, 2m), sine and cosine parts, of recordings are turned to the same
    ones; chosen so that of these the sine parts are as large as can be, the largest of them positive.
    """
    arrows = parts[:, ::2] + 1j * parts[:, 1::2]
    turned, _, common = np.linalg.svd(arrows, full_matrices=False)
    sines = float(np.angle(np.sum(common[0] ** 2))) / 2.0
    if np.real(common[0] * np.exp(-1j * sines))[index_of_greatest(np.abs(common[0]))] < 0.0:
        sines += np.pi
    return np.asarray(np.angle(turned[:, 0] * np.exp(1j * sines)))


def turning(model: Model) -> tuple[int, ...]:
    """Return the indices of the shape values by which each recording turns coefficients of its own term."""
    return tuple(i for i, entry in enumerate(model.shapes) if entry.shape.turns and entry.shape.per_recording)


def with_phases(assembly: Assembly, begun: Float, reference: Float, searched: bool) -> Float:
    """Return shape values (R, S) that begin at `begun` (S,), each recording with phases of its own; `searched`: at the
    other shape values of these terms at which recordings, each fitted alone, leave least. What a torque of the model
    itself needs is computed from the parameters `reference` (P,).
    """
    model, prepared = assembly.model, assembly.prepared
    rows = np.tile(begun, (len(prepared), 1))
    for index in turning(model):
        name = model.shapes[index].term
        places = [k for k, parameter in enumerate(model.parameters) if parameter.term == name]
        own = [k for k, entry in enumerate(model.shapes) if entry.term == name]
        if searched:
            nodes = np.tile(begun, (len(tried := grid([model.shapes[k].shape for k in own])), 1))
            nodes[:, own] = tried
            nodes[:, index] = 0.0
            rows[:, own] = nodes[index_of_least(_left(assembly, nodes, reference))][own]
        rows[:, index] = 0.0
        rows[:, index] = phases_of(_alone(assembly, rows, reference)[0][:, places])
    return rows


def _left(assembly: Assembly, nodes: Float, reference: Float) -> Float:
    """Squared error (V,) that recordings, each fitted alone, leave together at shape values `nodes` (V, S)."""
    alone = [Assembly(assembly.model, [recording]).sse_at(nodes, reference) for recording in assembly.prepared]
    known = [left for left in alone if left is not None]
    if len(known) == len(alone):
        return np.asarray(np.sum(known, axis=0))
    count = len(assembly.prepared)
    return np.array([_alone(assembly, np.tile(node, (count, 1)), reference)[1] for node in nodes])


def _alone(assembly: Assembly, rows: Float, reference: Float) -> tuple[Float, float]:
    """Return the parameters (R, P) of every recording fitted alone, and what that leaves of all."""
    data = assembly.data(rows, reference)
    parts, left = [], 0.0
    for number in range(len(rows)):
        use = data.use[:, data.groups == number]
        columns, tau = data.columns[:, data.groups == number][use], data.tau[:, data.groups == number][use]
        factor = factorise(columns)
        parts.append(factor.backward @ (factor.basis.T @ tau))
        left += float(np.sum((tau - columns @ parts[-1]) ** 2))
    return np.array(parts), left
