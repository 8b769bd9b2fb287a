"""The plant against independent ground: a Newton-Euler leg, SciPy's integrator, energy, and sticking."""

from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.plant import friction_impulse, step_function
from exoid.measurement.bench.simulation import integrate

DT, G, LEG = 1e-3, 9.81, standard_leg()
COULOMB = (4.0, 3.0)


def newton_euler(q, dq, ddq, ops):
    """Torque of the frictionless standard leg by forces on each segment, written without any lumped
    parameter.
    """
    thigh, shank, a = LEG.thigh, LEG.shank, LEG.thigh_length
    p1, w1, e1 = q[0], dq[0], ddq[0]
    p2, w2, e2 = p1 + q[1], w1 + dq[1], e1 + ddq[1]

    def accelerate(length, angle, rate, turn):
        along = [ops.sin(angle), -ops.cos(angle)]
        out = [ops.cos(angle), ops.sin(angle)]
        return [length * (turn * out[k] - rate**2 * along[k]) for k in (0, 1)]

    com1 = accelerate(thigh.com, p1, w1, e1)
    knee = accelerate(a, p1, w1, e1)
    com2 = [x + y for x, y in zip(knee, accelerate(shank.com, p2, w2, e2), strict=True)]
    f2 = [shank.mass * com2[0], shank.mass * (com2[1] + G)]
    f1 = [thigh.mass * com1[0], thigh.mass * (com1[1] + G)]
    arm2 = [shank.com * ops.sin(p2), -shank.com * ops.cos(p2)]
    arm1 = [thigh.com * ops.sin(p1), -thigh.com * ops.cos(p1)]
    armk = [a * ops.sin(p1), -a * ops.cos(p1)]
    tau2 = shank.inertia * e2 + arm2[0] * f2[1] - arm2[1] * f2[0]
    tau1 = tau2 + thigh.inertia * e1 + arm1[0] * f1[1] - arm1[1] * f1[0]
    tau1 = tau1 + armk[0] * f2[1] - armk[1] * f2[0]
    return tau1, tau2


def plant(coulomb=(0.0, 0.0), viscous=(0.0, 0.0), extra=None, dt=DT):
    """A step function of the Newton-Euler leg with friction; no controller as long as its gains are zero."""
    q, dq, ddq, s = (ca.SX.sym(name, 2) for name in ("q", "dq", "ddq", "s"))
    rigid = ca.vertcat(*newton_euler([q[0], q[1]], [dq[0], dq[1]], [ddq[0], ddq[1]], ca))
    torque = rigid + ca.DM(coulomb) * s + ca.DM(viscous) * dq
    torque = torque if extra is None else torque + extra(q, dq, ddq, s)
    none = {name: ca.SX.sym(name, 0) for name in ("linear", "shape", "memory", "base_motion", "force")}
    form = SimpleNamespace(t=ca.SX.sym("t"), q=q, dq=dq, ddq=ddq, sign=s, torque=torque, memories=(), **none)
    return step_function(form, dt)


def run(step, q0, dq0, count, external, dt=DT):
    """Integrate without controller; `external(t)` (N, 2) is the torque at the joints."""
    # A record is centred on its time stamp: the first step begins at t = 0, half a step before its stamp.
    t = (np.arange(count) + 0.5) * dt
    given = np.zeros((9, count))
    given[0], given[7:9] = t, external(t).T
    state = np.concatenate([q0, dq0, np.zeros(8)])
    record = integrate(step, state, given, np.array([0, 0, 0, 0, 1e6, 1e6, 1.0, 0.0]))
    return t, record[0:2].T, record[2:4].T, record[4:6].T, record[6:8].T, record[10:12].T


def drive(t):
    return np.column_stack([12.0 + 9.0 * np.sin(2.0 * t), -6.0 + 4.0 * np.cos(3.1 * t)])


def test_a_smooth_motion_agrees_with_scipy():
    def slope(t, x):
        bias = np.array(newton_euler(x[:2], x[2:], [0.0, 0.0], np)) + np.array([2.0, 1.2]) * x[2:]
        column = [np.array(newton_euler(x[:2], x[2:], unit, np)) for unit in ([1.0, 0.0], [0.0, 1.0])]
        rest = np.array(newton_euler(x[:2], x[2:], [0.0, 0.0], np))
        mass = np.column_stack([c - rest for c in column])
        return np.concatenate([x[2:], np.linalg.solve(mass, drive(np.array([t]))[0] - bias)])

    start = np.array([0.3, -0.9, 0.2, -0.1])
    t, q, dq, *_ = run(plant(viscous=(2.0, 1.2)), start[:2], start[2:], 3000, drive)
    exact = solve_ivp(slope, (0.0, 3.0), start, t_eval=t, rtol=1e-10, atol=1e-12, method="DOP853")
    assert q == pytest.approx(exact.y[:2].T, abs=5e-6)
    assert dq == pytest.approx(exact.y[2:].T, abs=5e-5)


def test_stick_and_slip_converge_with_the_step():
    def late(t):
        return drive(t) * np.minimum(1.0, t[:, None] / 0.5)

    step, fine = plant(COULOMB, (1.0, 0.5)), plant(COULOMB, (1.0, 0.5), dt=DT / 10)
    t, q, dq, *_ = run(step, [0.3, -0.9], [0.0, 0.0], 4_000, late)
    t_fine, q_fine, *_ = run(fine, [0.3, -0.9], [0.0, 0.0], 40_000, late, DT / 10)
    assert np.mean(dq == 0.0) > 0.02
    for j in (0, 1):
        assert q[:, j] == pytest.approx(np.interp(t, t_fine, q_fine[:, j]), abs=2e-4)


