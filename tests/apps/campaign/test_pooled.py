"""Numbers across devices: the mean, the spread between devices, and who stands out."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.apps.campaign.plan import Plan
from exoid.apps.campaign.pooled import Z, pool, pooled_mean

pytestmark = pytest.mark.slow  # the extra `campaign`, which CI installs for the slow tests
pytest.importorskip("statsmodels")
PLAN = Plan("p", "identify", (), ("device",), "device", None)


def row(device, value, sigma):
    numbers = {"value": value, "low": value - Z * sigma, "high": value + Z * sigma, "unit": "N·m"}
    return {"name": device, "fields": {"device": device}, "result": {"parameters": {"c": numbers}}}


def test_equal_devices_have_no_spread_and_the_mean_of_weighted_squares():
    mean, variance, tau2 = pooled_mean([(1.0, 0.04), (1.0, 0.01), (1.0, 0.01)])
    assert mean == pytest.approx(1.0) and tau2 == pytest.approx(0.0, abs=1e-9)
    assert variance == pytest.approx(1.0 / (25 + 100 + 100))


def test_spread_and_coverage_of_the_mean():
    rng = np.random.default_rng(0)
    inside, spreads = 0, []
    for _ in range(200):
        rows = [row(f"d{k}", 3.0 + rng.normal(0, 0.5) + rng.normal(0, 0.2), 0.2) for k in range(12)]
        (one,) = pool(PLAN, rows)
        inside += one.low <= 3.0 <= one.high
        spreads.append(one.spread)
    assert 0.85 <= inside / 200 <= 0.99
    assert np.median(spreads) == pytest.approx(0.5, rel=0.15)


def test_a_device_far_from_the_others_stands_out_and_no_other():
    rng = np.random.default_rng(1)
    rows = [row(f"d{k}", 3.0 + 0.1 * rng.normal(), 0.05) for k in range(8)] + [row("odd", 5.0, 0.05)]
    (one,) = pool(PLAN, rows)
    assert [o.device for o in one.outliers] == ["odd"] and one.outliers[0].p < 0.01


def test_false_outliers_are_rare():
    rng = np.random.default_rng(2)
    found = [pool(PLAN, [row(f"d{k}", rng.normal(0, 0.3), 0.1) for k in range(8)])[0].outliers for _ in range(200)]
    assert sum(bool(one) for one in found) <= 20


def test_several_sessions_of_a_device_count_as_one_device():
    rows = [row("a", 1.0, 0.1)] * 5 + [row("b", 2.0, 0.1), row("c", 3.0, 0.1)]
    (one,) = pool(PLAN, rows)
    assert one.devices == 3 and one.mean == pytest.approx(2.0, abs=0.02)


def test_two_devices_or_unusable_intervals_are_not_pooled():
    assert pool(PLAN, [row("a", 1.0, 0.1), row("b", 1.0, 0.1)]) == []
    assert pool(PLAN, [row(d, 1.0, float("nan")) for d in "abc"]) == []


def test_a_device_of_known_uncertainty_stands_out_among_few():
    """Three devices agree within what they report; the fourth is eight of its own standard errors away."""
    rows = [row("d1", 3.01, 0.02), row("d2", 3.02, 0.016), row("d3", 4.18, 0.14), row("d4", 2.99, 0.016)]
    (one,) = pool(PLAN, rows)
    assert [o.device for o in one.outliers] == ["d3"]
