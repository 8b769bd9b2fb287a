"""Common parts of checks: channels with their labels, the words for a place, runs of equal rows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.thresholds import Threshold
from exoid.measurement.finding import row_ranges
from exoid.measurement.reading.angles import sampled
from exoid.measurement.recording import Recording, force_unit
from exoid.symbolic.joints import Joint
from exoid.symbolic.motion import Float

FORCE = "force"
"""Key of all forces from outside together."""
NOTHING: Threshold = 0.08
"""middle 80 % of a torque, of the other's: a light knee would be said to read next to nothing"""
WORDS = {
    "q": ("angle", "position"),
    "dq": ("velocity", "velocity"),
    "ddq": ("acceleration", "acceleration"),
    "tau": ("torque", "force"),
}
"""What a quantity is called where a joint turns, and where it slides."""


@dataclass(frozen=True, eq=False)
class Channel:
    """The valid samples of one column of `joint`: `values` (V,), their indices `at` (V,) in the recording, words.

    A force from `outside` belongs to no joint; it has the last one.
    """

    name: str
    label: str
    unit: str
    values: Float
    at: NDArray[np.int64]
    joint: Joint
    outside: bool = False

    @property
    def some(self) -> Float:
        """Some of the values (W,), evenly spread and enough for a quantile."""
        return sampled(self.values)

    @property
    def largest(self) -> float:
        """Distance of the values from zero, but for the largest fiftieth; 0 without any."""
        return float(np.percentile(np.abs(self.some), 98)) if self.values.size else 0.0

    def span(self, rest: float) -> float:
        """Range of the values but for `rest` percent of them at either end; 0 without any."""
        return float(np.ptp(np.percentile(self.some, [rest, 100 - rest]))) if self.values.size else 0.0


def channels(recording: Recording, *keys: str) -> Iterator[Channel]:
    """Yield the channels of the quantities `keys` ("q", "tau", ...; FORCE for all from outside) that the recording has,
    valid samples only.
    """
    valid = {"q": recording.angle_valid.T, "tau": recording.torque_valid.T}
    for key, values in recording.quantities.items():
        for j, joint in enumerate(recording.joints if key in keys else ()):
            at = np.flatnonzero(valid[key][j] if key in valid else recording.valid)
            own = values[:, j] if at.size == len(recording) else values[at, j]
            yield Channel(
                f"{key}{j + 1}", f"{joint.name} {WORDS[key][not joint.turns]}", joint.unit(key), own, at, joint
            )
    for name, signal in recording.forces.items() if FORCE in keys else ():
        at = np.flatnonzero(recording.valid)
        yield Channel(name, f"force in {name}", force_unit(name), signal[at], at, recording.joints[-1], outside=True)


def torque_spans(recording: Recording) -> list[float]:
    """Return the middle 80 % of every joint's torque; what is below NOTHING of the largest reads next to nothing."""
    return [torque.span(10) for torque in channels(recording, "tau")]


def place(recording: Recording, column: str = "", at: NDArray[Any] | None = None) -> str:
    """Return "file, column q1, rows 12-15"; `at` are indices into the recording."""
    rows = "" if at is None else row_ranges(np.sort(recording.row[at]))
    return ", ".join(filter(None, (recording.source.path or recording.name, column and f"column {column}", rows)))


def place_of_all(recordings: Sequence[Recording]) -> str:
    """Place of what is said of recordings together: the file of the only one, or how many they are."""
    return place(recordings[0]) if len(recordings) == 1 else f"{len(recordings)} recordings together"


def step_of(values: Float) -> float:
    """Return the grid step of `values` (V,), 0 when they do not lie on a grid."""
    levels = np.unique(values)
    if levels.size < 3:
        return 0.0
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-6 * gaps.max()]
    step = float(np.median(gaps[gaps < 1.5 * gaps.min()]))
    multiples = gaps / step
    on_grid = np.abs(multiples - np.round(multiples)) < 0.05 * np.maximum(1.0, np.sqrt(multiples))
    return step if on_grid.mean() > 0.95 else 0.0


def runs(same: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return first and last index (inclusive) of every stretch of True in `same` (N,)."""
    edges = np.diff(np.r_[0, same.astype(np.int8), 0])
    return np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
