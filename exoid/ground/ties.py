"""The best of several, the same on every processor: what differs by rounding alone is a tie.

Sums of the same numbers differ in their last digits with the processor, the number of threads and the version of a
library. Where two of several things are the same physics (a torque negated, or an angle), or differ in nothing that was
recorded (a stop that was never met), those digits would choose. So what lies within `TIED` of the best is as good, and
of all that is as good the first is taken: whoever asks gives a fixed order, the plainest first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

T = TypeVar("T")
TIED = 1e-9
"""Relative difference up to which two are equally good. Another processor changes what a fit leaves by 1e-15 to 1e-12
of it and shares of the error by 1e-14, inputs that differ by 1e-12 change them by 1e-11; nothing that is told from
recordings is told from so little."""
CONVERGED = 1e-6
"""The same for what iterations end at: they stop within some 1e-8 of the best there is, on either side."""


def tied(values: ArrayLike, scale: float = 0.0, within: float = TIED, axis: int = -1) -> NDArray[np.bool_]:
    """Mask of the `values` that are as small as the least along `axis`; NaN is larger than any number.

    `scale` is the size below which values are rounding: 1.0 for shares of a whole, 0.0 where it is their own.
    """
    known = np.asarray(values, dtype=float)
    known = np.where(np.isnan(known), np.inf, known)
    lowest = known.min(axis=axis, keepdims=True)
    room = np.where(np.isfinite(lowest), within * np.maximum(np.abs(lowest), scale), 0.0)
    return np.asarray(known <= lowest + room)


def index_of_least(values: ArrayLike, scale: float = 0.0, within: float = TIED) -> int:
    """Return the index of the first of `values` (N,) that is as small as the least."""
    return int(np.argmax(tied(values, scale, within)))


def index_of_greatest(values: ArrayLike, scale: float = 0.0, within: float = TIED) -> int:
    """Return the index of the first of `values` (N,) that is as large as the greatest; NaN is smaller than any."""
    return index_of_least(-np.asarray(values, dtype=float), scale, within)


def least_of(items: Iterable[T], value: Callable[[T], Any], scale: float = 0.0, within: float = TIED) -> T:
    """Return the first of `items` whose `value` is as small as the least; ValueError where there are none."""
    every = list(items)
    return every[index_of_least([value(item) for item in every], scale, within)]


def ascending(items: Iterable[T], value: Callable[[T], Any], scale: float = 0.0, within: float = TIED) -> list[T]:
    """Return `items` by their `value`, least first; those that tie in the order in which they were given."""
    every = list(items)
    return [every[k] for k in order_of([value(item) for item in every], scale, within)]


def order_of(values: ArrayLike, scale: float = 0.0, within: float = TIED) -> list[int]:
    """Return the indices of `values` (N,), least first; of the rest, those that tie with the least as they stand."""
    known = np.nan_to_num(np.asarray(values, dtype=float), nan=np.inf, posinf=np.inf, neginf=-np.inf)
    groups: list[list[int]] = []
    most = -np.inf
    for k in np.argsort(known, kind="stable").tolist():
        value = float(known[k])
        if not groups or value > most:
            groups.append([])
            most = value + within * max(abs(value), scale) if np.isfinite(value) else value
        groups[-1].append(k)
    return [k for group in groups for k in sorted(group)]
