"""Pictures of a fit: parameters with their intervals, the residual, the way to the optimum."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ground.figures import FAINT, ROLE_COLOURS, figure_style, label, new_figure
from symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from optimisation.fitting.fit import Fit
    from optimisation.optimiser import Run


def plot_fit(fit: Fit) -> Figure:
    """Draw residuals per joint, relative intervals, and convergence where optimisers ran."""
    with figure_style():
        figure = new_figure(11.0, 7.0)
        hip, knee, intervals, convergence = figure.subplots(2, 2).ravel()
        for joint, axes in enumerate((hip, knee)):
            plot_residual(fit, joint, axes)
        plot_intervals(fit, intervals)
        plot_convergence(fit, convergence)
    return figure


def plot_residual(fit: Fit, joint: int, axes: Axes) -> None:
    """Draw torque and residual of one joint over the samples used, with δ as the border of the Huber loss."""
    use = fit.data.use[joint]
    axes.plot(fit.data.tau[joint][use], color=ROLE_COLOURS["measured"], linewidth=0.8, label="torque")
    axes.plot(fit.residual[joint][use], color=ROLE_COLOURS["residual"], linewidth=0.8, label="residual")
    for border in (-fit.delta[joint], fit.delta[joint]):
        axes.axhline(border, color=FAINT, linewidth=0.6, linestyle=":")
    axes.set(title=f"{JOINTS[joint]}: rms {fit.rms[joint]:.3g} N·m", xlabel="sample", ylabel=label("torque", "N·m"))
    axes.legend(loc="upper right", fontsize="small")


def plot_intervals(fit: Fit, axes: Axes) -> None:
    """Draw each parameter's 95 % interval relative to its value; zero is where the parameter would vanish."""
    shown = [e for e in fit.estimates if np.isfinite(e.high - e.low) and e.value != 0.0]
    size = np.array([abs(e.value) for e in shown])
    middle = np.array([e.value for e in shown]) / size
    half = np.array([0.5 * (e.high - e.low) for e in shown]) / size
    rows = np.arange(len(shown))
    axes.errorbar(middle, rows, xerr=half, fmt="o", color=ROLE_COLOURS["model"], capsize=3)
    axes.axvline(0.0, color=FAINT, linewidth=0.8)
    axes.set_yticks(rows, [f"{e.name} [{e.unit}]" for e in shown])
    axes.set(title="95 % intervals, relative to the value", xlabel="value / |value|")
    axes.invert_yaxis()


def plot_convergence(fit: Fit, axes: Axes) -> None:
    """Draw how far above the certified optimum each optimiser was after how many evaluations."""
    from matplotlib.ticker import MaxNLocator

    optimum = fit.certificate.primal
    for name, run in fit.runs.items():
        above = np.maximum((run.history - optimum) / max(optimum, np.finfo(float).tiny), 1e-17)
        axes.semilogy(run.counts, above, label=name)
    axes.axhline(fit.certificate.tolerance, color=FAINT, linewidth=0.6, linestyle=":")
    axes.set(title="above the certified optimum", xlabel="evaluations", ylabel="relative gap")
    axes.xaxis.set_major_locator(MaxNLocator(5))
    if fit.runs:
        axes.legend(fontsize="small")


def plot_run(run: Run, optimum: float | None = None) -> Figure:
    """Draw the best fitness of one run against evaluations; with an `optimum`, how far above it."""
    with figure_style():
        figure = new_figure(6.4, 3.4)
        axes = figure.subplots()
        if optimum is None:
            axes.plot(run.counts, run.history, color=ROLE_COLOURS["model"])
            axes.set(ylabel="loss")
        else:
            above = np.maximum((run.history - optimum) / max(optimum, np.finfo(float).tiny), 1e-17)
            axes.semilogy(run.counts, above, color=ROLE_COLOURS["model"])
            axes.set(ylabel="relative gap")
        axes.set(title=run.name, xlabel="evaluations")
    return figure
