"""One millisecond of the leg on the bench: encoder, controller, motors, and the leg's own equation of motion.

A step of length `dt` is centred on its time stamp (implicit midpoint): with the mean acceleration `a` of the
step,

    q_m = q + dt/2 v + dt²/8 a,    v_m = v + dt/2 a,    M(q_m) a + h(q_m, v_m, a, s) = τ,    v⁺ = v + dt a,

so that what is recorded at the time stamp (q_m, v_m, a, s, τ) satisfies the model's equation exactly, and
smooth damping is treated implicitly. Every sgn θ' is a set: s_j lies in [-1, 1], and equals sgn v⁺_j when
joint j moves. The two s are found together, as the minimum of a convex quadratic over a box (Moreau's time
stepping), never by switching: a joint that sticks has exactly v = 0, it does not creep and it does not
chatter.

Source: Moreau, "Numerical aspects of the sweeping process", Comput. Methods Appl. Mech. Eng. 177, 1999.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from exoid.symbolic.codegen.equation import Expressions

NEWTON_STEPS = 5
"""Corrections of `a` per step. Two leave 1e-9 N·m on smooth motion; friction that grows with load needs five.
"""

SOFT = 5e-3
"""rad/s over which a sign is smeared whose friction pushes instead of braking: no set-valued law exists for
it.
"""

TINY = 1e-12

EXACT, SWEEPS = 3, 30
"""Joints up to which the friction of a step is found exactly, and sweeps of the approximation beyond."""


def _play(value: Any, old: Any, new: Any, half_width: Any) -> Any:
    import casadi as ca

    return ca.fmin(ca.fmax(value, new - half_width), new + half_width)


def _dahl(value: Any, old: Any, new: Any, sigma: Any) -> Any:
    import casadi as ca

    side = ca.sign(new - old)
    return side + (value - side) * ca.exp(-sigma * ca.fabs(new - old))


REMEMBERED: dict[str, tuple[Callable[[Any], Any], Callable[..., Any]]] = {
    "play": (lambda x: x, _play), "dahl": (lambda x: 0.0 * x, _dahl)
}  # fmt: skip
"""Operators that the leg itself can have, because their state moves with the joint: `start(x)` is the value when it is
switched on, `update(value, old_x, new_x, parameter)` the value after x moved on; all in CasADi SX."""


def friction_impulse(ca: Any, weight: Any, free: Any, bound: Any) -> Any:
    """Return the friction torques λ (J,) with |λ_j| <= bound_j that oppose the velocity free - weight λ at
    every joint.

    The minimum of ½ λ'Wλ - free'λ over a box is inside or on one of its faces, where it is that of a box of one
    dimension less. With more than `EXACT` joints it is approached joint by joint (Gauss-Seidel).
    """
    count = free.numel()
    if count == 1:
        return ca.fmin(ca.fmax(free / weight, -bound), bound)
    if count > EXACT:
        return _joint_by_joint(ca, weight, free, bound)
    inside = ca.mtimes(ca.inv(weight), free)
    out = ca.logic_not(ca.mmin(bound - ca.fabs(inside)) >= 0.0)
    best, cost = inside, ca.if_else(out, ca.inf, _energy(ca, weight, free, inside))
    for j in range(count):
        others = [k for k in range(count) if k != j]
        for side in (1, -1):
            fixed = side * bound[j]
            rest = friction_impulse(
                ca, weight[others, others], free[others] - weight[others, j] * fixed, bound[others]
            )
            beside = ca.vertsplit(rest)
            trial = ca.vertcat(*beside[:j], fixed, *beside[j:])
            height = _energy(ca, weight, free, trial)
            better = height < cost
            best, cost = ca.if_else(better, trial, best), ca.if_else(better, height, cost)
    return best


def _joint_by_joint(ca: Any, weight: Any, free: Any, bound: Any) -> Any:
    """Return the friction torques (J,) by sweeps over the joints, each of which moves one to its best."""
    count = free.numel()
    impulse = [ca.SX(0)] * count
    for _ in range(SWEEPS):
        for j in range(count):
            pushed = sum((weight[j, k] * impulse[k] for k in range(count) if k != j), ca.SX(0))
            impulse[j] = ca.fmin(ca.fmax((free[j] - pushed) / weight[j, j], -bound[j]), bound[j])
    return ca.vertcat(*impulse)


def _energy(ca: Any, weight: Any, free: Any, impulse: Any) -> Any:
    return 0.5 * ca.dot(impulse, ca.mtimes(weight, impulse)) - ca.dot(free, impulse)


def _midpoint(ca: Any, form: Expressions, dt: float) -> Any:
    """Return the residual of the equation at mid-step and its derivatives, as one CasADi function of (a, s)."""
    count, joints = len(form.memories), form.q.numel()
    a, s = ca.SX.sym("a", joints), ca.SX.sym("s", joints)
    q, v = ca.SX.sym("q", joints), ca.SX.sym("v", joints)
    last, value = ca.SX.sym("last", count), ca.SX.sym("value", count)
    q_m, v_m = q + 0.5 * dt * v + 0.125 * dt**2 * a, v + 0.5 * dt * a

    def at(expression: Any, memory: Any) -> Any:
        names = [form.q, form.dq, form.ddq, form.sign, form.memory]
        return ca.substitute([ca.SX(expression)], names, [q_m, v_m, a, s, memory])[0]

    blank, none = ca.SX.zeros(count), ca.SX(0, 1)
    now = ca.vertcat(none, *(at(entry.argument, blank) for entry in form.memories))
    values = [
        REMEMBERED[item.operator][1](value[k], last[k], now[k], at(item.parameter, blank))
        for k, item in enumerate(form.memories)
    ]
    memory = ca.vertcat(none, *values)
    residual = at(form.torque, memory)
    by_a, by_s = ca.jacobian(residual, a), ca.diag(ca.jacobian(residual, s))
    return ca.Function(
        "midpoint",
        [a, s, q, v, form.t, last, value, form.linear, form.shape, form.base_motion, form.force],
        [residual, 0.5 * (by_a + by_a.T), by_s, now, memory, q_m, v_m],
    )


def step_function(form: Expressions, dt: float, reach: Sequence[float] | None = None) -> Any:
    """Return the CasADi function (state, input, numbers) -> (state, record) of one step of `dt` s of a model's `form`.

    state  (6J + 2K): q, v, a, s at the start of the step, last encoder reading, filtered velocity, and the
    operators'
           arguments and values;
    input  (1 + 4J + B + C): t, θ_d, θ_d', encoder noise, external torque N·m, motion of the base (B: 5, or 0 where it
           stands), measured forces (C);
    numbers (3J + 2 + P + S): gains on angle and on velocity, torque limits, smoothing of the differentiator, encoder
           step in rad, then the model's; record (6J): q_m, v_m, a, s, τ motor, residual of the equation.
    `reach` (J,) is what of its own unit each joint moves where a turning one moves 1 rad.
    """
    import casadi as ca

    count, joints = len(form.memories), form.q.numel()
    fixed = 3 * joints + 2
    state = ca.SX.sym("state", 6 * joints + 2 * count)
    first = 1 + 4 * joints + form.base_motion.numel()
    given = ca.SX.sym("given", first + form.force.numel())
    outside = given[1 + 4 * joints : first], given[first:]
    numbers = ca.SX.sym("numbers", fixed + form.linear.numel() + form.shape.numel())
    q, v, a, s, reading, speed = (state[joints * k : joints * (k + 1)] for k in range(6))
    wanted, wanted_speed, noise, external = (given[1 + joints * k : 1 + joints * (k + 1)] for k in range(4))
    last, value = state[6 * joints : 6 * joints + count], state[6 * joints + count :]
    kp, kd, limit = (numbers[joints * k : joints * (k + 1)] for k in range(3))
    smoothing, resolution = numbers[fixed - 2], numbers[fixed - 1] * ca.DM(reach or [1.0] * joints)
    linear = numbers[fixed : fixed + form.linear.numel()]
    shape = numbers[fixed + form.linear.numel() :]

    encoder = q + noise
    coarse = ca.fmax(resolution, 1e-30)
    encoder = ca.if_else(resolution > 0, ca.floor(encoder / coarse + 0.5) * coarse, encoder)
    speed = speed + smoothing * ((encoder - reading) / dt - speed)
    motor = kp * (wanted - encoder) + kd * (wanted_speed - speed)
    motor = ca.fmin(ca.fmax(motor, -limit), limit)
    supplied = motor + external

    midpoint = _midpoint(ca, form, dt)
    for _ in range(NEWTON_STEPS):
        residual, mass, friction, *_ = midpoint(a, s, q, v, given[0], last, value, linear, shape, *outside)
        bound = ca.fmax(friction, 0.0)
        inverse = ca.inv(mass)
        # The friction inside the residual is taken out, then put back as the unknown of the box problem.
        soft = ca.tanh((v + 0.5 * dt * a) / SOFT)
        pushed = ca.if_else(friction < 0, friction * (soft - s), -friction * s)
        without = a + ca.mtimes(inverse, supplied - residual - pushed)
        impulse = friction_impulse(ca, dt * inverse, v + dt * without, bound)
        a = without - ca.mtimes(inverse, impulse)
        share = ca.if_else(bound > TINY, impulse / ca.fmax(bound, TINY), ca.sign(v + dt * a))
        s = ca.if_else(friction < 0, soft, share)
    # A joint that sticks ends the step at rest exactly; 1e-17 rad/s of round-off would have a sign.
    sticks = ca.logic_and(ca.fabs(impulse) < bound, bound > TINY)
    a = ca.if_else(sticks, -v / dt, a)
    velocity = ca.if_else(sticks, 0.0, v + dt * a)
    residual, _, _, now, memory, q_m, v_m = midpoint(a, s, q, v, given[0], last, value, linear, shape, *outside)

    after = ca.vertcat(q + dt * v + 0.5 * dt**2 * a, velocity, a, s, encoder, speed, now, memory)
    record = ca.vertcat(q_m, v_m, a, s, motor, residual - supplied)
    return ca.Function("step", [state, given, numbers], [after, record])
