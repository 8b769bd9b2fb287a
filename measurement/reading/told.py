"""What a user tells of one recording beside its file: columns, conventions, files to join, drives and known masses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ground.progress import Progress
from measurement.reading.mapping import StatedMapping
from measurement.reading.read import read_recordings
from measurement.recording import Recording
from symbolic.joints import Joint
from symbolic.mechanics.payload import Payload


@dataclass(frozen=True)
class Told:
    """What is told of a file: its `columns`, its `convention` ("a,b"), files to `join` to it with the lag in s of their
    clocks (None: physics says), its `passive` joints, which have no drive, and `payloads`, known masses on it.
    """

    columns: StatedMapping = field(default_factory=StatedMapping)
    convention: str = ""
    join: tuple[tuple[str, float | None], ...] = ()
    passive: tuple[str, ...] = ()
    payloads: tuple[Payload, ...] = ()

    @property
    def options(self) -> dict[str, Any]:
        """What `read_recordings` takes of it, as far as it is said."""
        every = {**vars(self.columns), "convention": self.convention, "join": list(self.join)}
        return {name: value for name, value in every.items() if value}

    def read(
        self, path: str | Path, joints: Sequence[Joint] | None = None, progress: Progress | None = None
    ) -> tuple[Recording, ...]:
        """Return the recordings in a file, read as told; errors are those of `read_recordings`."""
        found = read_recordings([path], **self.options, joints=joints, progress=progress)
        for load in self.payloads:
            found = tuple(one.with_payload(load.mass, load.along, load.link) for one in found)
        return tuple(one.with_passive(*self.passive) for one in found)
