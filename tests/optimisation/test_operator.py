"""What is done to the measured torque is one linear operator, done to the model's torque and to every column alike: a
true model leaves filtered noise, whichever samples are hidden.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exoid.measurement.recording import Recording
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion

AXIS = Model("bench", joints=(Joint("axis"),))
CHAIN = Model("chain", joints=(Joint("hip", length=0.4), Joint("knee", length=0.4), Joint("ankle")))
HIDDEN = {
    "viscous_quadratic": (0.4,),
    "viscous_cubic": (0.2,),
    "torque_ripple": (0.3, 0.2),
    "end_stop": (20.0,),
    "stribeck": (0.8,),
    "viscous_asymmetry": (0.2,),
    "load_friction": (0.1,),
}
SHAPES = {"n": 20.0, "theta_s": 0.9, "side": 1.0, "v_s": 0.15}


def motion(joints: int, k: int, rate: float, seconds: float = 20.0) -> Motion:
    """Smooth motion of every joint, with its exact derivatives."""
    t = np.arange(0.0, seconds, 1.0 / rate)
    parts = np.zeros((3, t.size, joints))
    for j in range(joints):
        for size, pace, phase in ((0.8, 2.0 + 0.2 * k + 0.3 * j, j), (0.4, 5.1 - 0.3 * k - 0.4 * j, k)):
            wave = np.array([np.sin(pace * t + phase), np.cos(pace * t + phase)])
            parts[:, :, j] += size * np.array([wave[0], pace * wave[1], -(pace**2) * wave[0]])
    return Motion(t, *parts)


def recorded(model: Model, linear, k: int, noise: float, rate: float = 100.0, seed: int = 0) -> Recording:
    """A recording of the model at the numbers `linear` (P,), with exact angles and white noise of the torque."""
    moved = motion(len(model.joints), k, rate)
    shape = np.array([SHAPES[one.name.rpartition(".")[2]] for one in model.shapes])
    tau = model.torque(moved, linear, shape if shape.size else None)
    tau = tau + noise * np.random.default_rng([seed, k]).standard_normal(tau.shape)
    return Recording(f"run {k}", moved.t, moved.q, tau, joints=model.joints)


def bench(effect: str | None) -> tuple[Model, np.ndarray]:
    model = AXIS.with_effect(f"{effect}:axis") if effect else AXIS
    return model, np.array([0.3, 3.0, 1.2, 0.5, *(HIDDEN[effect] if effect else ())])


def left(one, model, linear):
    shape = np.array([SHAPES[entry.name.rpartition(".")[2]] for entry in model.shapes])
    rest = one.torque - one.smooth(model.torque(one.motion, linear, shape if shape.size else None))
    return np.sqrt(np.sum(np.where(one.used, rest, 0.0) ** 2, axis=1) / one.used.sum(axis=1))


@st.composite
def masks(draw):
    """Which torques are missing (N, J) of 2000 samples: runs and single samples, of each joint its own."""
    joints = draw(st.sampled_from([1, 3]))
    missing = np.zeros((2000, joints), bool)
    for j in range(joints):
        for _ in range(draw(st.integers(0, 8))):
            start = draw(st.integers(0, 1990))
            missing[start : start + draw(st.sampled_from([1, 3, 20, 80])), j] = True
    return missing


@pytest.mark.slow
@given(masks(), st.sampled_from([0.005, 0.05, 0.5]), st.integers(0, 99))
@settings(max_examples=12, deadline=None)
def test_a_true_model_leaves_filtered_noise_whichever_samples_are_hidden(missing, noise, seed):
    """The noise goes through the operator alone, and is what the true model leaves."""
    model = AXIS if missing.shape[1] == 1 else CHAIN
    rng = np.random.default_rng(seed)
    linear = rng.uniform(0.3, 1.0, len(model.parameters))
    recording = recorded(model, linear, 1, noise, seed=seed)
    tau = np.where(missing, 100.0 * rng.standard_normal(missing.shape), recording.tau)
    spoilt = replace(recording, tau=tau, torque_valid=~missing)
    (one,) = prepare(model, [spoilt], cutoff=8.0).train
    assert one.hidden[missing].all()
    exact = model.torque(motion(missing.shape[1], 1, 100.0), linear)
    own = one.smooth(np.where(missing, 0.0, recording.tau - exact))
    alone = np.sqrt(np.sum(np.where(one.used, own, 0.0) ** 2, axis=1) / one.used.sum(axis=1))
    assert left(one, model, linear) == pytest.approx(alone, rel=0.1, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("rate", [100.0, 500.0, 1000.0])
@pytest.mark.parametrize("effect", [None, *HIDDEN])
def test_an_effect_in_the_model_leaves_the_noise_and_the_floor_says_so(effect, rate):
    model, linear = bench(effect)
    noise = 0.02
    prepared = prepare(model, [recorded(model, linear, k, noise, rate) for k in range(2)], cutoff=8.0)
    rest = np.sqrt(np.mean([left(one, model, linear) ** 2 for one in prepared.train]))
    white = noise * np.sqrt(2.0 * 8.0 / rate)
    assert 0.85 * white < rest < 1.12 * white
    assert max(float(one.outliers.max()) for one in prepared.train) < 0.06


@pytest.mark.slow
@pytest.mark.parametrize("rate", [100.0, 1000.0])
@pytest.mark.parametrize("noise", [0.05, 0.5])
def test_the_noise_floor_is_that_of_the_operator(noise, rate):
    model, linear = bench(None)
    runs = [recorded(model, linear, k, noise, rate, seed=5) for k in range(4)]
    for share in (0.0, 0.3):
        cut = [replace(run, torque_valid=((run.t % 1.0) >= share)[:, None]) for run in runs]
        prepared = prepare(model, cut, cutoff=8.0)
        rest = np.sqrt(np.mean([left(one, model, linear) ** 2 for one in prepared.train]))
        assert 0.9 < float(prepared.noise_floor[0]) / rest < 1.12


@pytest.mark.parametrize("share", [0.2, 0.45, 0.65])
def test_missing_torques_change_no_number(share):
    """Load friction of 0.1 with the torque missing for a part of each second, the angles there."""
    model, linear = bench("load_friction")
    runs = [recorded(model, linear, k, 0.1) for k in range(3)]
    cut = [replace(run, torque_valid=((run.t % 1.0) >= share)[:, None]) for run in runs]
    ready = [prepare(model, some, cutoff=8.0).train for some in (runs, cut)]
    whole, part = (identify(model, some, optimisers=()).estimates[-1] for some in ready)
    assert part.low <= 0.1 <= part.high and abs(part.value - whole.value) < 0.01


def test_a_missing_torque_loses_no_angle_and_no_other_torque():
    rng = np.random.default_rng(0)
    linear = rng.uniform(0.3, 1.0, len(CHAIN.parameters))
    run = recorded(CHAIN, linear, 1, 0.05)
    valid = np.ones(run.tau.shape, bool)
    valid[400:600, 1] = False
    (one,) = prepare(CHAIN, [replace(run, torque_valid=valid)], cutoff=8.0).train
    (whole,) = prepare(CHAIN, [run], cutoff=8.0).train
    np.testing.assert_array_equal(one.motion.ddq, whole.motion.ddq)
    np.testing.assert_array_equal(one.used[[0, 2]], whole.used[[0, 2]])
    gone = (one.t > run.t[410]) & (one.t < run.t[590])
    assert not one.used[1, gone].any() and whole.used[1, gone].any()


def test_missing_rows_are_hidden_and_their_neighbours_are_right():
    model, linear = bench("viscous_quadratic")
    runs = [recorded(model, linear, k, 0.02) for k in range(2)]
    cut = [replace(run, valid=(run.t % 5.0) >= 0.1) for run in runs]
    for one in prepare(model, cut, cutoff=8.0).train:
        assert left(one, model, linear) < 1.15 * 0.02 * np.sqrt(0.16)


@pytest.mark.parametrize(("every", "said"), [(1000, ""), (100, "repaired"), (30, "warning")])
def test_the_share_hidden_as_spikes_is_said_and_much_of_it_warned_of(every, said):
    model, linear = bench(None)
    run = recorded(model, linear, 0, 0.05)
    tau = np.array(run.tau)
    tau[7::every] += 5.0
    findings = prepare(model, [replace(run, tau=tau)], cutoff=8.0).findings
    found = [one for one in findings if one.check == "torque_outliers"]
    assert [one.severity for one in found] == ([said] if said else [])
    assert not found or said == "repaired" or found[0].where == "run 0, axis, all the time"
