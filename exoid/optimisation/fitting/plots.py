"""Pictures of a fit: parameters with their intervals, the residual, the way to the optimum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from exoid.ground.figures import FAINT, ROLE_COLOURS, figure_style, label, new_figure
from exoid.symbolic.joints import Joint
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


History = tuple[Float, Float]
"""Evaluations (G,) and the best loss after them (G,)."""


def fit_figure(
    joints: Sequence[Joint],
    t: Sequence[Float],
    torque: Sequence[Float],
    residual: Sequence[Float],
    delta: Float,
    estimates: Sequence[Estimate],
    runs: Mapping[str, History],
    optimum: float,
    tolerance: float,
) -> Figure:
    """Draw residuals per joint, relative intervals, and convergence where optimisers ran.

    `torque` and `residual` hold the samples used of each of `joints` (N,) at `t` s, the recordings end to end, with δ
    (J,) as the border of the Huber loss; `optimum` is certified to the relative `tolerance`.
    """
    with figure_style():
        rows = -(-(len(joints) + 2) // 2)
        figure = new_figure(11.0, 3.5 * rows)
        *panels, intervals, convergence = figure.subplots(rows, 2).ravel()
        for j, (joint, axes) in enumerate(zip(joints, panels, strict=False)):
            _residual(joint, t[j], torque[j], residual[j], float(delta[j]), axes)
        for axes in panels[len(joints) :]:
            axes.set_visible(False)
        _intervals(estimates, intervals)
        _convergence(runs, optimum, tolerance, convergence)
    return figure


def _residual(joint: Joint, t: Float, torque: Float, residual: Float, delta: float, axes: Axes) -> None:
    axes.plot(t, torque, color=ROLE_COLOURS["measured"], linewidth=0.8, label="torque")
    axes.plot(t, residual, color=ROLE_COLOURS["model"], linewidth=0.8, label="residual")
    for border in (-delta, delta):
        axes.axhline(border, color=FAINT, linewidth=0.6, linestyle=":")
    rms = float(np.sqrt(np.mean(residual**2))) if len(residual) else 0.0
    unit = joint.unit("tau")
    axes.set(title=f"{joint.name}: rms {rms:.3g} {unit}", ylabel=label("torque", unit))
    axes.set(xlabel=label("time, recordings end to end", "s"))
    axes.legend(loc="upper right", fontsize="small")


def _intervals(estimates: Sequence[Estimate], axes: Axes) -> None:
    """Draw each parameter's 95 % interval relative to its value; zero is where the parameter would vanish."""
    shown = [e for e in estimates if np.isfinite(e.high - e.low) and e.value != 0.0]
    size = np.array([abs(e.value) for e in shown])
    middle = np.array([e.value for e in shown]) / size
    half = np.array([0.5 * (e.high - e.low) for e in shown]) / size
    rows = np.arange(len(shown))
    axes.errorbar(middle, rows, xerr=half, fmt="o", color=ROLE_COLOURS["model"], capsize=3)
    axes.axvline(0.0, color=FAINT, linewidth=0.8)
    axes.set_yticks(rows, [f"{e.name} [{e.unit}]" for e in shown])
    axes.set(title="95 % intervals, relative to the value", xlabel="value / |value|")
    axes.invert_yaxis()


def _convergence(runs: Mapping[str, History], optimum: float, tolerance: float, axes: Axes) -> None:
    """Draw how far above the certified optimum each optimiser was after how many evaluations."""
    from matplotlib.ticker import MaxNLocator

    for name, (counts, history) in runs.items():
        axes.semilogy(counts, _above(history, optimum), label=name)
    axes.axhline(tolerance, color=FAINT, linewidth=0.6, linestyle=":")
    axes.set(title="above the certified optimum", xlabel="evaluations", ylabel="relative gap")
    axes.xaxis.set_major_locator(MaxNLocator(5))
    if runs:
        axes.legend(fontsize="small")


def _above(history: Float, optimum: float) -> Float:
    return np.maximum((history - optimum) / max(optimum, np.finfo(float).tiny), 1e-17)


def run_figure(title: str, counts: Float, history: Float, optimum: float | None = None) -> Figure:
    """Draw the best loss (G,) after `counts` (G,) evaluations; with an `optimum`, how far above it."""
    with figure_style():
        figure = new_figure(6.4, 3.4)
        axes = figure.subplots()
        if optimum is None:
            axes.plot(counts, history, color=ROLE_COLOURS["model"])
            axes.set(ylabel="loss")
        else:
            axes.semilogy(counts, _above(history, optimum), color=ROLE_COLOURS["model"])
            axes.set(ylabel="relative gap")
        axes.set(title=title, xlabel="evaluations")
    return figure
