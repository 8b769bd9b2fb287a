"""The virtual bench moves any machine: joints that stick, joints that slide, effects hidden in them."""

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import minimize

from exoid.measurement.bench.hidden import parse_hidden
from exoid.measurement.bench.machine import standard_machine
from exoid.measurement.bench.plant import EXACT, friction_impulse
from exoid.measurement.bench.sensors import Sensors
from exoid.measurement.bench.simulation import Bench, BenchError, run_bench
from exoid.measurement.trajectories.trajectory import Fourier, random_trajectory
from exoid.symbolic.joints import Joint, Origin
from exoid.symbolic.model import Model
from exoid.symbolic.model_structure import Limits

DRIVE = Model("drive", joints=(Joint("drive"),))
SLIDE = Model(
    "slide", gravity=0.0, joints=(Joint("stage", "prismatic"),), limits={"stage": Limits((-0.1, 0.1), 0.2, 0.8)}
)
CRANE = Model("crane", joints=(Joint("boom", length=0.4), Joint("reach", "prismatic")))
IDEAL = Bench(duration=6.0, sensors=Sensors.ideal())


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_friction_is_the_minimum_over_the_box(count):
    rng = np.random.default_rng(count)
    w, f, b = ca.SX.sym("w", count, count), ca.SX.sym("f", count), ca.SX.sym("b", count)
    solve = ca.Function("solve", [w, f, b], [friction_impulse(ca, w, f, b)])
    for _ in range(15):
        root = rng.normal(size=(count, count))
        weight, free, bound = (
            root @ root.T + 0.1 * np.eye(count),
            3.0 * rng.normal(size=count),
            rng.uniform(0.1, 2.0, count),
        )
        found = solve(weight, free, bound).full().ravel()

        def energy(x, weight=weight, free=free):
            return 0.5 * x @ weight @ x - free @ x

        best = minimize(energy, np.zeros(count), bounds=list(zip(-bound, bound, strict=True)), method="L-BFGS-B",
                        options={"ftol": 1e-15, "gtol": 1e-12})  # fmt: skip
        assert np.all(np.abs(found) <= bound + 1e-12)
        assert energy(found) <= best.fun + (1e-7 if count <= EXACT else 0.05 * abs(best.fun))


@pytest.mark.parametrize("model", [DRIVE, SLIDE, CRANE], ids=lambda m: m.name)
def test_what_is_recorded_obeys_the_model(model):
    made = run_bench(model, seed=2, bench=IDEAL)
    assert made.recording.joints == model.joints and made.recording.q.shape[1] == len(model.joints)
    np.testing.assert_allclose(made.true.torque(made.motion), made.torque, atol=1e-5 * np.abs(made.torque).max())
    assert made.saturated == 0.0
    again = run_bench(model, seed=2, bench=IDEAL)
    assert np.array_equal(again.recording.tau, made.recording.tau)


def test_a_hidden_effect_changes_the_torque_at_its_joint():
    plain = run_bench(CRANE, seed=1, bench=IDEAL)
    hidden = run_bench(CRANE, effects=[parse_hidden("stribeck:reach=6")], seed=1, bench=IDEAL)
    assert [one.term for one in hidden.truth.effects] == ["stribeck:reach"]
    change = np.abs(hidden.torque - plain.torque).max(axis=0)
    assert change[1] > 1.0 > change[0]


def test_a_joint_that_is_pushed_less_than_its_friction_stands():
    still = Fourier(np.zeros(1), np.full((1, 1), 1e-3), np.zeros((1, 1)), 2.0)
    made = run_bench(SLIDE, seed=0, excitation=still, bench=IDEAL)
    assert np.all(made.motion.dq[1:] == 0.0) and np.abs(made.motion.sign).max() < 1.0


def test_usual_limits_stand_in_for_those_a_model_leaves_out():
    limits = CRANE.motion_limits
    assert list(limits) == ["boom", "reach"] and limits["boom"].angle[1] > limits["reach"].angle[1]
    assert SLIDE.motion_limits["stage"] == SLIDE.limits["stage"]
    path = random_trajectory(np.random.default_rng(0), limits)
    assert np.abs(path.at(np.linspace(0.0, 10.0, 500)).q[:, 1]).max() <= limits["reach"].angle[1]


def test_what_the_bench_cannot_move_is_refused():
    with pytest.raises(BenchError, match="base parameters"):
        run_bench(CRANE, standard_machine(DRIVE), bench=IDEAL)


@pytest.mark.slow
def test_a_light_wrist_overcomes_its_friction():
    quarter = 0.5 * np.pi
    places = ((0.0, 0.0, 0.2), (0.0, 0.1, 0.0), (0.4, 0.0, 0.0), (0.3, 0.0, 0.1), (0.0, 0.08, 0.0))
    turned = (0.0, quarter, 0.0, quarter, -quarter)
    arm = Model("arm", joints=tuple(
        Joint(f"j{k}", axis=(0.0, 0.0, 1.0), origin=Origin(place, (roll, 0.0, 0.0)))
        for k, (place, roll) in enumerate(zip(places, turned, strict=True))
    ))  # fmt: skip
    run = run_bench(arm, bench=Bench(duration=8.0), seed=1)
    assert np.all(np.ptp(run.recording.q, axis=0) > 0.5)
