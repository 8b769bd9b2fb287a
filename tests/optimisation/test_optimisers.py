"""One suite over every optimiser: what is in the folder is tested, nothing is registered here."""

from __future__ import annotations

import numpy as np
import pytest
from numpy_fitness import PopulationFitness
from paper_leg import PAPER, Leg, record

from exoid.optimisation.fitting.assemble import assemble
from exoid.optimisation.linear.loss import huber
from exoid.optimisation.linear.problem import Problem, huber_problem
from exoid.optimisation.linear.solve import delta_rule, solve_huber, solve_sse
from exoid.optimisation.optimiser import BOUNDARIES, minimise
from exoid.optimisation.optimisers import optimisers
from exoid.optimisation.optimisers.nfo import NFO

SLOW = pytest.mark.slow
RECIPES = [
    pytest.param(kind(boundary=rule), id=f"{name}-{rule}") for name, kind in optimisers().items() for rule in BOUNDARIES
]
INSIDE = [
    pytest.param(*recipe.values, id=recipe.id, marks=() if recipe.values[0] == type(recipe.values[0])() else SLOW)
    for recipe in RECIPES
]
"""For what happens away from the bounds: other rules at them are slow tests."""
CENTRE = np.array([0.75, -0.5, 0.25])


def bowl(x):
    return np.sum((x - CENTRE) ** 2 * [1.0, 4.0, 2.0], axis=1)


def problem(fitness=bowl, low=-2.0, high=2.0):
    return Problem(fitness, np.full(3, low), np.full(3, high), ("a", "b", "c"), ("1",) * 3)


def short(p, optimiser, **options):
    return minimise(p, optimiser, **{"individuals": 20, "generations": 40, "seed": 3, **options})


def test_the_folder_is_the_catalogue():
    assert {"nfo", "cma_es"} <= set(optimisers())


@pytest.mark.parametrize("optimiser", INSIDE)
def test_finds_the_bottom_of_a_bowl(optimiser):
    run = short(problem(), optimiser, generations=200)
    assert run.fitness < 1e-4
    assert np.allclose(run.x, CENTRE, atol=1e-2)
    assert np.all(np.diff(run.history) <= 0.0)


@pytest.mark.parametrize("optimiser", INSIDE)
def test_same_seed_same_run(optimiser):
    first, second, other = (short(problem(), optimiser, seed=s) for s in (7, 7, 8))
    assert np.array_equal(first.history, second.history)
    assert np.array_equal(first.x, second.x)
    assert not np.array_equal(first.x, other.x)


AXES = np.array([4.0, 0.25, 1024.0])
CHANGES = {
    # what an optimiser may declare not to care about: (the changed problem, its answer in the old coordinates)
    "shift": (problem(lambda x: bowl(x - 8.0), 6.0, 10.0), lambda x: x - 8.0),
    "scale": (problem(lambda x: bowl(x / 1024.0), -2048.0, 2048.0), lambda x: x / 1024.0),
    "axes": (problem(lambda x: bowl(x / AXES), -2.0 * AXES, 2.0 * AXES), lambda x: x / AXES),
    "monotone": (problem(lambda x: np.log1p(bowl(x)) * 3.0 - 100.0), lambda x: x),
}


def test_the_declared_invariances_are_ones_that_are_tested():
    for name, kind in optimisers().items():
        assert kind.invariances <= set(CHANGES), name


@pytest.mark.parametrize(
    ("optimiser", "change"),
    [
        pytest.param(recipe.values[0], change, id=f"{recipe.id}-{change}", marks=recipe.marks)
        for recipe in INSIDE
        for change in sorted(recipe.values[0].invariances)
    ],
)
def test_what_is_declared_not_to_matter_does_not(optimiser, change):
    changed, back = CHANGES[change]
    usual = short(problem(), optimiser, generations=20)
    other = short(changed, optimiser, generations=20)
    assert np.allclose(back(other.x), usual.x, rtol=1e-6, atol=1e-7)


def test_nfo_cares_about_the_scale_of_an_axis():
    changed, back = CHANGES["axes"]
    assert not np.allclose(back(short(changed, NFO()).x), short(problem(), NFO()).x)


@pytest.mark.parametrize("optimiser", INSIDE)
def test_one_dimension_is_a_problem_too(optimiser):
    line = Problem(lambda x: (x[:, 0] - 0.3) ** 2, np.full(1, -2.0), np.full(1, 2.0), ("a",), ("1",))
    run = short(line, optimiser)
    assert run.x.shape == (1,)
    assert run.x == pytest.approx(0.3, abs=1e-2)


@pytest.mark.parametrize("optimiser", RECIPES)
def test_an_axis_without_room_stays_where_it_is(optimiser):
    low, high = np.array([-2.0, 0.7, -2.0]), np.array([2.0, 0.7, 2.0])
    run = short(Problem(bowl, low, high, ("a", "b", "c"), ("1",) * 3), optimiser)
    assert run.x[1] == 0.7
    assert np.allclose(run.x[[0, 2]], CENTRE[[0, 2]], atol=0.05)


