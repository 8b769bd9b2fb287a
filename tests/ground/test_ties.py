"""The best of several: what differs by rounding alone is a tie, and of a tie the first is taken."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exoid.ground.ties import TIED, ascending, index_of_greatest, index_of_least, least_of, order_of, tied

NUMBERS = st.lists(st.floats(-1e6, 1e6, allow_nan=False), min_size=1, max_size=12)


def test_of_what_differs_by_rounding_the_first_is_best():
    assert index_of_least([0.3, 0.1 + 0.2]) == index_of_least([0.1 + 0.2, 0.3]) == 0
    assert index_of_greatest([2.0, 1.0 + 1e-13, 2.0 + 1e-13]) == 0
    assert least_of(["torque", "angle"], {"torque": 2.6e-4 + 1e-18, "angle": 2.6e-4}.__getitem__) == "torque"


def test_what_differs_by_more_is_no_tie():
    assert index_of_least([1.0, 1.0 - 1e-6]) == 1
    assert order_of([3.0, 1.0, 2.0]) == [1, 2, 0]


def test_what_is_rounding_of_a_whole_is_a_tie():
    assert index_of_least([3e-17, 1e-17]) == 1
    assert index_of_least([3e-17, 1e-17], scale=1.0) == 0


def test_ties_keep_the_order_they_were_given_in():
    assert order_of([2.0 + 1e-12, 1.0, 2.0, 1.0 - 1e-13]) == [1, 3, 0, 2]
    assert ascending("dcba", {"a": 1.0, "b": 1.0 - 1e-14, "c": 0.5, "d": 1.0}.__getitem__) == ["c", "d", "b", "a"]


def test_nothing_and_the_infinite_have_their_place():
    assert index_of_least([np.nan, np.inf, 2.0]) == 2
    assert index_of_least([np.nan, np.inf]) == 0
    assert index_of_least([1.0, -np.inf]) == 1
    assert index_of_greatest([np.nan, -np.inf, 2.0]) == 2
    assert order_of([np.inf, 1.0, np.nan, 0.0]) == [3, 1, 0, 2]
    assert order_of([]) == []
    with pytest.raises(ValueError):
        least_of([], abs)


def test_along_an_axis_each_has_its_own():
    assert tied([[1.0, 1.0 + 1e-12, 2.0], [5.0, 4.0, 4.0]]).tolist() == [[True, True, False], [False, True, True]]


@given(NUMBERS)
def test_rounding_changes_no_order(values):
    """The same numbers as another processor sums them."""
    apart = np.unique(np.round(values, 3))
    once = np.random.default_rng(0).permutation(np.concatenate([apart, apart]))
    for seed in range(3):
        again = once * (1.0 + 1e-3 * TIED * np.random.default_rng(seed).uniform(-1.0, 1.0, once.size))
        assert order_of(again) == order_of(once)
        assert index_of_least(again) == index_of_least(once) == order_of(once)[0]
        assert index_of_greatest(again) == index_of_greatest(once)
