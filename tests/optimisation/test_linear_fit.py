"""Exact solvers, losses and certificates on data made to be unpleasant."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy_fitness import PopulationFitness
from paper_leg import PAPER, Leg, record

from exoid.ground.errors import NotEnoughDataError, RecordingError
from exoid.optimisation.fitting.assemble import assemble
from exoid.optimisation.linear.certificate import certify
from exoid.optimisation.linear.loss import huber
from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.reference import solve_reference
from exoid.optimisation.linear.solve import delta_rule, solve_huber, solve_sse
from exoid.symbolic.codegen.fitness import fitness
from exoid.symbolic.joints import LEG

INFINITE = np.full(2, np.inf)


def sse(residual):
    return float(np.sum(residual**2))


def make(seed=0, samples=120, width=4, spread=1.0, use=None):
    rng = np.random.default_rng(seed)
    columns = rng.normal(size=(2, samples, width)) * spread ** np.arange(width)
    tau = columns @ np.arange(1.0, width + 1.0) + rng.standard_t(1.5, size=(2, samples))
    names = tuple(f"p{i}" for i in range(width))
    return LinearData(columns, tau, np.zeros(samples, int), names, ("1",) * width, use)


def test_huber_is_the_papers_formula():
    residual = np.array([[0.5, -2.0, 1.0], [3.0, -0.1, -5.0]])
    delta = np.array([1.0, 2.0])
    by_hand = [0.25, 2 * (2.0 - 0.5), 1.0, 4 * (3.0 - 1.0), 0.01, 4 * (5.0 - 1.0)]
    assert huber(residual, delta) == pytest.approx(sum(by_hand), rel=1e-15)
    assert huber(residual, INFINITE) == pytest.approx(sse(residual), rel=1e-15)


def test_population_fitness_is_the_loss_of_each():
    data = make()
    population = np.random.default_rng(1).normal(size=(7, 4))
    fitness, delta = PopulationFitness(data.columns, data.tau), np.array([0.7, 1.9])
    assert np.allclose(fitness.sse(population), [sse(data.residual(p)) for p in population], rtol=1e-13)
    assert np.allclose(
        fitness.huber(population, delta), [huber(data.residual(p), delta) for p in population], rtol=1e-13
    )


def test_delta_leaves_fourteen_percent_outside():
    residual = np.random.default_rng(0).normal(size=(2, 1000)) * [[1.0], [30.0]]
    delta = delta_rule(residual)
    assert np.allclose((np.abs(residual) > delta[:, None]).mean(axis=1), 0.14, atol=0.001)
    use = np.zeros((2, 1000), dtype=bool)
    use[:, :100] = True
    assert np.array_equal(delta_rule(residual, use=use), delta_rule(residual[:, :100]))
    assert np.all(delta_rule(np.zeros((2, 5))) > 0.0)


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    samples=st.integers(6, 150),
    width=st.integers(1, 5),
    decades=st.floats(0.0, 1.0),
    share=st.floats(0.01, 0.7),
)
def test_the_exact_solution_is_always_certified(seed, samples, width, decades, share):
    data = make(seed, samples, width, 10.0**decades)
    sse_linear = solve_sse(data)
    assert certify(data, sse_linear, INFINITE).gap <= 1e-10
    delta = delta_rule(data.residual(sse_linear), share)
    for limits in (delta, np.array([delta[0], np.inf]), delta * 1e-3):
        proof = certify(data, solve_huber(data, limits), limits)
        assert proof.gap <= 1e-10, proof


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000), size=st.floats(1e-3, 10.0))
def test_the_certificate_refuses_a_wrong_optimum_and_its_bound_holds(seed, size):
    data = make(seed)
    delta = delta_rule(data.residual(solve_sse(data)))
    optimum = solve_huber(data, delta)
    best = huber(data.residual(optimum), delta)
    wrong = optimum + size * np.random.default_rng(seed).normal(size=4)
    for limits, truth in ((delta, best), (INFINITE, sse(data.residual(solve_sse(data))))):
        proof = certify(data, wrong, limits)
        assert not proof.holds
        assert "NOT" in str(proof)
        assert proof.dual <= truth * (1.0 + 1e-12)
        assert proof.infeasibility <= 1e-13


def test_ipopt_agrees_with_the_exact_solver():
    data = make(3, spread=5.0)
    delta = delta_rule(data.residual(solve_sse(data)))
    for limits, x in ((INFINITE, solve_sse(data)), (delta, solve_huber(data, delta))):
        found = solve_reference(data, limits)
        assert np.allclose(found.x, x, rtol=1e-9, atol=1e-9)
        assert found.iterations < 60
        assert certify(data, found.x, limits).gap <= 1e-9


def test_ipopt_is_silent(capfd):
    solve_reference(make(), INFINITE)
    out, err = capfd.readouterr()
    assert out == err == ""


def test_masked_samples_weigh_nothing():
    use = np.ones((2, 120), dtype=bool)
    use[0, 10:60] = False
    use[1, 100:] = False
    data = make(use=use)
    broken = LinearData(
        np.where(use[:, :, None], data.columns, np.nan),
        np.where(use, data.tau, 1e9),
        data.groups,
        data.names,
        data.units,
        use,
    )
    delta = delta_rule(data.residual(solve_sse(data)), use=use)
    assert np.array_equal(solve_huber(broken, delta), solve_huber(data, delta))
    rows = use.reshape(-1)
    by_hand = np.linalg.lstsq(data.matrix[rows], data.vector[rows], rcond=None)[0]
    assert np.allclose(solve_sse(data), by_hand)
    assert certify(data, solve_huber(data, delta), delta).gap <= 1e-13


def test_dependent_and_silent_columns_are_reported():
    good = make()
    columns = np.concatenate(
        [good.columns, good.columns[:, :, :1] - 2.0 * good.columns[:, :, 1:2], 0.0 * good.columns[:, :, :1]],
        axis=2,
    )
    data = LinearData(columns, good.tau, good.groups, tuple("abcdef"), ("1",) * 6)
    assert data.factor.rank == 4
    assert data.factor.undetermined == (0, 1, 4, 5)
    assert data.factor.unexcited == (5,)
    delta = np.array([1.0, 1.0])
    linear = solve_huber(data, delta)
    assert linear[5] == 0.0
    assert huber(data.residual(linear), delta) == pytest.approx(
        huber(good.residual(solve_huber(good, delta)), delta), rel=1e-12
    )
    assert certify(data, linear, delta).gap <= 1e-12


def test_a_perfect_fit_is_certified():
    good = make()
    data = LinearData(good.columns, good.columns @ np.arange(4.0), good.groups, good.names, good.units)
    linear = solve_sse(data)
    assert certify(data, linear, INFINITE).holds
    delta = delta_rule(data.residual(linear))
    assert certify(data, solve_huber(data, delta), delta).holds
    assert np.allclose(solve_huber(data, delta), np.arange(4.0))


def test_units_do_not_matter():
    data = assemble(Leg(), [record(noise=3.0, outliers=0.1, samples=500, step=0.05)])
    size = 10.0 ** np.array([-8, 6, 0, 3, -3, 9, 1, -6])
    scaled = LinearData(data.columns / size, data.tau, data.groups, data.names, data.units)
    delta = delta_rule(data.residual(solve_sse(data)))
    assert np.allclose(solve_huber(scaled, delta) / size, solve_huber(data, delta), rtol=1e-10)
    assert np.abs(solve_huber(data, delta) - PAPER).max() < 2.0


def test_bad_data_is_refused_with_its_name():
    good = make()
    columns = good.columns.copy()
    columns[1, 3, 2] = np.inf
    with pytest.raises(RecordingError, match="p2: values that are not finite"):
        LinearData(columns, good.tau, good.groups, good.names, good.units)
    with pytest.raises(ValueError, match="names"):
        LinearData(good.columns, good.tau, good.groups, ("a",), ("1",))
    few = make(samples=4)
    with pytest.raises(NotEnoughDataError, match="only 4 usable samples for 4 parameters"):
        few.require_enough(LEG)


def test_the_compiled_population_fitness_agrees():
    data = assemble(Leg(), [record(noise=3.0, outliers=0.1, samples=500, step=0.05)])
    population = PAPER + np.random.default_rng(1).normal(size=(9, 8))
    fast, check = fitness(data.columns, data.tau), PopulationFitness(data.columns, data.tau)
    delta = np.array([4.0, 5.0])
    assert np.allclose(fast.sse(population), check.sse(population), rtol=1e-12)
    assert np.allclose(fast.huber(population, delta), check.huber(population, delta), rtol=1e-12)
