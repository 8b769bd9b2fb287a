"""Settings of the design of a motion that distinguishes rivals."""

from __future__ import annotations

from dataclasses import dataclass

from exoid.ground.settings import setting
from exoid.optimisation.excitation.settings import OFFSETS, MotionOptions, MotionSettings


class SeparationOptions(MotionOptions, total=False):
    """`SeparationSettings` as keywords."""

    cutoff: float | None


@dataclass(frozen=True, kw_only=True)
class SeparationSettings(MotionSettings):
    """A motion that distinguishes rivals."""

    offsets: str = setting("free", "where the motion is centred: paper, middle or free", choices=OFFSETS)
    generations: int = setting(40, "generations of NFO", 0, 100_000)
    cutoff: float | None = setting(None, "Hz of the filter; without it, chosen from the recordings")