def test_global_chance_is_left_alone():
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    for kind in optimisers().values():
        short(problem(), kind(), generations=5)
    assert np.array_equal(before, np.random.get_state()[1])  # noqa: NPY002


@pytest.mark.parametrize("optimiser", RECIPES)
def test_never_leaves_the_box(optimiser):
    seen = []

    def on_the_edge(x):
        seen.append(x.copy())
        return np.sum(x, axis=1)

    run = short(problem(on_the_edge), optimiser)
    everything = np.concatenate(seen)
    assert everything.min() >= -2.0
    assert everything.max() <= 2.0
    assert run.fitness >= -6.0


@pytest.mark.parametrize("optimiser", RECIPES)
@pytest.mark.parametrize(("individuals", "generations"), [(20, 40), (13, 1), (7, 9)])
def test_spends_exactly_the_budget(optimiser, individuals, generations):
    counted = []

    def counting(x):
        counted.append(len(x))
        return bowl(x)

    run = short(problem(counting), optimiser, individuals=individuals, generations=generations)
    assert sum(counted) == run.evaluations == individuals * generations
    assert run.counts[-1] == run.evaluations
    assert len(run.history) == len(run.counts)


@pytest.mark.parametrize("optimiser", INSIDE)
def test_survives_a_plateau(optimiser):
    run = short(problem(lambda x: np.zeros(len(x))), optimiser)
    assert run.fitness == 0.0
    assert np.all(np.abs(run.x) <= 2.0)


@pytest.mark.parametrize("optimiser", INSIDE)
def test_nan_never_wins(optimiser):
    half = short(problem(lambda x: np.where(x[:, 0] > 0.8, np.nan, bowl(x))), optimiser)
    assert half.x[0] <= 0.8
    assert half.fitness < 0.1
    nothing = short(problem(lambda x: np.full(len(x), np.nan)), optimiser)
    assert nothing.fitness == np.inf
    assert np.isfinite(nothing.x).all()


@pytest.mark.parametrize("optimiser", INSIDE)
def test_a_given_start_is_used_and_kept(optimiser):
    start = np.linspace(-1.0, 1.0, 60).reshape(20, 3)
    before = start.copy()
    run = short(problem(), optimiser, start=start, generations=1)
    assert run.fitness == bowl(start).min()
    short(problem(), optimiser, start=start)
    assert np.array_equal(start, before)


@pytest.mark.parametrize("rule", BOUNDARIES)
def test_boundary_rules_leave_inner_points_alone(rule):
    low, high = np.array([-1.0, 2.0, 5.0]), np.array([1.0, 6.0, 5.0])
    inner = np.array([[0.3, 3.1, 5.0], [-1.0, 6.0, 5.0]])
    assert np.array_equal(BOUNDARIES[rule](inner, low, high), inner)
    far = BOUNDARIES[rule](np.array([[-40.3, 61.7, -3.0]]), low, high)
    assert np.all((far >= low) & (far <= high))


def test_reflecting_mirrors_at_the_border():
    low, high = np.zeros(1), np.ones(1)
    assert np.allclose(BOUNDARIES["reflect"](np.array([[1.2], [-0.3], [2.1]]), low, high).ravel(), [0.8, 0.3, 0.1])
    assert np.allclose(BOUNDARIES["wrap"](np.array([[1.2], [-0.3]]), low, high).ravel(), [0.2, 0.7])


@pytest.fixture(scope="module")
def leg_problem():
    data = assemble(Leg(), [record(outliers=0.1, noise=5.0, samples=700, step=0.05)])
    sse = solve_sse(data)
    delta = delta_rule(data.residual(sse))
    fitness = PopulationFitness(data.columns, data.tau)
    return data, delta, huber_problem(data, lambda x: fitness.huber(x, delta), delta, sse)


def test_the_box_contains_the_optimum(leg_problem):
    data, delta, p = leg_problem
    optimum = solve_huber(data, delta)
    assert np.all((optimum >= p.low) & (optimum <= p.high))
    white = p.whitened()
    z = data.factor.forward @ optimum
    assert np.all((z >= white.low) & (z <= white.high))
    assert np.allclose(white.physical(z), optimum)
    assert white.fitness(z[None])[0] == pytest.approx(p.fitness(optimum[None])[0], rel=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_whitened_nfo_reaches_the_certified_optimum(leg_problem, seed):
    data, delta, p = leg_problem
    optimum = huber(data.residual(solve_huber(data, delta)), delta)
    run = minimise(p.whitened(), NFO(alpha=1.0), seed=seed)
    assert (huber(data.residual(run.x), delta) - optimum) / optimum <= 1e-12


def test_printed_nfo_is_far_from_it(leg_problem):
    data, delta, p = leg_problem
    optimum = huber(data.residual(solve_huber(data, delta)), delta)
    run = minimise(p, NFO(), seed=0)
    assert (run.fitness - optimum) / optimum > 1e-6
    assert np.abs(run.x - PAPER).max() < 60.0


def test_a_problem_without_a_metric_cannot_be_whitened():
    with pytest.raises(ValueError, match="linear in its parameters"):
        problem().whitened()
