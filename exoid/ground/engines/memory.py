"""Memory that was freed is used again, instead of being fetched from the system and handed back for every array.

glibc gives each block beyond 128 kB back to the system as soon as it is freed, until it has seen a larger one freed:
from then on blocks up to that size are kept for the next (mallopt(3), dynamic threshold; at most 32 MiB). A search
makes thousands of arrays of some 100 kB, and every page that comes anew costs microseconds. So one large block is
asked for and freed, untouched. Other allocators take no notice.
"""

from __future__ import annotations

import numpy as np

BLOCK = 31 << 20
"""Bytes of the block: just below the most that glibc learns from."""


def reuse_freed_memory() -> None:
    """Have blocks of memory up to `BLOCK` bytes used again once they are freed."""
    np.empty(BLOCK, dtype=np.uint8)
