"""Figures of the diagnosis: the falling error, torque over time, the error against what it depends on, suspects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from diagnosis.evidence.present import Present, filtered_torque
from diagnosis.evidence.remainder import VARIABLES, Remainder
from ground.figures import (
    FAINT,
    INK,
    JOINT_COLOURS,
    JOINT_MARKERS,
    PAPER,
    ROLE_COLOURS,
    figure_style,
    label,
    new_figure,
)
from symbolic.motion import Float
from symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from diagnosis.compare import Comparison
    from diagnosis.results import Diagnosis, Step

SECONDS_SHOWN = 15.0
BINS = 24
LEAST_IN_BIN = 12
Named = tuple[str, str, Any]


def falling_error(steps: Sequence[Step], noise_floor: Float) -> Figure:
    """Draw the RMS error per joint from step to step, unseen and fitted, with the noise floor."""
    with figure_style():
        figure = new_figure(8.0, 3.8)
        panels = figure.subplots(1, 2)
        place = np.arange(len(steps), dtype=float)
        unseen = steps[0].verify_rms is not None
        for j, (joint, axes) in enumerate(zip(JOINTS, panels, strict=True)):
            train = [s.train_rms[j] for s in steps]
            if unseen:
                verify = [s.verify_rms[j] for s in steps if s.verify_rms is not None]
                axes.bar(place - 0.2, train, 0.36, color=ROLE_COLOURS["train"], label="fitted motion")
                axes.bar(place + 0.2, verify, 0.36, color=ROLE_COLOURS["verify"], label="unseen motion")
                _numbers(axes, list(place + 0.2), verify)
            else:
                axes.bar(place, train, 0.5, color=ROLE_COLOURS["train"], label="fitted motion")
                _numbers(axes, list(place), train)
            axes.axhline(noise_floor[j], color=ROLE_COLOURS["floor"], linestyle="--", label="noise floor")
            axes.set_xticks(place, [_wrapped(s.label) for s in steps], fontsize=8)
            axes.set(title=joint, ylabel=label("RMS error", "N·m"))
            axes.margins(y=0.18)
            axes.grid(axis="x", visible=False)
        handles, names = panels[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=3)
    return figure


def _numbers(axes: Any, place: Sequence[float], values: Sequence[float]) -> None:
    for x, y in zip(place, values, strict=True):
        axes.annotate(
            f"{y:.2g}", (x, y), (0, 3), textcoords="offset points", ha="center", fontsize=8, color=INK,
            bbox={"facecolor": PAPER, "edgecolor": "none", "pad": 0.8},
        )  # fmt: skip


def _wrapped(text: str) -> str:
    return text.replace(":", "\n")


def over_time(now: Present) -> Figure:
    """Draw measured and modelled torque and the residual of both joints, of an unseen recording if there is one."""
    count = len(now.prepared.train)
    index = count if now.prepared.verify else 0
    one = now.prepared.all[index]
    model = filtered_torque(now.model, one, now.linear, now.shapes[index])
    t = one.t - one.t[0]
    shown = t <= SECONDS_SHOWN
    with figure_style():
        figure = new_figure(8.0, 5.2)
        panels = figure.subplots(4, 1, sharex=True, height_ratios=[2, 1, 2, 1])
        for j, joint in enumerate(JOINTS):
            upper, lower = panels[2 * j], panels[2 * j + 1]
            upper.plot(t[shown], one.tau[shown, j], color=ROLE_COLOURS["measured"], label="measured", linewidth=2.2)
            upper.plot(t[shown], model[j][shown], color=ROLE_COLOURS["model"], label="model")
            left = np.where(one.use[:, j], now.residuals[index][j], np.nan)
            lower.plot(t[shown], left[shown], color=ROLE_COLOURS["residual"], label="left over")
            lower.axhline(0.0, color=FAINT, linewidth=0.7)
            upper.set(title=f"{joint}, {one.name}", ylabel=label("torque", "N·m"))
            lower.set(ylabel=label("error", "N·m"))
        panels[-1].set(xlabel=label("time", "s"))
        handles = [*panels[0].get_legend_handles_labels()[0], *panels[1].get_legend_handles_labels()[0]]
        figure.legend(handles, ["measured", "model", "left over"], loc="outside lower center", ncols=3)
    return figure


def against(now: Present, joint: str, variable: str) -> Figure:
    """Draw the residual of `joint` against `variable` with binned means and an honest band, per recording set."""
    j = JOINTS.index(joint)
    with figure_style():
        figure = new_figure(5.6, 3.6)
        axes = figure.subplots()
        every = list(zip(now.prepared.all, now.residuals, strict=True))
        x = np.concatenate([_signal(p, variable)[p.use[:, j]] for p, _ in every])
        y = np.concatenate([r[j][p.use[:, j]] for p, r in every])
        step = max(1, len(x) // 4000)
        axes.plot(x[::step], y[::step], ".", color=JOINT_COLOURS[joint], markersize=2, alpha=0.25, rasterized=True)
        centre, mean, half = _binned(now, j, variable)
        axes.errorbar(
            centre, mean, half, color=INK, marker=JOINT_MARKERS[joint], markersize=3.5, linewidth=1.2,
            label="mean in a bin, 95 % over recordings' blocks",
        )  # fmt: skip
        low, high = np.quantile(y, (0.002, 0.998))
        axes.set_ylim(low - 0.1 * (high - low), high + 0.1 * (high - low))
        words, unit = VARIABLES[variable]
        axes.set(title=f"{joint}: error against {words}", xlabel=label(words, unit), ylabel=label("error", "N·m"))
        axes.legend(loc="best", fontsize=8)
    return figure


def _signal(one: Any, variable: str) -> Float:
    motion = one.motion
    if variable == "t":
        return np.asarray((motion.t - motion.t[0])[one.kept])
    stem, index = variable[:-1], int(variable[-1]) - 1
    return np.asarray({"q": motion.q, "dq": motion.dq, "ddq": motion.ddq}[stem][one.kept, index])


def _binned(now: Present, j: int, variable: str) -> tuple[Float, Float, Float]:
    """Return centres, means and half-widths; the width comes from the scatter of block means, not of samples."""
    xs, ys, blocks = [], [], []
    for number, (one, residual) in enumerate(zip(now.prepared.all, now.residuals, strict=True)):
        used = one.use[:, j]
        xs.append(_signal(one, variable)[used])
        ys.append(residual[j][used])
        blocks.append((1000 * number + np.arange(len(one.t)) // max(1, int(2.0 * one.kept_rate)))[used])
    x, y, block = np.concatenate(xs), np.concatenate(ys), np.concatenate(blocks)
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


def curve(one: Remainder) -> Figure:
    """Draw a learnt remainder with its band."""
    words, unit = VARIABLES[one.variable]
    with figure_style():
        figure = new_figure(5.6, 3.4)
        axes = figure.subplots()
        colour = JOINT_COLOURS[one.joint]
        axes.fill_between(one.x, one.y - one.band, one.y + one.band, color=colour, alpha=0.25, label="95 % band")
        axes.plot(one.x, one.y, color=colour, label="learnt curve")
        axes.axhline(0.0, color=FAINT, linewidth=0.7)
        turned = {"sign": " × sign of motion", "speed": " × velocity"}.get(one.factor, "")
        axes.set(title=f"{one.joint}: what is left", xlabel=label(words, unit), ylabel=label(f"torque{turned}", "N·m"))
        axes.legend(loc="best", fontsize=8)
    return figure


def suspects(found: Diagnosis, most: int = 10) -> Figure:
    """Draw how much of the unseen error each suspect explains; those that placebos do not match are filled."""
    rows = [s for s in found.suspects if s.explained_share > 0.0][:most][::-1]
    with figure_style():
        figure = new_figure(6.4, 0.8 + 0.3 * max(1, len(rows)))
        axes = figure.subplots()
        for place, s in enumerate(rows):
            colour = JOINT_COLOURS.get(s.joint or "", ROLE_COLOURS["floor"])
            sure = s.p_value is not None and s.p_value <= 0.01 and not s.caution
            axes.barh(place, 100 * s.explained_share, color=colour if sure else "none", edgecolor=colour)
        axes.set_yticks(range(len(rows)), [s.name for s in rows], fontsize=8)
        axes.set(xlabel=label("share of the unseen error explained alone", "%"), title="Suspects (filled: p ≤ 0.01)")
        axes.grid(axis="y", visible=False)
    return figure


def comparison_figures(found: Comparison) -> list[Named]:
    """Return the figures of a comparison: over time, and against what the error depends on most."""
    out: list[Named] = [
        (
            "Measured and modelled torque",
            "Torque of hip and knee over time, measured and modelled, with the difference below each.",
            over_time(found.now),
        )
    ]
    seen: set[tuple[str, str]] = set()
    for one in found.where:
        if (one.joint, one.variable) in seen or one.variable == "load" or len(seen) == 4:
            continue
        seen.add((one.joint, one.variable))
        title = f"{one.joint}: error against {VARIABLES[one.variable][0]}"
        out.append((title, one.sentence, against(found.now, one.joint, one.variable)))
    return out


def diagnosis_figures(found: Diagnosis) -> list[Named]:
    """Return the figures of a diagnosis: the falling error, the suspects, and what nobody explains."""
    first, last = found.steps[0], found.steps[-1]
    kind = "fitted" if first.verify_rms is None else "unseen"
    before = first.train_rms if first.verify_rms is None else first.verify_rms
    after = last.train_rms if last.verify_rms is None else last.verify_rms
    text = "; ".join(
        f"{joint}: {kind} error from {b:.3g} to {a:.3g} N·m" for joint, b, a in zip(JOINTS, before, after, strict=True)
    )
    out: list[Named] = [("The error falling", text, falling_error(found.steps, found.noise_floor))]
    if found.suspects:
        best = ", ".join(s.name for s in found.suspects[:3])
        out.append(
            ("Suspects", f"Share of the unseen error each suspect explains alone; first: {best}.", suspects(found))
        )
    if found.unexplained is not None:
        out.append(("What nobody explains", found.unexplained.sentence, curve(found.unexplained)))
    return out
