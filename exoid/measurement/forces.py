"""Measured forces of recordings: what the usual columns mean where a model says nothing, and the signals of a model's.

Without [[forces]] in the model file f1, f2, ... are cuffs on the links, normal to them and positive forwards, at
unknown distances; grf_x and grf_z, or grf_z alone, are the force of the ground on the foot, which is on the line of the
last link; interaction_torque_<joint> is a torque about that joint. Where a force-torque sensor sits on a machine in
space only a model file can say.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.measurement.finding import EVERY, Finding
from exoid.measurement.reading.outside import INTERACTION
from exoid.measurement.recording import Recording
from exoid.symbolic.force import TORQUE, VERTICAL, Force
from exoid.symbolic.joints import Joint, is_leg, is_spatial
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

CUFFS = {"hip": "thigh cuff", "knee": "shank cuff"}
"""What the cuffs of a leg are called."""


def usual_forces(names: Sequence[str], joints: Sequence[Joint]) -> tuple[Force, ...]:
    """Return the forces that columns `names` of a machine with `joints` mean where nobody says otherwise."""
    found = []
    leg = is_leg(joints)
    for k, joint in enumerate(joints, start=1):
        if f"f{k}" in names and not is_spatial(joints) and (joint.turns or k > 1):
            called = CUFFS[joint.name] if leg else f"cuff at {joint.name}"
            found.append(Force(called, joint.name, (f"f{k}",)))
    if "grf_z" in names and not is_spatial(joints):
        both = "grf_x" in names
        columns = ("grf_x", "grf_z") if both else ("grf_z",)
        found.append(Force("ground", joints[-1].name, columns, frame="" if both else VERTICAL))
    for joint in joints:
        if (column := f"{INTERACTION}{joint.name}") in names:
            found.append(Force(f"interaction at {joint.name}", joint.name, (column,), frame=TORQUE))
    return tuple(found)


def pushed_model(model: Model, recordings: Sequence[Recording]) -> Model:
    """Return `model` with the usual forces of what all `recordings` have measured, unless it says itself which.

    A column that never changes is none: its sensor is dead.
    """
    if model.forces or not recordings:
        return model
    shared = set.intersection(*({*recording.forces} for recording in recordings))
    alive = [name for name in recordings[0].forces if name in shared and not _dead(name, recordings)]
    return model.with_forces(*usual_forces(alive, model.joints)) if alive else model


def unused_forces(model: Model, recordings: Sequence[Recording]) -> tuple[Finding, ...]:
    """Return findings about columns of forces that `recordings` have and `model` does not use."""
    every = dict.fromkeys(name for recording in recordings for name in recording.forces)
    said = []
    for name in every:
        if name in model.channels:
            continue
        without = [item.name for item in recordings if name not in item.forces]
        if without:
            why, remedy = f"{_listed(without)} has none", "record it in all, or leave the recordings without it out"
        elif _dead(name, recordings):
            why, remedy = "it never changes", "look at the sensor and its cable"
        else:
            why, remedy = "no force of the model has it", "name it among the columns of a force in [[forces]]"
        what = f"the force in column {name} is not used: {why}"
        said.append(Finding("forces", "warning", what, EVERY, remedy=remedy, consequence=PUSHED))
    return tuple(said)


def _dead(name: str, recordings: Sequence[Recording]) -> bool:
    return not any(np.ptp(recording.forces[name][recording.valid]) > 0.0 for recording in recordings)


PUSHED = "what it measures counts as error of the model"
"""What follows for the result."""


def _listed(names: Sequence[str]) -> str:
    return " and ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")


def force_signals(model: Model, recording: Recording) -> Float | None:
    """Return the measured forces (N, C) of a model's `channels` in a recording, in time with its torques; None for a
    model without. RecordingError where the recording lacks one.
    """
    if not model.forces:
        return None
    lacking = [name for name in model.channels if name not in recording.forces]
    if lacking:
        owner = next(force.name for force in model.forces if lacking[0] in force.columns)
        what = f"the recording has no {_listed(lacking)}, and the model has the force {owner!r}"
        remedy = f"--map {lacking[0]}=COLUMN, or leave the force out of the model file"
        raise RecordingError(what, where=recording.source.path or recording.name, remedy=remedy)
    out = []
    for force in model.forces:
        for name in force.columns:
            values = recording.forces[name]
            out.append(np.interp(recording.t + force.delay, recording.t, values) if force.delay else values)
    return np.column_stack(out)
