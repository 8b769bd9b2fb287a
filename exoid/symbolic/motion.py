"""A motion of the machine: what every regressor is evaluated on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

STEP = 1e-4
"""rad or m, or these per s or s², to either side for a derivative by a state of a joint."""


def read_only(array: object) -> Float:
    """Return `array` as float64 that refuses to be written to: a copy, or the same array where nobody can."""
    if isinstance(array, np.ndarray) and array.dtype == float and array.base is None and not array.flags.writeable:
        return array
    out = np.array(array, dtype=float)
    out.setflags(write=False)
    return out


@dataclass(frozen=True, eq=False)
class Motion:
    """Time stamps `t` (N,) in s and, per joint, `q`, `dq`, `ddq` (N, J) in rad, rad/s, rad/s² (m where it slides).

    `sign` (N, J) is sgn(dq) unless given: near standstill a measured velocity is noise, and whoever
    prepares a measurement knows how much of the sign can be believed. `payload` (4,) is what known masses
    that hung on the leg add to Φ1..Φ4 in kg·m² (`exoid.symbolic.mechanics.payload`), None where there were none. `base`
    (N, 5) is how a measured base moves: angle rad, its derivatives, acceleration forwards and upwards m/s²; in space
    (N, 12): three angles rad about fixed axes x, y, z, their derivatives, acceleration m/s². `force`
    (N, C) are measured external forces, in the order of the model's `channels`, N or N·m. `load` (N, J) N·m is a torque
    that the drives bear beside the model's own: it is no part of what the model says, but friction feels it.
    """

    t: Float
    q: Float
    dq: Float
    ddq: Float
    sign: Float = None  # type: ignore[assignment]
    payload: Float | None = None
    base: Float | None = None
    force: Float | None = None
    load: Float | None = None

    def __post_init__(self) -> None:
        sign = np.sign(self.dq) if self.sign is None else self.sign
        for name, value in (("t", self.t), ("q", self.q), ("dq", self.dq), ("ddq", self.ddq), ("sign", sign)):
            object.__setattr__(self, name, read_only(value))
        shape = (self.t.shape[0], self.q.shape[1] if self.q.ndim == 2 else 1)
        if self.payload is not None:
            object.__setattr__(self, "payload", read_only(self.payload))
        if self.base is not None:
            object.__setattr__(self, "base", read_only(self.base))
            if self.base.shape not in ((self.t.shape[0], 5), (self.t.shape[0], 12)):
                raise ValueError(f"motion.base has shape {self.base.shape}, expected {(self.t.shape[0], 5)}")
        if self.force is not None:
            object.__setattr__(self, "force", read_only(self.force))
            if self.force.ndim != 2 or len(self.force) != shape[0]:
                raise ValueError(f"motion.force has shape {self.force.shape}, expected ({shape[0]}, C)")
        if self.load is not None:
            object.__setattr__(self, "load", read_only(self.load))
        for name in ("q", "dq", "ddq", "sign", *(["load"] if self.load is not None else [])):
            if getattr(self, name).shape != shape:
                raise ValueError(f"motion.{name} has shape {getattr(self, name).shape}, expected {shape}")

    def __len__(self) -> int:
        return int(self.t.shape[0])

    def __getstate__(self) -> dict[str, object]:
        """Its fields: what was computed from that is computed anew in another process."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def words(self) -> Mapping[str, Float]:
        """The words (N,) that a torque text uses for it: t, theta1, dtheta1, ddtheta1, theta2, ..."""
        signals = (("theta", self.q), ("dtheta", self.dq), ("ddtheta", self.ddq))
        return {"t": self.t} | {key: row for stem, signal in signals for key, row in _by_joint(stem, signal).items()}

    @cached_property
    def signs(self) -> Mapping[str, Float]:
        """The sign signal (N,) of each word for a joint's velocity."""
        return _by_joint("dtheta", self.sign)


def slope_by(of: Callable[[Motion], Float], motion: Motion, state: str, joint: int) -> Float:
    """Derivative of what `of` gives for a motion by the angle, velocity or acceleration (`state`) of a joint."""
    values, only = getattr(motion, state), STEP * np.eye(motion.q.shape[1])[joint]
    above, below = (of(replace(motion, **{state: values + way * only})) for way in (1.0, -1.0))
    return (above - below) / (2.0 * STEP)


def _by_joint(stem: str, signal: Float) -> dict[str, Float]:
    """Return {word: row (N,)} of a signal (N, J)."""
    return {f"{stem}{j + 1}": row for j, row in enumerate(np.ascontiguousarray(signal.T))}
