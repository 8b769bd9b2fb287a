"""Figures of the diagnosis: the falling error, torque over time, the error against what it depends on."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.figures import (
    FAINT,
    INK,
    OKABE_ITO,
    PAPER,
    ROLE_COLOURS,
    figure_style,
    joint_colours,
    label,
    new_figure,
)
from exoid.symbolic.joints import LEG, Joint
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from exoid.diagnosis.evidence.fitted import FittedModel

SECONDS_SHOWN = 15.0
BINS = 24
LEAST_IN_BIN = 12
UPRIGHT = 3
"""Bars of steps that have room for their names below them."""

BEFORE: Mapping[str, Any] = {"color": FAINT, "linestyle": (0, (3, 1.5)), "linewidth": 1.1}
"""Look of the model before something was added, beside the one after."""
Groups = Mapping[str, NDArray[np.bool_]]
"""Which samples belong together, by name."""
Quantity = tuple[str, str]
"""What an axis shows, in words, and its unit."""


def falling_error(
    names: Sequence[str],
    fitted: Float,
    unseen: Float | None,
    noise_floor: Float,
    joints: Sequence[str] = JOINTS,
    unit: str = "N·m",
) -> Figure:
    """Draw the RMS error (steps, J) in `unit` from step to step, fitted and unseen, with the noise floor (J,).

    Bars lie where they are more than `UPRIGHT`: the names of the steps then stand at the left of a row of panels.
    """
    lie = len(names) > UPRIGHT
    with figure_style():
        rows = -(-len(joints) // 2)
        figure = new_figure(8.0, (1.0 + 0.26 * len(names) if lie else 3.8) * rows)
        panels = figure.subplots(rows, min(2, len(joints)), squeeze=False, sharey=lie).ravel()
        for spare in panels[len(joints) :]:
            spare.remove()
        place = np.arange(len(names), dtype=float)
        for j, (joint, colour) in enumerate(joint_colours(joints).items()):
            axes = panels[j]
            bars = axes.barh if lie else axes.bar
            shown, aside, width = (fitted, 0.0, 0.5) if unseen is None else (unseen, 0.2, 0.36)
            if unseen is not None:
                bars(place - aside, fitted[:, j], width, color=colour, alpha=0.45)
            bars(place + aside, shown[:, j], width, color=colour)
            _numbers(axes, place + aside, shown[:, j], lie)
            (axes.axvline if lie else axes.axhline)(noise_floor[j], color=INK, linestyle="--", linewidth=1.0)
            if lie:
                axes.set_yticks(place, [fill(name, 40) for name in names], fontsize=8)
                axes.set(title=joint, xlabel=label("RMS error", unit), ylim=(len(names) - 0.4, -0.6))
            else:
                axes.set_xticks(place, [fill(name, 20) for name in names], fontsize=8)
                axes.set(title=joint, ylabel=label("RMS error", unit))
            axes.margins(**{"x" if lie else "y": 0.18})
            axes.grid(axis="y" if lie else "x", visible=False)
        figure.legend(handles=_key(unseen is not None), loc="outside lower center", ncols=3)
    return figure


def _key(unseen: bool) -> list[Any]:
    """Handles of a legend for bars of several colours: fitted motion is paler where there is unseen motion, too."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    bars = [Patch(color=FAINT, alpha=0.45 if unseen else 1.0, label="fitted motion")]
    bars += [Patch(color=FAINT, label="unseen motion")] * unseen
    return [*bars, Line2D([], [], color=INK, linestyle="--", linewidth=1.0, label="noise floor")]


def _numbers(axes: Any, place: Float, values: Float, lie: bool) -> None:
    above = {"xytext": (3, 0), "va": "center"} if lie else {"xytext": (0, 3), "ha": "center"}
    for at, value in zip(place, values, strict=True):
        axes.annotate(
            f"{value:.2g}", (value, at) if lie else (at, value), textcoords="offset points", fontsize=8, color=INK,
            **above, bbox={"facecolor": PAPER, "edgecolor": "none", "pad": 0.8},
        )  # fmt: skip


def _torque_and_error(
    joints: Sequence[Joint], said: str, along: Quantity, draw: Callable[[int, Any, Any], None]
) -> Figure:
    """Draw two panels for each joint, torque above and error below; `draw` draws into those of a joint (index)."""
    with figure_style():
        figure = new_figure(8.0, 2.6 * max(2, len(joints)))
        panels = figure.subplots(2 * len(joints), 1, sharex=True, height_ratios=[2, 3] * len(joints))
        for j, joint in enumerate(joints):
            upper, lower, unit = panels[2 * j], panels[2 * j + 1], joint.unit("tau")
            draw(j, upper, lower)
            lower.axhline(0.0, color=FAINT, linewidth=0.7)
            upper.set(title=f"{joint.name}{said}", ylabel=label("torque" if joint.turns else "force", unit))
            lower.set(ylabel=label("error", unit))
        panels[-1].set(xlabel=label(*along))
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def torques_over_time(models: Mapping[str, FittedModel]) -> Figure:
    """Draw the measured torque and that of `models` of the same recordings by name, two at most, with what each leaves.

    On the first recording that is held out, or the first of all. What a model leaves is without what belongs to the
    recording beside it (a zero, a load), and its torque with that.
    """
    first = next(iter(models.values()))
    prepared = first.prepared
    index = len(prepared.train) if prepared.verify else 0
    recording = prepared.all[index]
    shown = recording.t - recording.t[0] <= SECONDS_SHOWN
    t = (recording.t - recording.t[0])[shown]
    after = {"color": ROLE_COLOURS["after"]}
    looks = [BEFORE, after] if len(models) > 1 else [{"color": ROLE_COLOURS["model"]}]

    def draw(j: int, upper: Any, lower: Any) -> None:
        measured, used = recording.torque[j, shown], recording.used[j, shown]
        upper.plot(t, measured, color=ROLE_COLOURS["measured"], label="measured", linewidth=2.2)
        for look, (name, model) in zip(looks, models.items(), strict=True):
            left = model.residuals[index][j, shown]
            upper.plot(t, measured - left, label=name, **look)
            lower.plot(t, np.where(used, left, np.nan), **look)

    return _torque_and_error(first.model.joints, f", {recording.name}", ("time", "s"), draw)


