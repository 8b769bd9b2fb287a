"""The minimum of a function of one number between two bounds.

Brent's method as Forsythe, Malcolm and Moler (Computer Methods for Mathematical Computations, 1977) give it, and SciPy
has it: `minimize_scalar(method="bounded")` is the check on it in the tests. Importing `scipy.optimize` takes 0.3 s, and
`discover` 1.4 s in all on the demo's recordings, by one process.
"""

from __future__ import annotations

import math
from collections.abc import Callable

GOLDEN = 0.5 * (3.0 - math.sqrt(5.0))
ROUNDING = math.sqrt(2.2e-16)
MOST_EVALUATIONS = 500
"""Evaluations at most."""


def minimum(function: Callable[[float], float], low: float, high: float, tolerance: float) -> tuple[float, float]:
    """Lowest point of a valley of `function` between `low` and `high`, to within `tolerance`, and its value."""
    best = second = third = low + GOLDEN * (high - low)
    value = value2 = value3 = function(best)
    step = before = 0.0
    for _ in range(MOST_EVALUATIONS):
        middle = 0.5 * (low + high)
        least = ROUNDING * abs(best) + tolerance / 3.0
        if abs(best - middle) <= 2.0 * least - 0.5 * (high - low):
            break
        parabola = False
        if abs(before) > least:
            r = (best - second) * (value - value3)
            q = (best - third) * (value - value2)
            p = (best - third) * q - (best - second) * r
            q = 2.0 * (q - r)
            p, q = (-p, q) if q > 0.0 else (p, -q)
            last, before = before, step
            parabola = abs(p) < abs(0.5 * q * last) and q * (low - best) < p < q * (high - best)
            if parabola:
                step = p / q
                if min(best + step - low, high - best - step) < 2.0 * least:
                    step = math.copysign(least, middle - best)
        if not parabola:
            before = (low if best >= middle else high) - best
            step = GOLDEN * before
        at = best + math.copysign(max(abs(step), least), step)
        found = function(at)
        if found <= value:
            low, high = (best, high) if at >= best else (low, best)
            third, value3, second, value2, best, value = second, value2, best, value, at, found
        else:
            low, high = (at, high) if at < best else (low, at)
            if found <= value2 or second == best:
                third, value3, second, value2 = second, value2, at, found
            elif found <= value3 or third in (best, second):
                third, value3 = at, found
    return best, value
