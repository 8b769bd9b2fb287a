"""Pictures of what differs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from exoid.ground.figures import figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def errors_figure(
    joints: Sequence[str], units: Sequence[str], before: Sequence[float], after: Sequence[float], named: Sequence[float]
) -> Figure:
    """Draw the RMS error of each joint, in its unit, before, after, and after with what was named."""
    with figure_style():
        figure = new_figure(6.0, 3.2)
        axes = figure.subplots()
        place = np.arange(len(joints))
        for k, (label, values) in enumerate(
            (("before", before), ("after", after), ("after, with what is named", named))
        ):
            axes.bar(place + 0.27 * (k - 1), values, 0.25, label=label)
        axes.set_xticks(place, joints)
        axes.set_ylabel(f"error of the model [{', '.join(dict.fromkeys(units))}]")
        axes.legend()
    return figure
