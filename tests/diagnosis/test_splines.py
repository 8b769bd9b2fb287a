"""B-splines against SciPy's."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from exoid.diagnosis.evidence.curves import spline_columns


@pytest.mark.parametrize("order", [1, 2, 3])
def test_splines_are_those_of_scipy(order: int) -> None:
    rng = np.random.default_rng(3)
    inner = np.sort(rng.uniform(-1.0, 2.0, 9))
    knots = np.concatenate([[inner[0]] * order, inner, [inner[-1]] * order])
    x = np.concatenate([inner, rng.uniform(inner[0], inner[-1], 200)])
    expected = BSpline.design_matrix(x, knots, order).toarray()
    np.testing.assert_allclose(spline_columns(x, knots, order), expected, atol=1e-14)
    np.testing.assert_allclose(spline_columns(x, knots, order).sum(axis=1), 1.0)
