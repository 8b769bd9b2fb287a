"""The leg in MuJoCo, a plant that is not ours: what it does without contacts is our equation of motion."""

import numpy as np
import pytest

from exoid.measurement.bench.leg import Leg, Segment
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install 'exoid[peers]'")

from benchmarks import mujoco_chains
from benchmarks.mujoco_leg import CASES, simulate


def left_over(name, seconds=2.0):
    """Return what our model with the leg's true numbers leaves of MuJoCo's torque, and that torque."""
    built = CASES[name][0]
    friction = (built.dry[0], built.viscous[0], built.dry[1], built.viscous[1])
    own = Leg.of("the same", Segment(9.5, 0.18, 0.14), Segment(6.0, 0.22, 0.11), friction)
    seen, (q, dq, ddq, tau) = simulate(built, 0, 0, seconds, noise=False)
    return tau - Model.standard().torque(Motion(seen.t, q, dq, ddq), np.array(own.base)), tau


def test_the_equation_of_motion_is_mujocos():
    left, _ = left_over("nothing")
    # Where a joint sticks MuJoCo's friction is anything up to the dry one; the median knows nothing of that.
    assert np.median(np.abs(left), axis=0).max() < 1e-9


@pytest.mark.parametrize("name", ["tendon", "sway"])
def test_what_is_built_in_shows(name):
    left, tau = left_over(name)
    assert np.median(np.abs(left), axis=0).max() > 0.02 * tau.std()


@pytest.mark.parametrize(("effect", "enough"), [("nothing", True), ("joint_spring", False)])
def test_the_equation_of_motion_of_a_chain_is_mujocos(effect, enough):
    rng = np.random.default_rng(3)
    chain = mujoco_chains.Chain.of(f"{effect}:{'hip' if enough else 'ankle'}", rng)
    seen, motion = mujoco_chains.simulate(chain, rng, "run", seconds=3.0, noise=False)
    model = Model("chain", limits={}, joints=chain.joints)
    moving = np.all(np.abs(motion.dq) > 0.05, axis=1)  # where a joint sticks friction is anything up to the dry one
    columns, torque = model.columns(motion)[:, moving].reshape(-1, len(model.parameters)), seen.tau[moving].T.ravel()
    left = torque - columns @ np.linalg.lstsq(columns, torque, rcond=None)[0]
    assert moving.sum() > 50 and bool(np.abs(left).max() < 1e-6 * torque.std()) is enough
