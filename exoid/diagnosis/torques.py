"""The torque over time as fitted models have it, beside the measured one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.plots import over_time

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def torques_over_time(models: Mapping[str, FittedModel]) -> Figure:
    """Draw the measured torque and that of `models` of the same recordings by name, two at most, with what each leaves.

    On the first recording that is held out, or the first of all. What a model leaves is without what belongs to the
    recording beside it (a zero, a load), and its torque with that.
    """
    first = next(iter(models.values()))
    prepared = first.prepared
    index = len(prepared.train) if prepared.verify else 0
    recording = prepared.all[index]
    left = {name: model.residuals[index] for name, model in models.items()}
    drawn = {name: ((recording.torque - x).T, np.where(recording.used, x, np.nan).T) for name, x in left.items()}
    return over_time(recording.name, recording.t, recording.torque.T, drawn, first.model.joints)
