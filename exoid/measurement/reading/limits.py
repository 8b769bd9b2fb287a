"""Limits of every format, and of samples that come live: how large a number may be, how much a recording may take, held
to before anything is allocated, and how a file is refused that is damaged or needs a package.

What a file claims costs nothing: a few kilobytes can stand for any number of cells. So every reader adds up what it is
going to unpack, and asks first.
"""

from __future__ import annotations

import io
import os
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from exoid.ground.errors import RecordingError, refused
from exoid.symbolic.motion import Float

ABSURD = 1e12
"""No quantity of a leg in any of its units comes near; larger numbers are treated like infinity."""
LATEST = 1e19
"""The same for times: nanoseconds since 1970 have eighteen digits."""
FASTEST = 1000.0
"""rad/s (m/s) by which no joint moves from one sample to the next: motor shafts turn at a few hundred."""
LASTING = 0.03
"""Part of that by which it goes on while samples are missing: a wrong angle that stays is not soon believed."""
MOST_BYTES = 2_000_000_000
"""Of one recording, as its numbers lie in memory: five columns of fifty million samples."""
MOST_ENTRIES = 100_000
"""Variables, datasets or columns of one file."""
TEXT = 64
"""Bytes that a cell of text takes at least."""


def credible(values: Float, *, time: bool = False) -> np.ndarray:
    """Return a mask of the numbers that can have been measured: finite, and no larger than any in its unit."""
    return np.asarray(np.abs(values) <= (LATEST if time else ABSURD))


@dataclass(eq=False)
class Budget:
    """The rest of `MOST_BYTES` while the file `where` is read."""

    where: str
    used: int = 0
    entries: int = 0

    def take(self, size: float, what: str = "the recording") -> None:
        """Ask for `size` bytes more; RecordingError where that is too many, and nothing has been allocated yet."""
        self.used += int(min(max(size, 0), 10**18))
        if self.used > MOST_BYTES:
            raise RecordingError(
                f"{what} would take {self.used / 1e9:.3g} GB of memory; {MOST_BYTES / 1e9:g} GB is the most",
                where=self.where,
                remedy="cut it into shorter recordings, or record at a lower rate",
            )

    def count(self, number: int = 1) -> None:
        """Count entries; RecordingError where there are too many."""
        self.entries += number
        if self.entries > MOST_ENTRIES:
            what = f"the file holds more than {MOST_ENTRIES} entries"
            raise RecordingError(what, where=self.where, remedy="export the channels alone")


class Within(io.BufferedReader):
    """A file from which no more is asked for than it holds: readers make room for as many bytes as the file claims."""

    def __init__(self, path: Path) -> None:
        super().__init__(io.FileIO(path))
        self.size = os.fstat(self.fileno()).st_size

    def read(self, size: int | None = -1) -> bytes:
        """Return at most `size` bytes, all that are left where it is None or negative."""
        left = max(0, self.size - self.tell())
        return super().read(left if size is None or size < 0 else min(size, left))


def damaged(
    what: str, path: Path, causes: tuple[type[BaseException], ...], remedy: str = "copy or save it again"
) -> AbstractContextManager[None]:
    """Refuse a file as damaged where one of `causes` is raised inside."""
    return refused(RecordingError, f"the {what} is damaged or incomplete ({{}})", path, remedy, causes)
