"""A Python module that needs only NumPy: the torque along a whole motion, readable and without exoid."""

from __future__ import annotations

from types import MappingProxyType

from exoid.ground.text import in_comment
from exoid.symbolic.codegen.fingerprint import model_key
from exoid.symbolic.codegen.instructions import FORMS, Language, scalar_c
from exoid.workbench.identified import Options, Ready

HELP = "a Python module with only NumPy in it"

NUMPY = Language(
    MappingProxyType(
        {
            **FORMS,
            "SQRT": "np.sqrt({a})", "SIN": "np.sin({a})", "COS": "np.cos({a})", "TAN": "np.tan({a})",
            "EXP": "np.exp({a})", "LOG": "np.log({a})", "POW": "({a}) ** ({b})", "CONSTPOW": "({a}) ** ({b})",
            "TANH": "np.tanh({a})", "FABS": "np.abs({a})", "SIGN": "np.sign({a})", "FMIN": "np.minimum({a}, {b})",
            "FMAX": "np.maximum({a}, {b})", "FLOOR": "np.floor({a})", "CEIL": "np.ceil({a})",
            "LT": "1.0 * ({a} < {b})", "LE": "1.0 * ({a} <= {b})", "EQ": "1.0 * ({a} == {b})",
            "NE": "1.0 * ({a} != {b})", "NOT": "1.0 * ({a} == 0.0)",
            "AND": "1.0 * np.logical_and({a}, {b})", "OR": "1.0 * np.logical_or({a}, {b})",
            "IF_ELSE_ZERO": "np.where({a} != 0.0, {b}, 0.0)",
        }
    ),
    "{place} = {value}",
)  # fmt: skip

HELD = '''
def held(x):
    """Return x (N,) with the last finite value before it in place of what is not finite (0 where there is none)."""
    last = np.maximum.accumulate(np.where(np.isfinite(x), np.arange(len(x)), -1))
    return np.where(last < 0, 0.0, x[last])

'''
OPERATORS = {
    "play": HELD
    + '''
def play(t, x, h):
    """Return what follows x (N,) through a gap of half-width h; a sample that is not finite leaves it as it was."""
    gap, x = x - x, held(x)
    out, w = np.empty_like(x), x[0]
    for k, value in enumerate(x):
        w = value - h if value - h > w else value + h if value + h < w else w
        out[k] = w
    return out + gap
''',
    "dahl": HELD
    + '''
def dahl(t, x, sigma):
    """Return the Dahl friction state (N,), between -1 and 1, along x (N,); not finite samples leave it as it was."""
    gap, x = x - x, held(x)
    out = np.zeros_like(x)
    for k, step in enumerate(np.diff(x)):
        keep = np.exp(-sigma * abs(step))
        out[k + 1] = keep * out[k] + np.sign(step) * (1.0 - keep)
    return out + gap
''',
    "delay": '''
def delay(t, x, d):
    """Return x (N,) as it was d seconds before; the values at the edges are held."""
    return np.interp(t - d, t, x)
''',
    "lag": '''
def lag(t, x, T):
    """Return x (N,) behind a filter of first order with a time constant of T s."""
    out = np.array(x, dtype=float)
    for k, share in enumerate(-np.expm1(-np.diff(t) / max(T, 1e-30)), start=1):
        out[k] = out[k - 1] + share * (x[k] - out[k - 1])
    return out
''',
    "slow": '''
def slow(t, x, f):
    """Return x (N,) smoothed by a Gaussian that halves the power at f Hz."""
    step = (t[-1] - t[0]) / (len(t) - 1)
    even = t[0] + step * np.arange(len(t))
    width = np.sqrt(np.log(2.0)) / (2.0 * np.pi * f) / step
    reach = min(int(np.ceil(4.0 * width)), len(t) - 1)
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    y = np.interp(even, t, x)
    y = np.concatenate([2.0 * y[0] - y[reach:0:-1], y, 2.0 * y[-1] - y[-2 : -reach - 2 : -1]])
    return np.interp(t, even, np.convolve(y, weight / weight.sum(), mode="valid"))
''',
    "ddt": '''
def ddt(t, x):
    """Return dx/dt (N,)."""
    return np.gradient(x, t, edge_order=2 if len(t) > 2 else 1)
''',
}


def write(ready: Ready, options: Options) -> dict[str, str]:
    """Return {file name: text}."""
    used = dict.fromkeys(m.operator for m in ready.memories)
    sign = "np.sign(dq)" if options.sign_width == 0.0 else f"np.tanh(dq / {options.sign_width!r})"
    model, moving = ready.model, ready.model.moving_base
    size = len(model.joints)
    inputs: list[tuple[str, ...]] = [("t",)]
    inputs += [tuple(f"{x}[:, {j}]" for j in range(size)) for x in ("q", "dq", "ddq", "sign")]
    inputs += [tuple(f"memory{k}" for k in range(len(ready.memories)))]
    inputs += [tuple(f"base[:, {k}]" for k, _ in enumerate(model.base_state))] if moving else []
    inputs += [tuple(f"force[:, {k}]" for k in range(len(model.channels)))]
    body = []
    for k, memory in enumerate(ready.memories):
        body.append(scalar_c(memory.argument, inputs, f"x{k} = {{value}} + 0.0 * t", NUMPY))
        parameter = "" if memory.parameter is None else f", {memory.parameter!r}"
        body.append(f"    memory{k} = {memory.operator}(t, x{k}{parameter})")
    body.append(scalar_c(ready.torque, inputs, "tau[:, {k}] = {value}", NUMPY))
    operators = "".join(OPERATORS[word] for word in used)
    first = operators.find(HELD)
    operators = operators[: first + len(HELD)] + operators[first + len(HELD) :].replace(HELD, "")
    kind = "machine" if model.chain else "leg"
    units_of = [", ".join(dict.fromkeys(joint.unit(q) for joint in model.joints)) for q in ("q", "dq", "ddq", "tau")]
    swaying = (
        " `base` (N, 5) is the base's angle\n    rad, its derivatives, and its acceleration forwards and upwards m/s²."
        if moving
        else ""
    )
    if moving and model.spatial:
        swaying = (
            " `base` (N, 12) are the base's angles\n    about the fixed axes x, y, z (rad), their rates, the rates of "
            "these, and its acceleration m/s²."
        )
    pushed = f" `force` (N, {len(model.channels)}) are {', '.join(model.channels)}." if model.forces else ""
    outside = [name for name, there in (("base", moving), ("force", model.forces)) if there]
    arguments = ", ".join(["t, q, dq, ddq", *outside])
    said = swaying + pushed
    taken = "".join(f"    {name} = np.asarray({name}, dtype=float)\n" for name in outside)
    text = f'''"""{in_comment(model.name)}: torque of a {kind}, with identified parameters. Written by exoid.

Joint order {", ".join(model.joint_names)}; s, {"; ".join(units_of)}. Model {model_key(model)[:16]}.
"""

import numpy as np
{operators}

def torque({arguments}):
    """Return the torque (N, {size}) the drives supply along a motion: t (N,) s, q, dq, ddq (N, {size}).{said}"""
    t = np.asarray(t, dtype=float)
    q, dq, ddq = (np.asarray(x, dtype=float).reshape(len(t), {size}) for x in (q, dq, ddq))
{taken}    sign = {sign}
    tau = np.empty((len(t), {size}))
'''
    return {f"{options.name}.py": text + "\n".join(body) + "\n    return tau\n"}
