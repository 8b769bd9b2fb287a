"""Non-negative least squares, against SciPy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls

from exoid.ground.non_negative import non_negative


@given(
    rows=st.integers(1, 30),
    width=st.integers(1, 20),
    seed=st.integers(0, 2**32 - 1),
    spread=st.floats(0.0, 4.0),
    alike=st.floats(0.0, 1e3),
)
def test_no_distance_is_longer_than_scipys(rows, width, seed, spread, alike):
    rng = np.random.default_rng(seed)
    columns = rng.standard_normal((rows, width)) + alike * rng.standard_normal((rows, 1))
    columns *= 10.0 ** rng.uniform(-spread, spread, width) * (rng.random(width) < 0.9)
    side = rng.standard_normal(rows)
    x, left = non_negative(columns, side)
    assert np.all(x >= 0.0)
    assert left == pytest.approx(np.linalg.norm(columns @ x - side), abs=1e-9)
    assert left == pytest.approx(nnls(columns, side, maxiter=100 * width)[1], rel=1e-7, abs=1e-8)


def test_nothing_is_explained_by_no_columns_or_by_such_as_point_away():
    side = np.array([3.0, -4.0])
    assert non_negative(np.zeros((2, 0)), side)[1] == pytest.approx(5.0)
    x, left = non_negative(-side[:, None], side)
    assert x == pytest.approx([0.0]) and left == pytest.approx(5.0)
