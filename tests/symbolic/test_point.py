"""Points on links: where they are and how they move, against geometry, finite differences and virtual work."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ground.errors import EffectError
from symbolic import Model, Motion
from symbolic.codegen.kernel import compiled
from symbolic.mechanics.lagrange import mechanics
from symbolic.mechanics.mechanism import leg, real
from symbolic.point import jacobian, position
from tests.newton_euler import Leg, torque

places = st.tuples(st.floats(-0.2, 0.6), st.floats(-0.2, 0.2))
seeds = st.integers(0, 2**32 - 1)


def states(seed, n=5):
    rng = np.random.default_rng(seed)
    return Motion(np.arange(float(n)), *(rng.normal(size=(n, 2)) for _ in range(3)))


def moved(motion, joint, step):
    q = motion.q.copy()
    q[:, joint] += step
    return Motion(motion.t, q, motion.dq, motion.ddq)


@settings(max_examples=20, deadline=None)
@given(places, seeds, st.sampled_from(["thigh", "shank"]))
def test_jacobian_is_the_slope_of_the_position(place, seed, link):
    model, motion = Model.standard(thigh_length=0.37).with_effect("encoder_offset_knee"), states(seed)
    given_shape = np.array([0.13])
    found = jacobian(model, motion, link, *place, shape=given_shape)
    for joint in range(2):
        up, down = (position(model, moved(motion, joint, s), link, *place, shape=given_shape) for s in (1e-6, -1e-6))
        np.testing.assert_allclose(found[:, :, joint], (up - down) / 2e-6, atol=1e-8)


def test_a_hanging_leg_and_a_bent_one():
    model = Model.standard(thigh_length=0.4)
    still = Motion(np.zeros(2), np.array([[0.0, 0.0], [np.pi / 2, -np.pi / 2]]), np.zeros((2, 2)), np.zeros((2, 2)))
    np.testing.assert_allclose(position(model, still, "shank", 0.3, 0.05), [[0.05, -0.7], [0.45, -0.3]], atol=1e-12)
    np.testing.assert_allclose(position(model, still, "thigh", 0.3), [[0.0, -0.3], [0.3, 0.0]], atol=1e-12)


@settings(max_examples=10, deadline=None)
@given(st.floats(0.0, 0.6), seeds)
def test_the_generated_jacobian_is_that_of_a_point_on_the_shank(reach, seed):
    model, motion = Model.standard(), states(seed)
    np.testing.assert_allclose(
        jacobian(model, motion, "shank", reach), compiled(model).jacobian(motion, reach), atol=1e-12
    )


@settings(max_examples=3, deadline=None)
@given(st.floats(0.1, 5.0), st.floats(0.0, 0.5), st.floats(-0.2, 0.2), seeds)
def test_a_payload_is_one_more_mass(mass, along, across, seed):
    """Torque is linear in masses: that of leg and payload together is the sum of each alone."""
    values = {"m_th": 9.0, "m_sh": 6.0, "I_th": 0.14, "I_sh": 0.11, "l_th": 0.18, "l_sh": 0.22, "a_th": 0.4, "g": 9.81}
    names = [real(n) for n in ("payload", "down", "front")]
    loaded = mechanics(leg().with_payload("shank", *names)).torque
    numbers = values | {"payload": mass, "down": along, "front": across}
    motion = states(seed, 3)
    plain = Leg((9.0, 6.0), (0.14, 0.11), (0.18, 0.22))
    weight = Leg((0.0, mass), (0.0, 0.0), (0.0, along), (0.0, across))
    for q, dq, ddq in zip(motion.q, motion.dq, motion.ddq, strict=True):
        state = {
            f"{s}{k + 1}": float(v[k]) for s, v in (("theta", q), ("dtheta", dq), ("ddtheta", ddq)) for k in (0, 1)
        }
        at = {s: {**numbers, **state}[s.name] for s in loaded.free_symbols}
        found = np.array(loaded.subs(at), dtype=float).ravel()
        np.testing.assert_allclose(found, torque(plain, q, dq, ddq) + torque(weight, q, dq, ddq), rtol=1e-9, atol=1e-9)


def test_a_link_that_is_not_there_is_refused():
    with pytest.raises(EffectError, match="no link 'foot'"):
        position(Model.standard(), states(0), "foot")
