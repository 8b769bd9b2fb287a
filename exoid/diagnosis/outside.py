"""The measured forces of a model: where each acts, and how much of the torque of every joint it makes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.pushes import force_alone
from exoid.ground.plain import AsJson
from exoid.symbolic.force import FIXED, TORQUE, VERTICAL, WORLD, Force
from exoid.symbolic.joints import Vector
from exoid.symbolic.quantity import Estimate

FRAMES = {WORLD: "forwards and upwards", VERTICAL: "upwards"}
"""How the columns of a force are meant, in words; normal to its link otherwise."""


@dataclass(frozen=True)
class ForceUse(AsJson):
    """A measured force of the model: its `columns`, the `link` it acts on, where (`at` m, with its ends where that was
    identified), and the RMS (J,) of its torque in N·m, `share` (J,) of that of the whole torque.
    """

    name: str
    columns: tuple[str, ...]
    link: str
    frame: str
    at: float | Vector | None
    low: float | None
    high: float | None
    gain: float
    torque: tuple[float, ...]
    share: tuple[float, ...]
    sentence: str


def force_uses(now: FittedModel) -> tuple[ForceUse, ...]:
    """Measured forces of a fitted model and the torques they make, on unseen recordings where there are any."""
    return tuple(_use(force, now) for force in now.model.forces)


def acts_at(force: Force, estimates: Sequence[Estimate]) -> tuple[float, float, Estimate | None]:
    """Place in m along its link at which a force acts, 0 for one in space, which says it itself; its gain; and the
    estimate of the place where that was identified.
    """
    known = {estimate.name: estimate for estimate in estimates}
    gain, both, place = (known.get(f"{force.name}.{key}") for key in ("gain", "gain_at", "at"))
    size = force.gain if force.gain is not None else 1.0 if gain is None else gain.value
    if both is not None:
        return both.value / size if size else 0.0, size, None
    return (place.value if place is not None else force.along), size, place


def _use(force: Force, now: FittedModel) -> ForceUse:
    model, shown = now.model, now.prepared.verify or now.prepared.train
    at, gain, place = acts_at(force, now.fit.estimates)
    made = [np.where(item.used, force_alone(model, item, force, at, gain), 0.0) for item in shown]
    whole = [np.where(entry.used, entry.torque, 0.0) for entry in shown]
    size, all_of = (np.sqrt(np.mean(np.concatenate(part, axis=1) ** 2, axis=1)) for part in (made, whole))
    where = f"at the {force.link}" if force.frame == TORQUE else _where(force, at, place)
    parts = ", ".join(f"{joint} {x:.3g}" for joint, x in zip(model.joint_names, size, strict=True))
    text = f"{force.name} ({', '.join(force.columns)}): {where}; its torque is {parts}"
    return ForceUse(
        name=force.name,
        columns=force.columns,
        link=force.link,
        frame=force.frame,
        at=None if force.frame == TORQUE else force.placed.xyz if force.in_space else at,
        low=None if place is None else place.low,
        high=None if place is None else place.high,
        gain=gain,
        torque=tuple(size.tolist()),
        share=tuple((size / np.maximum(all_of, 1e-300)).tolist()),
        sentence=f"{text} {model.torque_unit} (RMS)",
    )


def _where(force: Force, at: float, place: Estimate | None) -> str:
    way = FRAMES.get(force.frame, "normal to the link")
    if force.in_space:
        x, y, z = force.placed.xyz
        axes = "those of the base" if force.frame == FIXED else "its sensor's"
        return f"along {axes} axes, at ({x:.3g}, {y:.3g}, {z:.3g}) m in the frame of {force.link}"
    ends = "" if place is None else f" ({place.low:.3g} to {place.high:.3g})"
    return f"{way}, {at:.3g} m{ends} along the link after the {force.link}"
