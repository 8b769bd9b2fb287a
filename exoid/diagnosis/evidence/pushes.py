"""Does a measured force count the way its columns say? Judged by the gain that the torques want it to have."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import Evidence
from exoid.optimisation.linear.factor import factorise
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.symbolic.force import Force
from exoid.symbolic.mechanics.newton_euler import STILL, BaseMotion
from exoid.symbolic.mechanics.pushed import placed_joints, pushed_torques
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float


@dataclass(frozen=True)
class WantedGain:
    """The gain that the torques want a measured force to have, with its standard deviation, and which share of the loss
    of unseen motion it takes off.
    """

    force: Force
    gain: float
    deviation: float
    share: float


def wanted_gains(base: FittedModel) -> tuple[WantedGain, ...]:
    """Return the gain that the fitted recordings want each measured force to have, all other numbers free beside it."""
    if not base.model.forces:
        return ()
    evidence = base.evidence(seed=0, draws=0)
    return tuple(found for force in base.model.forces if (found := _wanted(force, base, evidence)) is not None)


def _wanted(force: Force, base: FittedModel, evidence: Evidence) -> WantedGain | None:
    """Return the gain a force is wanted to have: with a place that is free, of what it does at its link's joint, and
    where it does nothing there, which way along the link its place is.
    """
    model, data = base.model, base.fit.data
    carried, _ = force.reaches(model.joints)
    place = next((e for e in base.fit.estimates if e.name == f"{force.name}.at"), None)
    if not carried and force.at is None:
        if place is None:
            return None
        deviation = (place.high - place.low) / (2.0 * 1.96) / max(abs(place.value), 1e-9)
        left = float(np.sum((data.residual(base.linear) * data.use) ** 2))
        basis = factorise(np.delete(data.matrix, list(data.names).index(place.name), axis=1)).basis
        without = data.vector - basis @ (basis.T @ data.vector)
        share = 1.0 - left / max(float(without @ without), 1e-300)
        return WantedGain(force, float(np.sign(place.value)), deviation, share)
    # Where its place is free, it is taken at its link's upper joint.
    joints = tuple(range(len(model.joints)))
    made = [force_alone(model, recording, force, force.along) for recording in base.prepared.all]
    grams = evidence.plain([Columns(joints, torque[None, :, :, None]) for torque in made])
    if evidence.novelty(grams)[0] <= 1e-12:
        return None
    slope, each = evidence.fitted(grams)[0][0], evidence.leave_one_out(grams)[:, 0]
    deviation = np.sqrt((len(each) - 1) / len(each) * np.sum((each - each.mean()) ** 2))  # jackknife
    share = float(evidence.gain(grams).total[0] / evidence.fold_losses.sum())
    return WantedGain(force, float(1.0 + slope), float(deviation), share)


def force_alone(model: Model, one: PreparedRecording, force: Force, at: float, gain: float = 1.0) -> Float:
    """Return the filtered torque (J, K) that a measured force makes alone at `at` m on its link, times its `gain`; one
    in space where it says itself.
    """
    motion, first = one.motion, model.channels.index(force.columns[0])
    assert motion.force is not None  # `prepare` refuses recordings without
    signals = force.sign * gain * motion.force[:, first : first + len(force.columns)]
    base = STILL if motion.base is None or model.spatial else BaseMotion(*motion.base.T)
    return one.smooth(pushed_torques(placed_joints(model), motion.q, force, at, signals, base))
