"""The compiled leg against Pinocchio, which knows nothing of ours: M, bias forces, forward dynamics, Jacobians."""

import numpy as np
import pytest

from exoid.measurement.bench.leg import random_leg
from exoid.symbolic import Model, Motion
from exoid.symbolic.codegen.kernel import compiled

pin = pytest.importorskip("pinocchio")


def robot_of(leg):
    """The same leg, built from its segments: it hangs along -z, joints turn so that positive is to the front."""
    robot = pin.Model()
    axis, parent = pin.JointModelRY(), 0
    for name, segment, place in (
        ("hip", leg.thigh, np.zeros(3)),
        ("knee", leg.shank, np.array([0.0, 0.0, -leg.thigh_length])),
    ):
        parent = robot.addJoint(parent, axis, pin.SE3(np.eye(3), place), name)
        inertia = np.diag([segment.inertia] * 3)
        robot.appendBodyToJoint(
            parent, pin.Inertia(segment.mass, np.array([0.0, 0.0, -segment.com]), inertia), pin.SE3.Identity()
        )
    return robot


@pytest.mark.parametrize("seed", range(5))
def test_everything_pinocchio_computes_as_well(seed):
    rng = np.random.default_rng(seed)
    leg = random_leg(rng)
    robot = robot_of(leg)
    data = robot.createData()
    model = Model.standard(thigh_length=leg.thigh_length)
    linear = np.array([*leg.base[:4], 0.0, 0.0, 0.0, 0.0])
    ours = compiled(model)
    along = 0.27
    frame = robot.addFrame(
        pin.Frame("cuff", 2, pin.SE3(np.eye(3), np.array([0.0, 0.0, -along])), pin.FrameType.OP_FRAME)
    )
    data = robot.createData()
    for _ in range(10):
        q, dq, ddq, tau = rng.uniform(-1.5, 1.5, (4, 2))
        # A turn about +y carries a hanging link to the back: our positive is to the front, hence -q there.
        motion = Motion(np.zeros(1), q[None], dq[None], ddq[None])
        np.testing.assert_allclose(ours.mass_matrix(motion, linear)[0], pin.crba(robot, data, -q), atol=1e-11)
        bias = -pin.rnea(robot, data, -q, -dq, np.zeros(2))
        found = ours.coriolis(motion, linear)[0] @ dq + ours.gravity(motion, linear)[0]
        np.testing.assert_allclose(found, bias, atol=1e-10)
        np.testing.assert_allclose(
            ours.gravity(motion, linear)[0], -pin.computeGeneralizedGravity(robot, data, -q), atol=1e-10
        )
        wanted = -pin.aba(robot, data, -q, -dq, -tau)
        np.testing.assert_allclose(ours.forward_dynamics(motion, tau[None], linear)[0], wanted, rtol=1e-9, atol=1e-9)
        pin.forwardKinematics(robot, data, -q)
        pin.updateFramePlacements(robot, data)
        full = pin.computeFrameJacobian(robot, data, -q, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        np.testing.assert_allclose(ours.jacobian(motion, along)[0], -full[[0, 2]], atol=1e-11)
