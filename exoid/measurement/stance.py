"""Times at which a foot is on the ground: by a switch, a load under it, or the measured force of the ground."""

from __future__ import annotations

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.measurement.recording import Recording
from exoid.measurement.signals.masks import widen
from exoid.symbolic.motion import Float

LOADED: Threshold = 0.05
"""part of the largest load of a foot from which it is on the ground: an insole is never quite zero in the air"""
UPWARDS = "grf_z"
"""Column of the ground's force that is the load of the foot."""
BOUNCE = 0.1
"""s of contact, or without it, that are no step: a switch that bounces, a foot that brushes the ground."""


def load_level(load: Float) -> tuple[float, float, float]:
    """Return the smallest and the largest load (N,), outliers apart, and from which on a foot is on the ground."""
    low, high = (float(x) for x in np.quantile(load, (0.01, 0.99))) if load.size else (0.0, 0.0)
    return low, high, low + (0.5 if set(np.unique(load)) <= {0.0, 1.0} else LOADED) * (high - low)


def stances_of(recording: Recording) -> Float:
    """Times (S, 2) in s at which the foot came down and left the ground, whole stances only; none where nothing says
    so.
    """
    load = recording.contact if recording.contact is not None else recording.forces.get(UPWARDS)
    if load is None:
        return np.zeros((0, 2))
    low, high, level = load_level(load[recording.valid])
    if not low < high:
        return np.zeros((0, 2))
    reach = round(0.5 * BOUNCE * recording.rate)
    on = ~widen(~widen(load > level, reach), reach)  # pauses are closed first, then what is brief is no step
    on = widen(~widen(~on, reach), reach)
    begins, ends = (np.flatnonzero(np.diff(on.astype(int)) == way) + 1 for way in (1, -1))
    ends = ends[ends > begins[0]] if begins.size else ends[:0]
    count = min(begins.size, ends.size)
    t = recording.t
    return np.column_stack([t[begins[:count]], t[ends[:count]]])
