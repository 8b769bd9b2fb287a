"""The limb of a wearer: compared with Newton and Euler's leg with its segments, through files, fits and exports."""

from dataclasses import replace

import numpy as np
import pytest

from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.optimisation.fitting.identify import identify
from exoid.symbolic.joints import Joint
from exoid.symbolic.mechanics.body import Body, BodyError
from exoid.symbolic.model import Model, read_model
from exoid.symbolic.model_file import Numbers, write_model
from exoid.symbolic.motion import Motion
from exoid.workbench.identified import ready
from tests import newton_euler

OWN = newton_euler.Leg((9.0, 5.0), (0.14, 0.11), (0.18, 0.22))
MASS, HEIGHT = 70.0, 1.78


def with_segment(leg, k, mass, along, about):
    """A leg with one more rigid body on link k, by Steiner."""
    whole = leg.m[k] + mass
    centre = (leg.m[k] * leg.along[k] + mass * along) / whole
    inertia = (
        leg.inertia[k] + leg.m[k] * (leg.along[k] - centre) ** 2 + about + mass * (along - centre) ** 2
    )
    change = lambda pair, value: tuple(value if j == k else old for j, old in enumerate(pair))  # noqa: E731
    return replace(leg, m=change(leg.m, whole), along=change(leg.along, centre), inertia=change(leg.inertia, inertia))


def test_a_limb_is_newton_and_eulers_with_the_segments_of_the_table():
    thigh, shank = 0.245 * HEIGHT, 0.246 * HEIGHT
    worn = with_segment(OWN, 0, 7.0, 0.433 * thigh, 7.0 * (0.323 * thigh) ** 2)
    worn = with_segment(worn, 1, 4.27, 0.606 * shank, 4.27 * (0.416 * shank) ** 2)
    q, dq, ddq = np.random.default_rng(0).normal(size=(3, 5, 2))
    added = Body(MASS, HEIGHT).added(Model.standard())
    motion = Motion(np.arange(5) * 0.1, q, dq, ddq, payload=added)
    bare = np.concatenate([newton_euler.base_parameters(OWN), np.zeros(4)])
    wanted = [newton_euler.torque(worn, *state) for state in zip(q, dq, ddq, strict=True)]
    np.testing.assert_allclose(Model.standard().torque(motion, bare), wanted, rtol=1e-9, atol=1e-9)


def test_an_ankle_parts_the_foot_from_the_shank():
    two = Model(joints=[Joint("left_hip", length=0.4), Joint("left_knee")])
    three = Model(joints=[Joint("left_hip", length=0.4), Joint("left_knee", length=0.4), Joint("left_ankle")])
    masses = [sum(2.0 * body._inertial(s)[2] for s in body._limb(m.joints).values())
              for body, m in ((Body(50.0, 1.7), two), (Body(50.0, 1.7), three))]  # fmt: skip
    assert masses == pytest.approx([16.1, 16.1])
    assert len(Body(50.0, 1.7).added(three)) == len(three.inertial)


@pytest.mark.parametrize("text", ["", "70", "mass=70", "mass=70,height=x", "mass=70,height=1.78,age=3"])
def test_what_is_no_wearer_is_refused(text):
    with pytest.raises(BodyError, match="no wearer"):
        Body.named(text)


def test_what_cannot_be_is_refused():
    assert Body.named(" mass = 70, height = 1.78 ") == Body(MASS, HEIGHT)
    with pytest.raises(BodyError, match="height is 178 m"):
        Body(70.0, 178.0)
    with pytest.raises(BodyError, match="mass is nan"):
        Body(float("nan"), 1.7)
    with pytest.raises(BodyError, match="no link for the limb"):
        Model(joints=["axis"]).with_wearer(MASS, HEIGHT)


def test_a_model_file_keeps_its_wearer(tmp_path):
    model = Model.standard().with_wearer(MASS, HEIGHT).with_effect("stribeck:hip")
    assert read_model(write_model(model, tmp_path / "a.toml")).wearer == Body(MASS, HEIGHT)
    assert model.base().wearer == Body(MASS, HEIGHT) and "mass=70" in repr(model)
    path = tmp_path / "b.toml"
    path.write_text("[wearer]\nmass = 70\nheight = 178\n")
    with pytest.raises(Exception, match="line 3") as told:
        read_model(path)
    assert "178" in str(told.value)


@pytest.fixture(scope="module")
def fits():
    worn = Model.standard().with_wearer(MASS, HEIGHT)
    runs = [run.recording for run in simulate_runs(2, worn, seed=1, bench=Bench(duration=15.0))]
    return [identify(model, runs, optimisers=()) for model in (Model.standard(), worn)]


def test_the_numbers_are_those_of_the_machine_with_persons_in_their_intervals(fits):
    whole, own = fits
    added, deviation = (getattr(Body(MASS, HEIGHT), name)(own.model) for name in ("added", "deviation"))
    np.testing.assert_allclose(own.linear[:4] + added, whole.linear[:4], rtol=1e-9)
    np.testing.assert_allclose(own.rms, whole.rms, rtol=1e-9)
    for k, estimate in enumerate(own.estimates[:4]):
        assert estimate.low < standard_leg().base[k] < estimate.high
        wider = 0.5 * (estimate.high - estimate.low), 0.5 * (whole.estimates[k].high - whole.estimates[k].low)
        assert wider[0] > max(wider[1], 1.9 * deviation[k])
    assert own.estimates[4].low == pytest.approx(whole.estimates[4].low)
    assert any("machine alone" in caution.what for caution in own.plausibility)


def test_what_is_exported_moves_both(fits):
    whole, own = fits
    made = [
        ready(fit.model, Numbers(dict(zip([p.name for p in fit.model.parameters], fit.linear, strict=True)), {}, None))
        for fit in (whole, own)
    ]
    given = (0.0, [0.3, -0.8], [0.5, 0.1], [1.0, -1.0], [1.0, 1.0], [])
    np.testing.assert_allclose(np.array(made[0].torque(*given)), np.array(made[1].torque(*given)), rtol=1e-9)
