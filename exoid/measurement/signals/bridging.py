"""Straight lines across the samples at which a joint sticks, so that what a filter sees there is no friction."""

from __future__ import annotations

from ctypes import byref, c_long, c_void_p
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from exoid.measurement.signals.compiled import POLES, BridgeInC, row_library
from exoid.symbolic.motion import Float

BRIDGE_ENDS = 0.03
"""Seconds beside a bridged run over which its ends are averaged."""


@dataclass(frozen=True, eq=False)
class Bridge:
    """A bridge of straight lines across the runs of `rows` (H,), hidden samples.

    Its ends are means over a few samples beside a run (`BRIDGE_ENDS` s): `beside` (E,) are these samples, one end after
    the other, `begins` (M,) where each end begins in them, `ends` (2, H) which end stands before and which behind a
    hidden sample, and `share` (H,) how much of the latter it takes.
    """

    rows: NDArray[np.int_]
    beside: NDArray[np.int_]
    begins: NDArray[np.int_]
    ends: NDArray[np.int_]
    share: Float

    def __reduce__(self) -> tuple[type[Bridge], tuple[object, ...]]:
        """Go to another process, or into a copy, without what only this one's memory has (`in_c`)."""
        return Bridge, (self.rows, self.beside, self.begins, self.ends, self.share)

    def across(self, x: Float) -> None:
        """Bridge `x` (..., N) in place. Being linear, this may be done to a torque and to the columns of its regressor
        alike, and what holds between them goes on to hold.
        """
        if self.means:
            if self._compiled(x):
                return
            level = np.add.reduceat(x[..., self.beside], self.begins, axis=-1) / self._sizes
            before, behind = level[..., self.ends[0]], level[..., self.ends[1]]
            behind -= before
            behind *= self.share
            before += behind
            x[..., self.rows] = before

    def _compiled(self, x: Float) -> bool:
        """Do it in C; False where that cannot be done."""
        library, rows = row_library(POLES), x.view()
        try:
            rows.shape = -1, x.shape[-1]
        except AttributeError:  # rows that do not lie evenly
            return False
        if library is None or x.dtype != np.float64 or rows.strides[1] != x.itemsize:
            return False
        level, counts = np.empty(self.means), (len(rows), rows.strides[0] // x.itemsize)
        data = (c_void_p(array.ctypes.data) for array in (level, rows))
        library.c.exoid_bridge(*map(c_long, counts), byref(self.in_c), *data)
        return True

    @property
    def means(self) -> int:
        """Number of ends; 0 where a joint sticks throughout, and nothing stands beside."""
        return self.begins.size if self.rows.size else 0

    @cached_property
    def in_c(self) -> BridgeInC:
        """The same for C, as long as this lives."""
        arrays = self.rows, self.ends, self._ends, self.beside, self.share
        hidden = self.rows.size if self.means else 0
        return BridgeInC(hidden, self.means, *(array.ctypes.data for array in arrays))

    @cached_property
    def _ends(self) -> NDArray[np.int_]:
        """The index at which each end begins in the samples beside, and that at which the last one ends, (M + 1,)."""
        return np.append(self.begins, self.beside.size)

    @cached_property
    def _sizes(self) -> NDArray[np.int_]:
        """Number of samples (M,) of each end."""
        return np.diff(self._ends)


def bridging(hidden: NDArray[np.bool_], rate: float) -> Bridge:
    """Return the bridge across every run of `hidden` (N,) samples. A run at an end of the recording gets the level of
    its other side.
    """
    edges = np.diff(np.concatenate([[False], hidden, [False]]).astype(int))
    first, last = np.flatnonzero(edges > 0), np.flatnonzero(edges < 0)
    most = max(1, int(BRIDGE_ENDS * rate))
    low = np.maximum(first - most, np.append(0, last)[: first.size])
    high = np.minimum(last + most, np.append(first, hidden.size)[1:])
    sizes = np.column_stack([first - low, high - last]).ravel()
    begins = np.cumsum(sizes) - sizes
    place = np.arange(sizes.sum()) - np.repeat(begins, sizes)
    beside = np.repeat(np.column_stack([low, last]).ravel(), sizes) + place
    there = sizes > 0
    number = np.cumsum(there) - 1
    before, behind = (number[k::2] for k in (0, 1))
    before, behind = np.where(there[0::2], before, behind), np.where(there[1::2], behind, before)
    run = np.repeat(np.arange(first.size), last - first)
    rows = np.flatnonzero(hidden)
    share = (rows - first[run] + 1.0) / (last[run] - first[run] + 1.0)
    return Bridge(rows, beside, begins[there], np.stack([before[run], behind[run]]), share)
