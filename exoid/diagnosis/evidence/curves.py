"""A curve without physics: cubic B-splines in one variable along the motion of a joint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from weakref import WeakKeyDictionary

import numpy as np

from exoid.diagnosis.evidence.candidates import own_torques
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.joints import LEG, UNITS, Joint
from exoid.symbolic.motion import Float

_WORDS = {"q": ("angle", "position"), "dq": ("velocity", "velocity"), "ddq": ("acceleration", "acceleration")}


@lru_cache(maxsize=32)
def variables(joints: tuple[Joint, ...] = LEG) -> Mapping[str, tuple[str, str]]:
    """Return the variables a remainder may depend on, {"dq2": (name in words, unit)}."""
    found = {
        f"{stem}{k + 1}": (f"{joint.name} {words[not joint.turns]}", UNITS[stem][not joint.turns])
        for stem, words in _WORDS.items()
        for k, joint in enumerate(joints)
    }
    return {**found, "load": ("rigid-body torque of the joint", "N·m"), "t": ("time", "s")}


def split_variable(variable: str) -> tuple[str, int]:
    """Return ("dq", 1) for "dq2"; ("load", -1) for one without a joint's number."""
    stem = variable.rstrip("0123456789")
    return stem, int(variable[len(stem) :] or 0) - 1


def tried_curves(joints: tuple[Joint, ...]) -> tuple[tuple[str, str], ...]:
    """Return (variable, factor). A velocity with the sign of motion is |θ'| with the sign of θ': it may jump at
    standstill.
    """
    known = variables(joints)
    return (
        *((v, "") for v in known),
        *((v, "sign") for v in known if v != "t" and not v.startswith("ddq")),
        *((v, "speed") for v in known if split_variable(v)[0] == "q"),
    )


def may_move(variable: str, factor: str) -> bool:
    """True if strapping can move a curve in this variable: the place of a stop or a bump, on the path."""
    return split_variable(variable)[0] == "q" and not factor


@dataclass(frozen=True, eq=False)
class Splines:
    """Filtered spline columns per recording, and the basis (M, m) on a grid `x` (M,) over the range."""

    columns: tuple[Columns, ...]
    x: Float
    basis: Float


def signal_of(one: PreparedRecording, now: FittedModel, variable: str, joint: int, factor: str = "") -> Float:
    """Return a variable (N,) along the motion of a recording; its size where a curve in it turns with the motion."""
    motion = one.motion
    if variable == "t":
        return motion.t - motion.t[0]
    if variable == "load":
        return own_torques(now, one)[f"tau_rigid{joint + 1}"]
    stem, index = split_variable(variable)
    signal = {"q": motion.q, "dq": motion.dq, "ddq": motion.ddq}[stem][:, index]
    return np.abs(signal) if factor == "sign" and stem == "dq" else signal


_KEPT: WeakKeyDictionary[Prepared, dict[tuple[str, int, str, int], Splines | None]] = WeakKeyDictionary()
"""Splines on recordings that are still in use: a search asks for the same ones against every model."""


def splines_along(now: FittedModel, variable: str, joint: int, factor: str, knots: int) -> Splines | None:
    """Return splines over the range of `variable` on the training motion; None where it does not vary or apply."""
    if variable == "load":  # that of the model at its numbers
        return _made(now, variable, joint, factor, knots)
    kept, key = _KEPT.setdefault(now.prepared, {}), (variable, joint, factor, knots)
    if key not in kept:
        kept[key] = _made(now, variable, joint, factor, knots)
    return kept[key]


def _made(now: FittedModel, variable: str, joint: int, factor: str, knots: int) -> Splines | None:
    if factor and variable.startswith("dq") and variable != f"dq{joint + 1}":
        return None  # the direction is that of the joint itself
    prepared = now.prepared.all
    if variable in ("load", f"ddq{joint + 1}") and not any(p.driven[joint] for p in prepared):
        return None  # where no drive acts, both are made by whatever is missing: it would explain itself
    signals = [signal_of(p, now, variable, joint, factor) for p in prepared]
    train = np.concatenate(signals[: len(now.prepared.train)])
    low, high = np.quantile(train, (0.002, 0.998))
    if not high - low > 1e-9:
        return None
    order = 3
    levels = np.linspace(0.0, 1.0, knots - order + 1)
    # Half even, half where the motion is: what happens near standstill is narrow, and much time is spent there.
    inner = 0.5 * (low + levels * (high - low)) + 0.5 * np.quantile(np.clip(train, low, high), levels)
    inner[[0, -1]] = low, high  # exactly, or rounding leaves samples outside
    positions = np.concatenate([[low] * order, inner, [high] * order])

    def design(x: Float) -> Float:
        return spline_columns(np.clip(x, low, high), positions, order)

    out = []
    for recording, signal in zip(prepared, signals, strict=True):
        raw = design(signal)
        if factor:
            raw = raw * (recording.motion.sign if factor == "sign" else recording.motion.dq)[:, [joint]]
        out.append(Columns((joint,), recording.smooth_columns(raw[None], (joint,))[None]))
    grid = np.linspace(low, high, 121)
    return Splines(tuple(out), grid, design(grid))


def spline_columns(x: Float, knots: Float, order: int = 3) -> Float:
    """Return the B-splines (N, M) of degree `order` over `knots` (M + order + 1,) at `x` (N,), which lies within the
    inner ones (de Boor 1972). SciPy's are the check on them in the tests; importing them takes 0.3 s.
    """
    count = len(knots) - order - 1
    last = np.clip(np.searchsorted(knots, x, side="right") - 1, order, count - 1)
    # Only order + 1 of them are not zero at a place; each degree follows from the one below.
    parts = [np.ones(len(x))]
    for degree in range(1, order + 1):
        right = [knots[last + 1 + k] - x for k in range(degree)]
        left = [x - knots[last - k] for k in range(degree)]
        shares = [part / (right[k] + left[degree - 1 - k]) for k, part in enumerate(parts)]
        rising = [left[degree - 1 - k] * share for k, share in enumerate(shares)]
        falling = [right[k] * share for k, share in enumerate(shares)]
        parts = [a + b for a, b in zip([*falling, np.zeros(len(x))], [np.zeros(len(x)), *rising], strict=True)]
    out = np.zeros((len(x), count))
    out[np.arange(len(x))[:, None], last[:, None] - order + np.arange(order + 1)] = np.stack(parts, axis=1)
    return out
