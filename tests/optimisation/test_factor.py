"""A factor that is brought up to date is the factor that is made anew."""

from __future__ import annotations

import numpy as np

from exoid.optimisation.linear.factor import Factors, factorise


def test_columns_that_change_give_the_same_factor() -> None:
    rng = np.random.default_rng(5)
    matrix = rng.normal(size=(300, 8)) * 10.0 ** rng.uniform(-3, 3, 8)
    remembered = Factors()
    for step in range(5):
        matrix = matrix.copy()
        if step == 3:
            matrix[:, 2] = 0.0  # nothing excites it
        elif step == 4:
            matrix[:, [2, 5]] = matrix[:, [1, 7]] * [3.0, 1.0]  # dependent on columns that stay
        elif step:
            matrix[:, [2, 5]] = rng.normal(size=(300, 2))
        found, anew = remembered(matrix), factorise(matrix)
        assert found.rank == anew.rank
        assert (found.undetermined, found.unexcited) == (anew.undetermined, anew.unexcited)
        np.testing.assert_allclose(found.basis @ found.forward, matrix, atol=1e-12 * np.abs(matrix).max())
        np.testing.assert_allclose(found.basis.T @ found.basis, np.eye(found.rank), atol=1e-12)
        np.testing.assert_allclose(found.backward @ found.forward, anew.backward @ anew.forward, atol=1e-6)
        if np.isfinite(anew.condition):
            assert np.isclose(found.condition, anew.condition, rtol=1e-6)