def test_energy_is_what_was_put_in_less_what_friction_took():
    t, q, dq, _ddq, sign, _ = run(plant(COULOMB, (2.0, 1.2)), [0.3, -0.9], [0.0, 0.0], 5000, drive)
    thigh, shank, a = LEG.thigh, LEG.shank, LEG.thigh_length

    def energy(q, dq):
        p2, w2 = q.sum(axis=1), dq.sum(axis=1)
        knee = np.column_stack([a * np.sin(q[:, 0]), -a * np.cos(q[:, 0])])
        v_knee = np.column_stack([a * np.cos(q[:, 0]), a * np.sin(q[:, 0])]) * dq[:, :1]
        v_com = v_knee + np.column_stack([np.cos(p2), np.sin(p2)]) * (shank.com * w2)[:, None]
        kinetic = 0.5 * (
            (thigh.inertia + thigh.mass * thigh.com**2) * dq[:, 0] ** 2
            + shank.inertia * w2**2
            + shank.mass * (v_com**2).sum(axis=1)
        )
        height = knee[:, 1] - shank.com * np.cos(p2)
        return kinetic - G * thigh.mass * thigh.com * np.cos(q[:, 0]) + G * shank.mass * height

    power = ((drive(t) - np.array(COULOMB) * sign - np.array([2.0, 1.2]) * dq) * dq).sum(axis=1)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * DT)])
    stored = energy(q, dq)
    assert np.ptp(stored) > 1.0
    assert stored - stored[0] == pytest.approx(work, abs=5e-3)
    # Only the one step in which a joint runs through zero has the sign of its end, not of its middle.
    fed = -np.minimum(sign * dq, 0.0).sum() * DT * max(COULOMB)
    assert fed < 1e-4, "friction takes energy"


def test_below_coulomb_nothing_creeps():
    hold = np.array(newton_euler([0.4, -0.8], [0.0, 0.0], [0.0, 0.0], np))
    share = np.array([0.95, -0.95])
    _t, q, dq, _ddq, sign, _ = run(
        plant(COULOMB),
        [0.4, -0.8],
        [0.0, 0.0],
        20_000,
        lambda t: np.tile(hold + share * COULOMB, (t.size, 1)),
    )
    assert np.all(dq == 0.0) and np.all(q == q[0])
    assert sign[-1] == pytest.approx(share, abs=1e-9)


def test_just_above_coulomb_it_slips():
    hold = np.array(newton_euler([0.4, -0.8], [0.0, 0.0], [0.0, 0.0], np))
    push = hold + np.array([0.0, 1.05 * COULOMB[1]])
    *_, dq, _, sign, _ = run(plant(COULOMB), [0.4, -0.8], [0.0, 0.0], 300, lambda t: np.tile(push, (t.size, 1)))
    assert dq[-1, 1] > 0.01 and sign[-1, 1] == pytest.approx(1.0)


def test_a_sliding_joint_comes_to_rest_without_chatter():
    hold = np.array(newton_euler([0.4, -0.8], [0.0, 0.0], [0.0, 0.0], np))
    *_, dq, _, _sign, _ = run(plant(COULOMB), [0.4, -0.8], [0.8, -0.9], 2000, lambda t: np.tile(hold, (t.size, 1)))
    for j in (0, 1):
        assert np.all(dq[-500:, j] == 0.0)
        assert np.count_nonzero(np.diff(np.sign(dq[:, j]))) <= 3


def test_steep_and_strong_damping_stays_stable():
    def extra(q, dq, ddq, s):
        return ca.vertcat(30.0 * ca.tanh(dq[0] / 1e-3), 400.0 * dq[1])

    *_, dq, _ddq, _, residual = run(plant(COULOMB, extra=extra), [0.4, -0.8], [0.5, 0.5], 1500, drive)
    assert np.isfinite(dq).all() and np.abs(dq[-100:]).max() < 0.2
    assert np.abs(residual[-100:]).max() < 1e-3


def test_negative_coulomb_runs_and_satisfies_its_equation():
    *_, dq, _ddq, _sign, residual = run(plant((-1.0, 2.0)), [0.4, -0.8], [0.0, 0.0], 2000, drive)
    assert np.isfinite(dq).all() and np.median(np.abs(residual)) < 1e-6


@settings(max_examples=40, deadline=None)
@given(
    st.floats(0.1, 10), st.floats(0.1, 10), st.floats(-0.95, 0.95),
    st.floats(-5, 5), st.floats(-5, 5), st.floats(0, 4), st.floats(0, 4),
)  # fmt: skip
def test_friction_impulse_is_the_minimum_over_the_box(w11, w22, rho, f1, f2, b1, b2):
    weight = np.array([[w11, rho * np.sqrt(w11 * w22)], [rho * np.sqrt(w11 * w22), w22]])
    free, bound = np.array([f1, f2]), np.array([b1, b2])
    found = np.array(friction_impulse(ca, ca.DM(weight), ca.DM(free), ca.DM(bound))).ravel()

    def cost(x):
        return 0.5 * x @ weight @ x - free @ x

    box = list(zip(-bound, bound, strict=True))
    best = minimize(cost, np.zeros(2), jac=lambda x: weight @ x - free, bounds=box, method="L-BFGS-B")
    assert np.all(np.abs(found) <= bound + 1e-12)
    assert cost(found) <= best.fun + 1e-7
