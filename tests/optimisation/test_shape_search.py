"""Shapes by a grid or by a population: both find a narrow valley, say how many starts agree, and refuse nonsense."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.ground.errors import ExoidError
from exoid.measurement.bench.hidden import parse_hidden
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.optimisation.fitting.assemble import Assembly
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.fitting.shapes import GRID, ShapeMethod, search_shape
from exoid.optimisation.linear.solve import solve_sse
from exoid.optimisation.optimisers import optimisers
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.effect import Shape
from exoid.symbolic.model import Model

SHAPES = [
    Shape("1", -1.0, 1.0, choices=(-1.0, 1.0)),
    Shape("s", 0.0, 1.0),
    Shape("s", 0.01, 1.0, spacing="log"),
]


def valleys(x):
    """Two valleys; the lower one is narrow."""
    away = (x[1] - 0.618) ** 2 + np.log(x[2] / 0.0773) ** 2
    return (x[0] - 1.0) ** 2 + min(away, 0.3 + 0.1 * ((x[1] - 0.1) ** 2 + np.log(x[2] / 0.5) ** 2))


@pytest.mark.parametrize("name", [None, *sorted(optimisers())])
def test_every_method_keeps_the_contract(name):
    method = ShapeMethod(None if name is None else optimisers()[name](), starts=4, apart=0.1, seed=1)
    found, again = (search_shape(valleys, SHAPES, None, method) for _ in range(2))
    assert found.value == again.value and np.array_equal(found.best, again.best)
    assert set(found.nodes[:, 0]) <= {-1.0, 1.0}
    assert all(s.min <= v <= s.max for row in found.nodes for s, v in zip(SHAPES, row, strict=True))
    assert found.value <= found.values.min()
    assert 1 <= found.agreeing[0] <= found.agreeing[1] <= 4
    if name in (None, "nfo", "de"):
        assert np.allclose(found.best, [1.0, 0.618, 0.0773], rtol=1e-2)


def test_starts_in_two_valleys_do_not_agree():
    found = search_shape(valleys, SHAPES, [np.array([1.0, 0.6, 0.08]), np.array([1.0, 0.1, 0.5])], GRID)
    assert found.agreeing == (1, 2)


@pytest.mark.slow
@pytest.mark.parametrize("how", ["multistart", "nfo"])
def test_identify_searches_as_it_is_told(how):
    runs = simulate_runs(
        1, None, standard_leg(), effects=[parse_hidden("stribeck:knee=c=3,v_s=0.15")], seed=2,
        bench=Bench(duration=12.0),
    )  # fmt: skip
    model = Model.standard().with_effect("stribeck:knee")
    train = prepare(model, [run.recording for run in runs]).train
    fit = identify(model, train, shape_search=how)
    assert fit.estimate("stribeck:knee.v_s").value == pytest.approx(0.15, rel=0.3)
    assert fit.best_known and fit.agreeing is not None and "starts agree" in repr(fit)
    assert fit.to_json()["starts_agreeing"] == list(fit.agreeing)


def test_an_unknown_way_is_refused():
    runs = simulate_runs(1, None, standard_leg(), seed=2, bench=Bench(duration=5.0))
    with pytest.raises(ExoidError, match="simulated_annealing"):
        identify(Model.standard(), [runs[0].recording], shape_search="simulated_annealing")


@pytest.mark.slow
@pytest.mark.parametrize(
    "names",
    [
        ("stribeck:knee",),
        ("torque_ripple:hip", "backlash:knee"),
        ("end_stop:knee",),
        ("base_motion",),
        ("load_friction:hip", "series_backlash:knee", "stribeck:knee"),
    ],
)
def test_all_nodes_at_once_are_the_nodes_one_by_one(names):
    runs = simulate_runs(2, None, standard_leg(), seed=4, bench=Bench(duration=6.0))
    model = Model.standard()
    for name in names:
        model = model.with_effect(name)
    assembly = Assembly(model, prepare(model, [run.recording for run in runs], cutoff=5.0).train)
    rng = np.random.default_rng(1)
    nodes = np.array(
        [[rng.choice(s.shape.choices or (s.shape.min, s.shape.max)) for s in model.shapes] for _ in range(5)]
    )
    nodes[0] = model.typical_shape
    held = rng.uniform(0.5, 1.0, len(model.parameters)) if model.needs_reference else None
    expected = []
    for node in nodes:
        data = Assembly(model, assembly.prepared).data(node, held)  # nothing remembered
        expected.append(np.sum(data.residual(solve_sse(data)) ** 2))
        if held is not None:
            assembly.data(node, 0.5 * held)  # columns that follow other numbers are not kept
        again = assembly.data(node, held)
        np.testing.assert_allclose(again.columns, data.columns, atol=1e-12)
    np.testing.assert_allclose(assembly.sse_at(nodes, held), expected, rtol=1e-9)


@pytest.mark.parametrize("name", ["gravity_tilt", "joint_elasticity:knee"])
def test_where_all_columns_follow_a_shape_nodes_are_not_taken_together(name):
    model = Model.standard().with_effect(name)
    run = simulate_runs(1, None, standard_leg(), seed=4, bench=Bench(duration=6.0))[0]
    assembly = Assembly(model, prepare(model, [run.recording], cutoff=5.0).train)
    held = np.ones(len(model.parameters)) if model.needs_reference else None
    assert assembly.sse_at(np.array([[0.01], [0.02]])[:, : len(model.shapes)], held) is None


def test_an_optimum_on_a_bound_is_the_bound():
    found = search_shape(lambda x: float(np.exp(x[0])), [Shape("s", 0.0, 1.0)])
    assert found.best == 0.0 and found.value == 1.0