def against(
    joint: str,
    variable: Quantity,
    x: Float,
    y: Float,
    block: NDArray[np.int64],
    groups: Groups | None = None,
    joints: Sequence[str] = JOINTS,
    unit: str = "N·m",
) -> Figure:
    """Draw the residual `y` (K,) in `unit` of one of the `joints` over a variable `x` (K,), with means and 95 % bands.

    `block` (K,) says which stretch of time a sample belongs to: the band comes from the scatter of the stretches'
    means, since neighbouring samples are no independent evidence. `groups` (masks (K,) by name) are drawn apart.
    """
    whole = joint_colours(joints)[joint]
    drawn = [("", np.ones(len(x), dtype=bool), whole, INK)]
    if groups:
        drawn = [(n, m, c, c) for (n, m), c in zip(groups.items(), itertools.cycle(OKABE_ITO.values()), strict=False)]
    with figure_style():
        figure = new_figure(5.6, 3.6)
        axes = figure.subplots()
        step = max(1, len(x) // 4000)
        for name, mask, points, line in drawn:
            axes.plot(x[mask][::step], y[mask][::step], ".", color=points, markersize=2, alpha=0.25, rasterized=True)
            centre, mean, half = _binned(x[mask], y[mask], block[mask])
            axes.errorbar(
                centre, mean, half, color=line, marker="o", markersize=3.5, linewidth=1.2,
                label=name or "mean in a bin, 95 % over recordings' blocks",
            )  # fmt: skip
        low, high = np.quantile(y, (0.002, 0.998))
        axes.set_ylim(low - 0.1 * (high - low), high + 0.1 * (high - low))
        axes.set(title=f"{joint}: error against {variable[0]}", xlabel=label(*variable), ylabel=label("error", unit))
        axes.legend(loc="best", fontsize=8)
    return figure


def _binned(x: Float, y: Float, block: NDArray[np.int64]) -> tuple[Float, Float, Float]:
    """Return centres, means and half-widths of the bins that hold enough samples of enough blocks."""
    if not len(x):
        return np.empty(0), np.empty(0), np.empty(0)
    edges = np.unique(np.quantile(x, np.linspace(0.0, 1.0, BINS + 1)))
    which = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(edges) - 2)
    rows = []
    for b in range(len(edges) - 1):
        inside = which == b
        means = [y[inside & (block == k)].mean() for k in np.unique(block[inside])]
        if inside.sum() >= LEAST_IN_BIN and len(means) > 2:
            spread = float(np.std(means, ddof=1) / np.sqrt(len(means)))
            rows.append((x[inside].mean(), y[inside].mean(), 1.96 * spread))
    table = np.array(rows).reshape(-1, 3)
    return table[:, 0], table[:, 1], table[:, 2]


def curve(
    joint: str,
    variable: Quantity,
    x: Float,
    y: Float,
    band: Float,
    factor: str = "",
    joints: Sequence[str] = JOINTS,
    unit: str = "N·m",
) -> Figure:
    """Draw a learnt curve `y` (M,) in `unit` over `x` (M,) with its `band` (M,), times `factor` (in words)."""
    with figure_style():
        figure = new_figure(5.6, 3.4)
        axes = figure.subplots()
        colour = joint_colours(joints)[joint]
        axes.fill_between(x, y - band, y + band, color=colour, alpha=0.25, label="95 % band")
        axes.plot(x, y, color=colour, label="learnt curve")
        axes.axhline(0.0, color=FAINT, linewidth=0.7)
        axes.set(title=f"{joint}: what is left", xlabel=label(*variable), ylabel=label(f"torque{factor}", unit))
        axes.legend(loc="best", fontsize=8)
    return figure


def over_the_stride(
    phase: Float,
    measured: Float,
    measured_band: Float,
    model: Float,
    error: Float,
    error_band: Float,
    joints: Sequence[Joint] = LEG,
    stance: float = np.nan,
) -> Figure:
    """Draw the measured torque and that of the model (J, P) over the `phase` (P,) of a stride, and the error below,
    with bands (J, P) of one standard deviation; NaN is not drawn. A line ends `stance`, a part of the stride.
    """
    x = 100.0 * phase

    def draw(j: int, upper: Any, lower: Any) -> None:
        lines = (
            (upper, measured, measured_band, "measured", "measured, from stride to stride"),
            (upper, model, None, "model", "model"),
            (lower, error, error_band, "model", ""),
        )
        for axes, y, band, role, words in lines:
            colour = ROLE_COLOURS[role]
            if band is not None:
                axes.fill_between(x, y[j] - band[j], y[j] + band[j], color=colour, alpha=0.25, linewidth=0.0)
            axes.plot(x, y[j], color=colour, label=words)
        if np.isfinite(stance):
            for axes in (upper, lower):
                axes.axvline(100.0 * stance, color=FAINT, linewidth=0.9, linestyle="--")

    known = ", on the ground up to the broken line" if np.isfinite(stance) else ""
    return _torque_and_error(joints, "", (f"stride{known}", "%"), draw)
