"""Non-negative least squares against SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from exoid.measurement.auditing.non_negative import non_negative


@pytest.mark.parametrize("seed", range(30))
def test_it_is_the_answer_of_scipy(seed):
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(40, 8)) @ np.diag(10.0 ** rng.uniform(-4, 4, 8))
    matrix[:, seed % 8] = 0.0 if seed % 3 else matrix[:, 0]
    target = matrix @ rng.normal(size=8) + rng.normal(size=40)
    _, left = nnls(matrix, target)
    found = non_negative(matrix.T @ matrix, matrix.T @ target)
    assert found.min() >= 0.0
    assert np.linalg.norm(target - matrix @ found) == pytest.approx(left, rel=1e-9)
