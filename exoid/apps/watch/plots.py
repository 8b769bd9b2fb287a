"""Pictures of a watch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from exoid.ground.figures import figure_style, new_figure
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def numbers_figure(
    t: Float, names: Sequence[str], units: Sequence[str], values: Float, low: Float, high: Float,
    marks: Sequence[tuple[float, float, float]],
) -> Figure:  # fmt: skip
    """Draw numbers (K, P) at times `t` (K,) s with their intervals, one below the other.

    Each of `marks` is from when to when a change may have begun, and when it was reported.
    """
    with figure_style():
        figure = new_figure(7.0, 1.1 * len(names) + 0.6)
        rows = np.atleast_1d(figure.subplots(len(names), 1, sharex=True))
        for k, (axes, name, unit) in enumerate(zip(rows, names, units, strict=True)):
            told = np.isfinite(low[:, k]) & np.isfinite(high[:, k])
            axes.fill_between(t[told], low[told, k], high[told, k], alpha=0.25, linewidth=0.0)
            axes.plot(t, values[:, k])
            for begin, end, reported in marks:
                axes.axvspan(begin, end, color="0.5", alpha=0.35, linewidth=0.0)
                axes.axvline(reported, color="0.5", linestyle=":")
            axes.set_ylabel(f"{name}\n[{unit}]", fontsize="small")
        rows[-1].set_xlabel("time [s]; grey: when a change began, dotted: when it was reported")
    return figure
