"""Designed motions: inside the limits at all times, as good as asked, and as informative as predicted."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.trajectories.extremes import bounds, margin
from exoid.measurement.trajectories.trajectory import TrajectoryError
from exoid.optimisation.excitation import design as excitation
from exoid.optimisation.excitation.criteria import Noise, condition, softened
from exoid.optimisation.excitation.design import DesignError, design, evaluate, evaluate_paper
from exoid.optimisation.excitation.space import motion_space
from exoid.optimisation.optimisers import optimisers
from exoid.symbolic.force import Force
from exoid.symbolic.model import Model
from exoid.symbolic.model_structure import TABLE_1, Limits


@pytest.fixture(scope="module")
def found():
    return design(seed=3)


@pytest.mark.slow
def test_the_targets_are_met():
    """At a_th = 0.40 m, T = 10 s, offsets fixed; best known 55.03."""
    found = [design(seed=seed) for seed in range(10)]
    assert sum(one.value <= 55.3 for one in found) >= 9
    assert all(one.feasible and one.informative for one in found)
    assert [one.candidates[0].evaluations for one in found] == [20 * 400] * 10


def test_what_is_refined_is_better_and_inside(found):
    search, refined = found.candidates
    assert refined.value < search.value and found.value == refined.value and found.feasible
    assert refined.evaluations > search.evaluations == 20 * 400


@pytest.mark.slow
def test_nfo_is_one_setting_away():
    """About every second seed of NFO reaches 56.5 before it is refined."""
    found = [design(seed=seed, optimiser="nfo") for seed in range(8)]
    values = [one.candidates[0].value for one in found]
    assert np.median(values) <= 57.0 and min(values) <= 56.5
    assert all([c.name for c in one.candidates] == ["NFO", "NFO, refined"] for one in found)


@pytest.mark.parametrize("name", optimisers())
def test_every_optimiser_designs_motions(name):
    one = design(optimiser=name, generations=20, harmonics=2)
    assert one.feasible and one.candidates[0].evaluations == 400 and one.value <= one.candidates[0].value


@pytest.mark.slow
def test_free_offsets_are_better_still(found):
    free = design(offsets="free")
    assert free.feasible and free.condition < 0.8 * found.condition


def test_the_value_is_that_of_the_regressor(found):
    t = np.arange(4000) * (10.0 / 4000)
    columns = found.model.columns(found.trajectory.at(t))
    assert found.condition == pytest.approx(np.linalg.cond(columns.reshape(-1, 8)), rel=3e-3)


@pytest.mark.slow
def test_start_and_end_at_rest_exactly():
    still = design(rest=True, generations=30).trajectory.at(np.array([0.0, 10.0]))
    assert np.abs(still.dq).max() < 1e-12 and np.abs(still.ddq).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("criterion", ["d_optimal", "worst"])
def test_each_criterion_is_best_at_its_own(criterion, found):
    own = design(criterion=criterion, generations=150)
    other = evaluate(found.trajectory, criterion=criterion)
    assert own.value < other.value and own.feasible


@pytest.mark.slow
@pytest.mark.parametrize("harmonics", [2, 5])
@pytest.mark.parametrize("criterion", ["condition", "d_optimal", "worst"])
def test_ipopt_knows_every_criterion(criterion, harmonics):
    both = design(criterion=criterion, starts=1, generations=20, harmonics=harmonics)
    search, refined, ipopt = both.candidates
    assert ipopt.name == "IPOPT 1" and max(ipopt.value, refined.value) < search.value and both.feasible
    assert both.to_json()["best_known"] is True


def test_the_printed_variant_finds_nothing_to_follow():
    with pytest.raises(DesignError, match="nothing to follow"):
        design(printed=True, generations=50)
    small = design(printed=True, box=0.1, generations=100)
    assert small.feasible and small.condition > 100.0


def test_the_papers_coefficients():
    assert evaluate_paper(10.0).condition == pytest.approx(75.3, abs=0.2)
    assert evaluate_paper(10.0).feasible and not evaluate_paper(9.0).feasible


def test_predicted_deviations_are_those_of_fits(found):
    leg, rng = np.array(standard_leg().base), np.random.default_rng(3)
    t = np.arange(3000) / 100.0
    matrix = found.model.columns(found.trajectory.at(t)).reshape(-1, 8)
    noise = 0.5 * rng.standard_normal((len(matrix), 400))
    fits = np.linalg.lstsq(matrix, (matrix @ leg)[:, None] + noise, rcond=None)[0]
    predicted = [one.deviation for one in found.precision]
    np.testing.assert_allclose(fits.std(axis=1), predicted, rtol=0.15)


@pytest.mark.slow
def test_limits_of_the_model_and_a_share_of_them():
    tight = {joint: Limits(TABLE_1[joint].angle, 0.5, 1.0) for joint in TABLE_1}
    from dataclasses import replace

    slow = design(replace(Model.standard(), limits=tight), generations=20, use=0.9)
    assert slow.feasible
    speeds = slow.trajectory.at(np.linspace(0.0, 10.0, 3001))
    assert np.abs(speeds.dq).max() <= 0.45 and np.abs(speeds.ddq).max() <= 0.9


@pytest.mark.slow
def test_models_with_effects_and_identified_numbers():
    model = Model.standard().with_effect("stribeck:knee").with_effect("load_friction:hip")
    one = design(model, criterion="worst", generations=40)
    assert [p.name for p in one.precision][-1] == "stribeck:knee.v_s" and one.informative
    past = design(Model.standard().with_effect("backlash:hip"), generations=3, individuals=5)
    assert any("operators with a past" in text for text in past.cautions)


@pytest.mark.slow
def test_a_plan_has_no_forces_and_says_so():
    worn = Model.standard().with_forces(Force("shank cuff", "knee", ("f2",)))
    told = design(worn, generations=3, individuals=5)
    assert any("nothing is taken to push" in text and "shank cuff" in text for text in told.cautions)
    bare = design(Model.standard(), generations=3, individuals=5)
    assert told.value == bare.value and not any("push" in text for text in bare.cautions)


@pytest.mark.slow
def test_numbers_no_motion_determines_are_said():
    model = Model.standard().with_effect("drive_gain:hip").with_effect("drive_gain:knee")
    blind = design(model, generations=5)
    assert not blind.informative and any("carries no information on" in text for text in blind.cautions)


@pytest.mark.slow
def test_without_a_compiler_the_numbers_are_the_same(monkeypatch):
    fast = design(generations=4, individuals=5)
    real = excitation.information
    monkeypatch.setattr(excitation, "information", lambda *a, **k: real(*a, **k, backend="vm"))
    slow = design(generations=4, individuals=5)
    assert slow.backend == "vm"
    assert slow.candidates[0].value == pytest.approx(fast.candidates[0].value, rel=1e-9)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_motion():
    one, two, other = (design(generations=10, seed=s).trajectory.sine for s in (4, 4, 5))
    np.testing.assert_array_equal(one, two)
    assert not np.array_equal(one, other)


def test_creeping_is_said(found):
    assert all(0.0 <= share < 1.0 for share in found.creeping)
    assert (max(found.creeping) > 0.1) == any("may stick" in text for text in found.cautions)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"criterion": "x"}, "no criterion"),
        ({"optimiser": "x"}, "no optimiser"),
        ({"use": 1.5}, "of the limits"),
        ({"period": -1.0}, "give a period"),
        ({"harmonics": 1, "rest": True}, "at least two harmonics"),
        ({"offsets": "x"}, "one of"),
    ],
)
def test_refusals(settings, message):
    with pytest.raises((DesignError, TrajectoryError), match=message):
        design(**settings)


def test_a_centre_outside_the_limits_is_refused():
    room = bounds(TABLE_1)
    room[0, :2] = 0.7, 1.0
    with pytest.raises(TrajectoryError, match="centre"):
        motion_space(room)


def test_the_smooth_stand_in_bounds_the_condition():
    rng = np.random.default_rng(0)
    half = rng.normal(size=(5, 2, 8, 20))
    gram = half @ half.transpose(0, 1, 3, 2)
    assert np.all(softened(gram) >= 2.0 * np.log(condition(gram)) - 1e-12)


@pytest.mark.slow
def test_results_show_themselves(found):
    assert "cond" in repr(found) and "<table" in found._repr_html_()
    assert list(found.to_frame().columns) == ["value", "unit", "deviation", "relative"]
    assert len(found.plot().axes) == 6
    assert found.to_json()["best_known"] is True
    assert "hip 0.5 N·m" in str(Noise.white())
    assert margin(5, 500) > 0.9995
