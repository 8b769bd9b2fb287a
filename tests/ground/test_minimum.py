"""The minimum of a function of one number, against SciPy's."""

from __future__ import annotations

import math

import pytest
from scipy.optimize import minimize_scalar

from exoid.ground.minimum import minimum

FUNCTIONS = {
    "parabola": lambda x: (x - 0.3) ** 2,
    "edge": lambda x: math.exp(x),
    "kink": lambda x: abs(x - 0.123),
    "valleys": lambda x: math.sin(9.0 * x) + 0.1 * x,
    "flat": lambda x: 1.0,
    "beyond": lambda x: math.inf if x < 0.1 else x * x,
}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-7])
def test_it_is_that_of_scipy(name: str, tolerance: float) -> None:
    found = minimum(FUNCTIONS[name], -1.0, 2.0, tolerance)
    options = {"xatol": tolerance}
    expected = minimize_scalar(FUNCTIONS[name], bounds=(-1.0, 2.0), method="bounded", options=options)
    assert found == pytest.approx((expected.x, expected.fun), abs=1e-9)
