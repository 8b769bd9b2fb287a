"""Least motion that recordings must hold for an effect to be accepted, whatever the clock says: the same motion at
half the speed holds as much.

An error within a band says as many independent things as periods of the band pass, and a joint shows an effect again
only where it turns back.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from exoid.diagnosis.rules import RULES, Rules
from exoid.measurement.auditing.checks.motion import STILL
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.optimisation.preparation.prepare import Prepared


def little_motion(prepared: Prepared, rules: Rules, joints: Collection[int] = ()) -> str:
    """The gate that the fitted recordings do not pass, for an effect at any of `joints` (default: of all), and what
    would be enough, in words; "" where they pass.
    """
    seconds, cutoff = fitted_seconds(prepared), prepared.choice.cutoff
    if seconds * cutoff < rules.least_periods:
        return (
            f"the fitted recordings hold {seconds:.1f} s of motion, {seconds * cutoff:.0f} periods of their band of "
            f"{cutoff:g} Hz, on which effects that are not there look real: {rules.least_periods:g} periods, "
            f"{rules.least_periods / cutoff:.3g} s, are enough to accept one"
        )
    counts = np.sum([_strokes(recording, rules) for recording in prepared.train], axis=0)
    at = max(joints or range(len(counts)), key=counts.__getitem__)
    if counts[at] >= rules.least_strokes:
        return ""
    name, strokes = prepared.joints[at].name, "stroke" if counts[at] == 1 else "strokes"
    return (
        f"the fitted recordings hold {counts[at]} {strokes} of the {name} from where it turns back to where it turns "
        f"back again, on which effects that are not there look real: {rules.least_strokes} are enough to accept one"
    )


def fitted_seconds(prepared: Prepared) -> float:
    """Duration of the fitted motion in s."""
    return sum(float(recording.t[-1] - recording.t[0]) for recording in prepared.train)


def _strokes(one: PreparedRecording, rules: Rules = RULES) -> np.ndarray:
    """Number of strokes (J,) of each joint, those left out that are short beside its range."""
    count = []
    for q, dq, reach in zip(one.motion.q[one.kept].T, one.motion.dq[one.kept].T, one.reach, strict=True):
        moving = np.flatnonzero(dq)  # where it stops for a while it turns back once, or not at all
        turns = moving[np.flatnonzero(np.diff(np.sign(dq[moving])))]
        least = max(STILL * reach, rules.worth_telling * float(np.ptp(q)))
        count.append(np.count_nonzero(np.abs(np.diff(q[np.concatenate([[0], turns, [-1]])])) >= least))
    return np.array(count)
