"""A drive that gives way, with the encoder at the motor: compared with a Newton-Euler leg behind a spring."""

import numpy as np
import pytest

from exoid.measurement.bench.hidden import Hidden
from exoid.measurement.bench.sensors import Sensors
from exoid.measurement.bench.simulation import Bench, run_bench
from exoid.symbolic.effect import Coefficient, Effect
from exoid.symbolic.effect_catalogue import find_effect
from exoid.symbolic.effect_declaration import check_effect
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion
from tests.newton_euler import Leg, base_parameters, torque

LEG = Leg((9.5, 6.0), (0.14, 0.11), (0.18, 0.22))
STEP = 0.004


def base():
    """The eight parameters of the leg above, without friction."""
    return np.concatenate([base_parameters(LEG), np.zeros(4)])


def behind_a_spring(joint, stiffness):
    """Return the motion of the encoders and the torque of the links, which the spring at `joint` passes on.

    The links move as given; their torque is Newton and Euler's; the motor stands before them by torque over stiffness,
    whatever the inertia of its rotor.
    """
    t = np.arange(0.0, 12.0, STEP)
    w = 2.0 * np.pi / 6.0
    q = np.column_stack([0.5 + 0.5 * np.sin(w * t), -0.9 + 0.5 * np.sin(2.0 * w * t + 1.0)])
    dq = np.column_stack([0.5 * w * np.cos(w * t), w * np.cos(2.0 * w * t + 1.0)])
    ddq = np.column_stack([-0.5 * w**2 * np.sin(w * t), -2.0 * w**2 * np.sin(2.0 * w * t + 1.0)])
    tau = np.array([torque(LEG, *state) for state in zip(q, dq, ddq, strict=True)])
    twist = np.zeros_like(q)
    twist[:, joint] = tau[:, joint] / stiffness
    rate = np.gradient(twist, t, axis=0, edge_order=2)
    return Motion(t, q + twist, dq + rate, ddq + np.gradient(rate, t, axis=0, edge_order=2)), tau


def rms(x):
    return float(np.sqrt(np.mean(x[250:-250] ** 2)))


@pytest.mark.parametrize(("joint", "stiffness"), [("hip", 3000.0), ("knee", 600.0)])
def test_a_leg_behind_a_spring_is_explained_at_both_joints(joint, stiffness):
    place = ("hip", "knee").index(joint)
    stiff, full = Model.standard(), Model.standard().with_effect("motor_elasticity", joint)
    on, tau = behind_a_spring(place, stiffness)
    for j in (0, 1):
        without = rms(tau[:, j] - stiff.torque(on, base())[:, j])
        left = rms(tau[:, j] - full.torque(on, [*base(), 1.0 / stiffness])[:, j])
        assert left < 0.15 * without
    # What is left is of second order: it falls with the square of the compliance.
    twice, tau_twice = behind_a_spring(place, 2.0 * stiffness)
    halved = rms(tau_twice - full.torque(twice, [*base(), 0.5 / stiffness]))
    assert halved < 0.4 * rms(tau - full.torque(on, [*base(), 1.0 / stiffness]))


def test_a_gap_that_follows_the_load_changes_both_joints():
    model = Model.standard().with_effect("series_backlash:knee")
    on, _ = behind_a_spring(1, 1e9)
    added = model.torque(on, [*base(), 0.01]) - Model.standard().torque(on, base())
    assert np.abs(added).max(axis=0).min() > 0.02
    side = np.sign(Model.standard().torque(on, base())[:, 1])
    middle = np.abs(on.t - 6.0) < 5.0
    # Gravity pulls the shank back to hanging: the link hangs lower than the encoder says, and that takes less torque.
    assert np.mean((added[:, 1] * side)[middle]) < 0.0


def test_the_bench_turns_the_encoder_and_not_the_leg():
    bench = Bench(duration=3.0, lead_in=0.0, sensors=Sensors.ideal())
    one, plain = (run_bench(effects=e, seed=1, bench=bench) for e in ([Hidden("motor_elasticity", "knee")], []))
    np.testing.assert_allclose(one.motion.q[:, 0], plain.motion.q[:, 0], atol=1e-12)
    twist = one.motion.q[:, 1] - plain.motion.q[:, 1]
    load = plain.torque[:, 1] - plain.true.linear[6:8] @ [plain.motion.sign[:, 1], plain.motion.dq[:, 1]]
    assert np.corrcoef(twist[30:-30], load[30:-30])[0, 1] > 0.95


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"joints": ("both",)}, "belongs to one joint"),
        ({"deflection": {"other": "theta"}}, "a text for each coefficient"),
        ({"torque": "c * theta"}, "give exactly one"),
    ],
)
def test_a_deflection_is_checked(changes, message):
    fields = {"id": "soft", "explains": "x", "deflection": {"c": "theta"}, "coefficients": {"c": Coefficient("1")}}
    with pytest.raises(Exception, match=f"(?s){message}"):
        check_effect(Effect(**{**fields, **changes}))


def test_the_entries_of_the_catalogue_keep_what_they_declare():
    for name in ("motor_elasticity", "series_backlash"):
        check_effect(find_effect(name))
