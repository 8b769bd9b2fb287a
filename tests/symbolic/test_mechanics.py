"""The derivation against an independent recursion, and against what the paper prints."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from exoid.symbolic import Model, Motion
from exoid.symbolic.check import check_equations
from exoid.symbolic.mechanics.mechanism import chain, leg
from exoid.symbolic.mechanics.regressor import compare_with_printed, derive_regressor
from tests.newton_euler import Leg, base_parameters, torque

SAMPLES = 7
unit = st.floats(-1.0, 1.0)
positive = st.floats(0.05, 3.0)
pairs = st.tuples(positive, positive)
seeds = st.integers(0, 2**32 - 1)
quick = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def random_motion(seed, n=SAMPLES):
    rng = np.random.default_rng(seed)
    return Motion(np.sort(rng.uniform(0, 9, n)), *(rng.normal(scale=2.0, size=(n, 2)) for _ in range(3)))


def expected(reference, motion, **more):
    rows = zip(motion.q, motion.dq, motion.ddq, strict=True)
    return np.array([torque(reference, *row, **more) for row in rows])


def near(actual, wanted):
    assert actual == pytest.approx(wanted, rel=1e-10, abs=1e-10 * (1.0 + np.abs(wanted).max()))


@quick
@given(pairs, pairs, pairs, seeds)
def test_plain_leg(m, inertia, along, seed):
    """Torque is the regressor times Φ, friction columns apart."""
    reference, motion = Leg(m, inertia, along), random_motion(seed)
    linear = np.concatenate([base_parameters(reference), np.zeros(4)])
    near(Model.standard().torque(motion, linear), expected(reference, motion))


@pytest.mark.slow
@quick
@given(pairs, pairs, pairs, st.tuples(unit, unit), seeds)
def test_masses_off_axis(m, inertia, along, across, seed):
    """Only the first moments are new; what they do to inertia is inside Φ1, Φ2 and Φ4."""
    model = Model.standard().with_effect("com_offset_thigh").with_effect("com_offset_shank")
    reference, motion = Leg(m, inertia, along, across), random_motion(seed)
    linear = np.concatenate([base_parameters(reference), np.zeros(4), np.multiply(m, across)])
    near(model.torque(motion, linear), expected(reference, motion))


@quick
@given(pairs, pairs, pairs, st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), seeds)
def test_tilt_and_knee_zero(m, inertia, along, tilt, offset, seed):
    model = Model.standard().with_effect("gravity_tilt").with_effect("encoder_offset_knee")
    reference = Leg(m, inertia, along, tilt=tilt, offset=(0.0, offset))
    motion = random_motion(seed)
    linear = np.concatenate([base_parameters(reference), np.zeros(4)])
    near(model.torque(motion, linear, np.array([tilt, offset])), expected(reference, motion))
    # Nothing but gravity knows where down is, so the hip's zero is the tilt.
    near(expected(replace(reference, tilt=0.0, offset=(tilt, offset)), motion), expected(reference, motion))


@pytest.mark.slow
@quick
@given(pairs, pairs, pairs, st.tuples(unit, unit, unit, unit), st.tuples(st.floats(0.2, 5.0), unit), seeds)
def test_moving_base_on_a_leg_off_axis(m, inertia, along, sway, shape, seed):
    """Coefficients that multiply each other (amplitude × first moment) are counted once."""
    model = Model.standard().with_effect("base_motion").with_effect("com_offset_shank")
    reference, motion = Leg(m, inertia, along, (0.0, 0.2)), random_motion(seed)
    linear = np.concatenate([base_parameters(reference), np.zeros(4), sway, [0.2 * m[1]]])
    phase = 2 * np.pi * shape[0] * motion.t + shape[1]
    x = sway[0] * np.sin(phase) + sway[1] * np.cos(phase)
    z = sway[2] * np.sin(phase) + sway[3] * np.cos(phase)
    rows = zip(motion.q, motion.dq, motion.ddq, zip(x, z, strict=True), strict=True)
    wanted = np.array([torque(reference, q, dq, ddq, base) for q, dq, ddq, base in rows])
    assert model.needs_reference
    near(model.torque(motion, linear, np.array(shape)), wanted)


@quick
@given(st.floats(0.2, 0.7), st.floats(1.0, 20.0), seeds)
def test_geometry(length, gravity, seed):
    reference = Leg((3.0, 2.0), (0.1, 0.05), (0.2, 0.15), length=length, g=gravity)
    motion = random_motion(seed)
    linear = np.concatenate([base_parameters(reference), np.zeros(4)])
    model = Model.standard(length, gravity)
    from exoid.symbolic.codegen.kernel import compiled

    near(compiled(model, "vm").inverse_dynamics(motion, linear), expected(reference, motion))


def test_the_papers_base_parameters_come_out_of_the_elimination():
    form = derive_regressor(leg())
    assert [str(p) for p in form.parameters] == [
        "I_sh + I_th + a_th**2*m_sh + l_sh**2*m_sh + l_th**2*m_th",
        "I_sh + l_sh**2*m_sh",
        "a_th*l_sh*m_sh",
        "-I_th + a_th*l_th*m_th - l_th**2*m_th",
    ]
    assert all(entry == 0 for entry in form.known)


def test_the_papers_columns():
    """Y as corrected: second derivatives in entry (1, 3)."""
    motion = random_motion(3)
    (q1, q2), (v1, v2), (a1, a2) = motion.q.T, motion.dq.T, motion.ddq.T
    e, zero = 9.81 / 0.4, np.zeros(SAMPLES)
    s1, s2, c2, s12 = np.sin(q1), np.sin(q2), np.cos(q2), np.sin(q1 + q2)
    y13 = c2 * (2 * a1 + a2) - s2 * (2 * v1 * v2 + v2**2) + e * s12
    y23 = c2 * a1 + s2 * v1**2 + e * s12
    rows = [
        [a1 + e * s1, a2 - e * s1, y13, e * s1, np.sign(v1), v1, zero, zero],
        [zero, a1 + a2, y23, zero, zero, zero, np.sign(v2), v2],
    ]
    near(Model.standard().columns(motion), np.moveaxis(np.array(rows), 1, 2))


def test_printing_error_is_found():
    (entry,) = compare_with_printed()
    assert (entry.row, entry.column) == (1, 3)
    assert "ddtheta1" in entry.derived and "ddtheta1" not in entry.printed
    assert "entry (1, 3)" in str(entry)


@pytest.mark.slow
@pytest.mark.parametrize("effects", [(), ("com_offset_shank", "gravity_tilt", "encoder_offset_knee", "base_motion")])
def test_every_check_holds(effects):
    model = Model.standard()
    for effect in effects:
        model = model.with_effect(effect)
    found = check_equations(model)
    assert [str(one) for one in found if not one.holds] == []
    names = [one.name for one in found]
    assert "M' - 2C is skew-symmetric" in names and "energy balance" in names
    assert ("M is positive definite", "proved") in [(one.name, one.how) for one in found] or effects


def test_three_links_derive_too():
    """Nothing in the derivation knows that a leg has two links: one inertia and one first moment per link."""
    form = derive_regressor(chain("a", "b", "c"))
    assert form.matrix.shape == (3, len(form.parameters))
    assert len(form.parameters) == 6


def test_sign_of_a_standing_joint_is_the_motions():
    motion = Motion(np.zeros(2), np.zeros((2, 2)), np.full((2, 2), 1e-9), np.zeros((2, 2)), np.full((2, 2), 0.25))
    assert Model.standard().columns(motion)[0, :, 4] == pytest.approx([0.25, 0.25])
