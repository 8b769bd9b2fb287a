"""A joint may stand still throughout a recording, or in all of them; each recording tells what it can."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exoid.diagnosis.comparison import compare
from exoid.diagnosis.discovery import discover
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model
from tests.made_recordings import BETA, recording

HIP, KNEE = (True, False), (False, True)


def runs(moving, count=2, first=0, **more):
    return [recording(first + k, moving=moving, **more) for k in range(count)]


def test_the_torque_of_a_joint_that_is_held_is_not_its_load():
    """Whatever brake, lock or friction carries of it: the joint that moves tells what it can, the rest is named."""
    fit = identify(Model.standard(), runs(HIP), optimisers=())
    known = [0, 2, 4, 5]
    np.testing.assert_allclose(fit.linear[known], BETA[known], rtol=0.05, atol=0.02)
    unknown = {e.name for e in fit.estimates if not np.isfinite([e.low, e.high]).all()}
    assert unknown == {"Phi2", "Phi4", "coulomb:knee", "viscous:knee"}
    assert {f.check for f in fit.plausibility} == {"unexcited", "rank"}


def test_friction_of_a_held_joint_bends_nothing():
    made = [*runs(HIP), *runs(KNEE, first=5)]
    leant = [replace(one, tau=one.tau + shift) for one, shift in zip(made, 1.5 * np.array(
        [[0.0, 1.0], [0.0, -1.0], [1.0, 0.0], [-1.0, 0.0]]
    ), strict=True)]
    plain, with_friction = (identify(Model.standard(), some, optimisers=()) for some in (made, leant))
    np.testing.assert_allclose(with_friction.linear, plain.linear, rtol=1e-3, atol=1e-3)


def test_one_joint_moves_in_each_file():
    fit = identify(Model.standard(), [*runs(HIP), *runs(KNEE, first=5)], optimisers=())
    np.testing.assert_allclose(fit.linear, BETA, rtol=0.06, atol=0.03)
    assert all(np.isfinite([e.low, e.high]).all() for e in fit.estimates)
    assert not fit.plausibility


def test_a_lock_that_carries_the_load_says_nothing_and_spoils_nothing():
    locked = runs(HIP, undriven=KNEE)
    prepared = prepare(Model.standard(), locked)
    assert not any(one.used[1].any() for one in prepared.train)
    fit = identify(Model.standard(), prepared.train, optimisers=())
    assert fit.linear[2] == pytest.approx(BETA[2], rel=0.05)  # the hip still tells
    assert not any(f.check in ("inertia", "realisable") for f in fit.plausibility)
    with_both = identify(Model.standard(), [*locked, *runs((True, True), first=8)], optimisers=())
    np.testing.assert_allclose(with_both.linear, BETA, rtol=0.06, atol=0.03)


@pytest.mark.parametrize("moving", [HIP, KNEE])
def test_comparison_of_a_joint_that_never_moves(moving):
    found = compare(Model.standard(), runs(moving), runs(moving, 1, 7))
    assert np.all(found.verify_rms <= 1.3 * found.noise_floor)
    assert np.all(np.isfinite(found.rms))


@pytest.mark.slow
def test_nothing_is_missing_where_a_joint_never_moves_and_is_locked():
    locked = runs(HIP, 3, undriven=KNEE)
    found = discover(Model.standard(), locked[:2], locked[2:])
    assert not found.accepted
    assert all(np.isfinite(s.explained_share) for s in found.suspects)


def test_a_creeping_joint_is_left_out():
    slow = recording(3, moving=HIP)
    q = slow.q.copy()
    q[:, 1] += 0.012 * slow.t
    slow = type(slow)("creeping", slow.t, q, slow.tau)
    (one,) = prepare(Model.standard(), [slow]).train
    assert one.standing[1] and not one.used[1].any() and one.used[0].any()


@pytest.mark.parametrize("derivative", ["savgol", "fourier"])
def test_every_derivative_copes_with_a_joint_that_stands(derivative):
    t = np.arange(2000) / 100.0
    from exoid.measurement.recording import Recording
    from exoid.symbolic.motion import Motion

    w = 2 * np.pi / 5.0
    swing = 0.4 * np.sin(w * t) + 0.1 * np.sin(3 * w * t)
    q = np.column_stack([0.5 + swing, np.full(t.size, -0.9)])
    dq, ddq = (np.column_stack([np.gradient(x, t), np.zeros(t.size)]) for x in (swing, np.gradient(swing, t)))
    tau = Model.standard().torque(Motion(t, q, dq, ddq), BETA) + 0.1 * np.random.default_rng(0).normal(size=q.shape)
    noisy = q + 1e-5 * np.random.default_rng(1).normal(size=q.shape)
    prepared = prepare(Model.standard(), [Recording("periodic", t, noisy, tau)], derivative=derivative)
    fit = identify(Model.standard(), prepared.train, optimisers=())
    assert fit.linear[4] == pytest.approx(BETA[4], rel=0.05)


@pytest.mark.slow
def test_an_angle_that_never_changes_is_named_where_the_error_stays():
    frozen = [replace(one, q=np.column_stack([one.q[:, 0], np.full(len(one), -0.4)])) for one in runs((True, True), 4)]
    found = discover(Model.standard(), frozen[:3], frozen[3:])
    assert found.verdict == "unexplained"
    assert "The angle of the knee never changes: if it was not locked, this channel is dead." in found.sentence
