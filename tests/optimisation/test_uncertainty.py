"""Intervals that hold what they promise when neighbouring samples resemble each other."""

from __future__ import annotations

import numpy as np
import pytest
from paper_leg import NAMES, PAPER, UNITS, Leg, paper_motion

from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.solve import delta_rule, solve_huber, solve_sse
from exoid.optimisation.linear.uncertainty import block_length, block_outer, covariance

INFINITE = np.full(2, np.inf)


def ar1(rng, rho, shape):
    from scipy.signal import lfilter

    noise = rng.normal(size=(*shape[:-1], shape[-1] + 300))
    return lfilter([1.0], [1.0, -rho], noise, axis=-1)[..., 300:]


def covered(rho, recordings, samples, robust, repetitions):
    """Return the share of 95 % intervals that contain the truth (P,), and that of textbook intervals."""
    columns = np.concatenate([Leg().columns(paper_motion(samples, late=7.3 * r)) for r in range(recordings)], axis=1)
    groups = np.repeat(np.arange(recordings), samples)
    rng = np.random.default_rng(11)
    inverse = np.linalg.inv(columns.reshape(-1, 8).T @ columns.reshape(-1, 8))
    hits, textbook = np.zeros(8), np.zeros(8)
    for _ in range(repetitions):
        noise = np.concatenate([ar1(rng, rho, (2, samples)) for _ in range(recordings)], axis=1)
        data = LinearData(columns, columns @ PAPER + noise, groups, NAMES, UNITS)
        linear, delta = solve_sse(data), INFINITE
        if robust:
            delta = delta_rule(data.residual(linear))
            linear = solve_huber(data, delta, linear)
        spread = covariance(columns, data.residual(linear), delta, groups, factor=data.factor)
        miss = np.abs(linear - PAPER)
        hits += miss <= spread.half_widths()
        textbook += miss <= 1.96 * np.sqrt(np.diag(inverse) * np.var(data.residual(linear)))
    return hits / repetitions, textbook / repetitions


def test_block_sums_are_newey_west():
    rng = np.random.default_rng(0)
    score, groups, lag = rng.normal(size=(50, 3)), np.repeat([0, 1], [30, 20]), 7
    expected = np.zeros((3, 3))
    for group in (0, 1):
        own = score[groups == group]
        for gap in range(-lag + 1, lag):
            early, late = (own[: len(own) - gap], own[gap:]) if gap >= 0 else (own[-gap:], own[:gap])
            expected += (1.0 - abs(gap) / lag) * early.T @ late
    assert np.allclose(block_outer(score, groups, lag), expected)


def test_blocks_grow_with_autocorrelation():
    rng = np.random.default_rng(0)
    groups = np.zeros(3000, dtype=int)
    lengths = [block_length(ar1(rng, rho, (2, 3000)).T, groups) for rho in (0.0, 0.9, 0.97)]
    assert lengths[0] < lengths[1] < lengths[2] <= 750


def test_white_noise_gives_the_textbook_interval():
    columns = Leg().columns(paper_motion(3000))
    noise = np.random.default_rng(2).normal(size=columns.shape[:2])
    data = LinearData(columns, noise, np.zeros(3000, int), NAMES, UNITS)
    spread = covariance(columns, data.residual(solve_sse(data)), INFINITE, data.groups)
    textbook = np.sqrt(np.diag(np.linalg.inv(data.matrix.T @ data.matrix)))
    assert np.all(np.abs(np.log(np.sqrt(np.diag(spread.matrix)) / textbook)) < 0.7)
    assert 1.96 < spread.critical < 2.2


def test_a_parameter_nothing_excites_has_no_interval():
    columns = Leg().columns(paper_motion(500)).copy()
    columns[:, :, 3] = 0.0
    noise = np.random.default_rng(2).normal(size=columns.shape[:2])
    half = covariance(columns, noise, INFINITE, np.zeros(500, int)).half_widths()
    assert half[3] == np.inf
    assert np.isfinite(np.delete(half, 3)).all()


def test_coverage_in_short():
    ours, textbook = covered(0.93, 2, 700, robust=False, repetitions=40)
    assert ours.mean() > 0.88
    assert textbook.mean() < 0.70


@pytest.mark.slow
@pytest.mark.parametrize("robust", [False, True])
@pytest.mark.parametrize(("rho", "recordings", "samples"), [(0.0, 1, 3500), (0.93, 3, 1500), (0.97, 1, 3500)])
def test_coverage(rho, recordings, samples, robust):
    ours, _ = covered(rho, recordings, samples, robust, repetitions=200)
    assert 0.92 <= ours.mean() <= 0.98
    assert ours.min() >= 0.86


@pytest.mark.parametrize("size", [1e-150, 1e-160, 1e-200])
def test_a_column_that_is_next_to_nothing_determines_nothing(size):
    rng = np.random.default_rng(0)
    columns = rng.standard_normal((1, 400, 3)) * [1.0, 1.0, size]
    found = covariance(columns, rng.standard_normal((1, 400)), np.array([1.5]), np.zeros(400, dtype=int))
    assert np.all(found.half_widths()[:2] < 1.0) and not found.half_widths()[2] < 1e100
