"""Least squares of numbers most of which cannot be negative."""

import numpy as np
import pytest

from exoid.measurement.auditing.power_left import some_non_negative


@pytest.mark.parametrize("seed", range(5))
def test_numbers_of_either_sign_are_found_beside_those_that_cannot_be_negative(seed):
    rng = np.random.default_rng(seed)
    y, tau = rng.standard_normal((60, 6)), rng.standard_normal(60)
    basis, root = np.linalg.qr(y)
    x, left = some_non_negative(root, basis.T @ tau, 2)
    slope = y.T @ (tau - y @ x)
    np.testing.assert_allclose(slope[:2], 0.0, atol=1e-9)
    assert np.all(x[2:] >= 0.0) and np.all(slope[2:] < 1e-9) and np.allclose(slope[2:] * x[2:], 0.0)
    assert np.sum((tau - y @ x) ** 2) == pytest.approx(left**2 + np.sum((tau - basis @ (basis.T @ tau)) ** 2))
