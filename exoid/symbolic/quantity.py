"""A number that never travels without its unit and its interval."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from exoid.ground.plain import AsJson

JOINTS = ("hip", "knee")
"""Joint names in the order of every axis of length J = 2."""


@dataclass(frozen=True)
class Estimate(AsJson):
    """An estimated parameter: `value` in `unit`, with the 95 % interval [`low`, `high`]."""

    name: str
    value: float
    unit: str
    low: float
    high: float

    @property
    def is_unknown(self) -> bool:
        """True if any value would do."""
        return self.low == -math.inf and self.high == math.inf

    def __str__(self) -> str:
        return f"{self.name} = {self.value:.4g} {self.unit} (95 %: {self.low:.4g} to {self.high:.4g})"

    def _json(self) -> dict[str, Any]:
        return {"value": self.value, "unit": self.unit, "low": self.low, "high": self.high}
