"""A further column of a recording that says in what state the machine was, such as a motor's temperature."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exoid.symbolic.motion import Float, read_only


@dataclass(frozen=True, eq=False)
class Logged:
    """A column that changes slowly: its means `values` (M,) over about a second each, at the times `t` (M,) s of the
    recording, in `unit`; `noise` is what it varies within such a second.
    """

    t: Float
    values: Float
    unit: str
    noise: float

    def __post_init__(self) -> None:
        for name in ("t", "values"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    def at(self, t: Float) -> Float:
        """Values (N,) at the times `t` (N,) s."""
        return np.interp(t, self.t, self.values)
