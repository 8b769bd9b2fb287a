"""A known mass on the leg: compared with Newton and Euler's leg with that mass, and through the whole fit."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exoid.diagnosis.discovery import discover
from exoid.measurement.bench.hidden import parse_hidden
from exoid.measurement.bench.leg import Leg, Segment, standard_leg
from exoid.measurement.bench.machine import standard_machine
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.optimisation.fitting.identify import identify
from exoid.symbolic import Model, Motion
from exoid.symbolic.mechanics.payload import Payload, PayloadError
from exoid.symbolic.model import model_of
from exoid.symbolic.robot_file import parse_robot
from exoid.symbolic.spatial_machine import spatial_machine
from exoid.workbench.command_line.inputs import payload_of
from exoid.workbench.command_line.parser import UsageError
from tests import newton_euler
from tests.symbolic.arms import arm_text

OWN = newton_euler.Leg((9.0, 5.0), (0.14, 0.11), (0.18, 0.22))


def loaded(link, mass, along):
    """OWN with a point mass: one rigid body, by Steiner."""
    k = ("thigh", "shank").index(link)
    whole = OWN.m[k] + mass
    centre = (OWN.m[k] * OWN.along[k] + mass * along) / whole
    inertia = OWN.inertia[k] + OWN.m[k] * (OWN.along[k] - centre) ** 2 + mass * (along - centre) ** 2
    change = lambda pair, value: tuple(value if j == k else old for j, old in enumerate(pair))  # noqa: E731
    return replace(OWN, m=change(OWN.m, whole), along=change(OWN.along, centre), inertia=change(OWN.inertia, inertia))


@settings(deadline=None)
@given(st.sampled_from(["thigh", "shank"]), st.floats(0.1, 20.0), st.floats(-0.5, 0.9), st.integers(0, 10_000))
def test_a_payload_is_newton_and_eulers(link, mass, along, seed):
    q, dq, ddq = np.random.default_rng(seed).normal(size=(3, 4, 2))
    payload = Payload(mass, along, link).numbers(OWN.length)
    motion = Motion(np.arange(4) * 0.1, q, dq, ddq, payload=payload)
    bare = np.concatenate([newton_euler.base_parameters(OWN), np.zeros(4)])
    wanted = [newton_euler.torque(loaded(link, mass, along), *state) for state in zip(q, dq, ddq, strict=True)]
    np.testing.assert_allclose(Model.standard().torque(motion, bare), wanted, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    "name", ["load_friction:knee", "base_motion", "drive_gain:hip", "gravity_tilt", "time_delay:knee"]
)
def test_effects_act_on_the_torque_of_leg_and_payload(name):
    model = Model.standard().with_effect(name)
    rng = np.random.default_rng(2)
    t = np.arange(200) * 0.01
    wave = np.stack([np.sin(2.0 * t + k) for k in range(2)], axis=1)
    payload = Payload(3.0, 0.3).numbers(model.thigh_length)
    linear = np.concatenate([newton_euler.base_parameters(OWN), [4.0, 2.0, 3.0, 1.2], rng.random(8)])
    linear = linear[: len(model.parameters)]
    heavy = linear.copy()
    heavy[:4] += payload
    bare = Motion(t, wave, 2.0 * wave[::-1], -4.0 * wave)
    with_payload = Motion(t, wave, 2.0 * wave[::-1], -4.0 * wave, payload=payload)
    np.testing.assert_allclose(model.torque(with_payload, linear), model.torque(bare, heavy), rtol=1e-12)


def test_the_bench_loads_a_leg_as_segments_would():
    thigh, shank = Segment(9.5, 0.18, 0.14), Segment(6.0, 0.22, 0.11)
    whole = shank.mass + 2.0
    centre = (shank.mass * shank.com + 2.0 * 0.35) / whole
    inertia = shank.inertia + shank.mass * (shank.com - centre) ** 2 + 2.0 * (0.35 - centre) ** 2
    wanted = Leg.of("", thigh, Segment(whole, centre, inertia), (4.0, 2.0, 3.0, 1.2)).base
    assert standard_leg().with_payload(2.0, 0.35).base == pytest.approx(wanted)


@pytest.mark.slow
@pytest.mark.parametrize("effect", [None, "load_friction:knee=0.2"])
def test_loaded_and_bare_recordings_are_one_leg(effect):
    hidden = () if effect is None else (parse_hidden(effect),)
    bench, leg = Bench(duration=12.0), standard_leg()
    bare = simulate_runs(1, None, leg, effects=hidden, seed=1, bench=bench)[0].recording
    heavy = simulate_runs(1, None, leg.with_payload(4.0, 0.4), effects=hidden, seed=2, bench=bench)[0].recording
    model = Model.standard() if effect is None else Model.standard().with_effect(hidden[0].name)
    right = identify(model, [bare, heavy.with_payload(4.0, 0.4)])
    wrong = identify(model, [bare, heavy])
    assert right.linear[:3] == pytest.approx(leg.base[:3], rel=0.05)
    assert wrong.rms.max() > 2.0 * right.rms.max()


def test_payloads_that_cannot_be_are_refused():
    for mass, along, link, word in ((0.0, 0.3, "shank", "kg"), (2.0, 350.0, "shank", "m"), (2.0, 0.3, "foot", "shank")):
        with pytest.raises(PayloadError, match=word):
            Payload(mass, along, link).added(Model.standard())
    with pytest.raises(PayloadError):
        Payload(float("nan"), 0.3)


@pytest.mark.slow
def test_a_load_that_was_not_named_is_weighed():
    bench, leg = Bench(duration=12.0), standard_leg()
    bare = [run.recording for run in simulate_runs(3, None, leg, seed=1, bench=bench)]
    heavy = simulate_runs(1, None, leg.with_payload(3.0, 0.35), seed=2, bench=bench, name="heavy")[0].recording
    found = discover(Model.standard(), [*bare, heavy])
    (load,) = found.of_recordings
    assert load.what == "carried_load" and load.values["heavy_0"].value == pytest.approx(3.0, abs=0.1)
    assert load.place.value == pytest.approx(0.35, abs=0.02) and not found.left_out
    named = discover(Model.standard(), [*bare, heavy.with_payload(3.0, 0.35)])
    assert named.verdict == "adequate" and not named.of_recordings and not named.left_out


ARM = model_of(spatial_machine(parse_robot(arm_text(7, 4, ("revolute", "revolute", "prismatic")).encode())).model)


def test_a_payload_in_space_is_pinocchios():
    pin = pytest.importorskip("pinocchio")
    robot = pin.buildModelFromXML(arm_text(7, 4, ("revolute", "revolute", "prismatic")))
    place = (0.1, -0.2, 0.05)
    heavy = robot.copy()
    point = pin.Inertia(2.5, np.array(place), np.zeros((3, 3)))
    heavy.appendBodyToJoint(heavy.getJointId("j2"), point, pin.SE3.Identity())
    added = Payload(2.5, place, "j2").added(ARM)
    q, dq, ddq = np.random.default_rng(1).normal(size=(3, 6, 4))
    numbers = np.zeros(len(ARM.parameters))
    found = ARM.torque(Motion(np.arange(6) * 0.1, q, dq, ddq, payload=added), numbers)
    for k in range(6):
        with_it, without = (pin.rnea(one, one.createData(), q[k], dq[k], ddq[k]) for one in (heavy, robot))
        np.testing.assert_allclose(found[k], with_it - without, rtol=1e-9, atol=1e-9)


@pytest.mark.slow
def test_a_known_mass_tells_gains_of_an_arm_in_space():
    hidden = (parse_hidden("drive_gain:j1=0.08"),)
    bench, arm = Bench(duration=12.0), standard_machine(ARM)
    load = Payload(3.0, (0.1, 0.1, 0.1))
    runs = [simulate_runs(1, ARM, one, effects=hidden, seed=2, bench=bench)[0].recording
            for one in (arm, arm.with_payload(load, ARM))]  # fmt: skip
    model = ARM.with_effect("drive_gain:j1")
    known = identify(model, [runs[0], runs[1].with_payload(3.0, (0.1, 0.1, 0.1))], optimisers=())
    assert abs(known.estimate("drive_gain:j1.c").value - 0.08) < 0.02
    unknown = identify(model, runs, optimisers=())
    assert unknown.loss > 2.0 * known.loss, "as if nothing hung there"


def test_a_place_has_as_many_coordinates_as_the_machine_needs():
    with pytest.raises(PayloadError, match="in the frame of a joint"):
        Payload(1.0, 0.2, "j1").added(ARM)
    with pytest.raises(PayloadError, match="on the axis of a link"):
        Payload(1.0, (0.0, 0.0, 0.2)).added(Model.standard())
    with pytest.raises(PayloadError, match=r"a payload 0\.1,0\.2 m"):
        Payload(1.0, (0.1, 0.2))
    load = payload_of("j3:2@0,0,0.1")
    assert load == Payload(2.0, (0.0, 0.0, 0.1), "j3") and payload_of(str(load)) == load
    with pytest.raises(UsageError, match="KG@M"):
        payload_of("2@0,0.1")
