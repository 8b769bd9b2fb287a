"""C99 for a controller: the identified torque of the machine, its gravity, M, C and forward dynamics.

Nothing but math.h is needed, nothing is allocated, and there is no static state: effects with memory keep theirs in a
struct that the caller owns. A sample that is not finite gives a torque that is not finite and is not remembered: every
operator is held at its last finite argument, so that the next sample is good again. Operators with memory run on the
controller's own clock: play, dahl and lag step by step, delay through a ring of samples. What looks both ways in the
model is late: ddt, a backward difference, by half a sample, and slow, a low-pass of first order, by 1 / (2 π f).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from exoid.ground.text import in_comment
from exoid.symbolic.codegen.fingerprint import model_key
from exoid.symbolic.codegen.instructions import PLAIN, scalar_c
from exoid.symbolic.joints import Joint, units
from exoid.symbolic.model import Model
from exoid.workbench.identified import ExportedOperator, ExportError, Options, Ready

HELP = "C99 and a header for a controller: no dependency but math.h, no allocation"

NEEDS_CLOCK = frozenset(("delay", "lag", "slow", "ddt"))


def write(ready: Ready, options: Options) -> dict[str, str]:
    """Return {file name: text}; ExportError where an effect cannot run in a controller."""
    _check(ready, options)
    return {f"{options.name}.h": _header(ready, options), f"{options.name}.c": _source(ready, options)}


def _check(ready: Ready, options: Options) -> None:
    for memory in ready.memories:
        if memory.operator in NEEDS_CLOCK and options.sample_time is None:
            raise ExportError(
                f"the model has an effect with {memory.operator}(), which needs the period of the control loop",
                remedy="add --sample-time SECONDS",
            )
        if memory.operator == "delay" and memory.parameter is not None and memory.parameter < 0.0:
            raise ExportError(
                f"the model's torque is ahead of its motion by {-memory.parameter:g} s: a controller cannot look ahead",
                remedy="feed the controller a desired motion that is known ahead, or export without this effect",
            )


def _header(ready: Ready, options: Options) -> str:
    n, guard, size = options.name, options.name.upper() + "_H", len(ready.model.joints)
    memory, extra = bool(ready.memories), _extra(ready)
    first = f"{n}_state *state, " if memory else ""
    numbers = "\n".join(
        f" *   {in_comment(name):<28} {value: .9g}" for name, value in (*ready.linear.items(), *ready.shape.items())
    )
    state = _state_struct(ready, options) if memory else ""
    init = f"\n/* Call once before the first step. */\nvoid {n}_init({n}_state *state);\n" if memory else ""
    step = " Call it once per period, in order: it remembers." if memory else ""
    rates = dict.fromkeys(_ascii(joint.unit("ddq")) for joint in ready.model.joints)
    forward = (
        ""
        if ready.forward is None
        else f"""
/* Acceleration ddq [{", ".join(rates)}] under the drive torques tau [{_units(ready.model.joints, "tau")}]. */
void {n}_forward_dynamics({_arguments("t q dq base force tau > ddq", size, extra)});
"""
    )
    motion = _arguments("t q dq ddq base force > tau", size, extra)
    turning = all(joint.turns for joint in ready.model.joints)
    sliding = "" if turning else ", N for N.m and m for rad where a joint slides"
    return f"""/* {in_comment(ready.model.name)}:
 * torque of a {_machine(ready)}, with identified parameters. Written by exoid.
 *
 * {_conventions(ready)}
 * A torque is what the drives have to supply. Matrices are row by row.
 * sgn of a velocity is {_sign_text(options)}.
 * Model {model_key(ready.model)[:16]}, {_size(ready)}g = {ready.model.gravity:g} m/s^2. Numbers:
{numbers}
 */
#ifndef {guard}
#define {guard}

#ifdef __cplusplus
extern "C" {{
#endif
{state}{init}
/* All the drives have to supply for this motion.{step} */
void {n}_torque({first}{motion});

/* The rigid body alone: no friction, no effects. */
void {n}_rigid_torque({_arguments("t q dq ddq base > tau", size, extra)});

/* Gravity alone (to be fed forward while the joints are held). */
void {n}_gravity({_arguments("t q base > tau", size, extra)});

/* Mass matrix [kg.m^2] and Christoffel matrix [N.m.s/rad]{sliding}. */
void {n}_mass_matrix({_arguments("q > mass", size, extra)});
void {n}_coriolis({_arguments("q dq > coriolis", size, extra)});
{forward}
#ifdef __cplusplus
}}
#endif
#endif
"""


def _extra(ready: Ready) -> dict[str, int]:
    """Count of the numbers of the base's motion and of the measured forces, 0 where there are none."""
    return {"base": len(ready.model.base_state), "force": len(ready.model.channels)}


def _arguments(words: str, size: int, extra: Mapping[str, int]) -> str:
    """Return the arguments of a function in C: what goes in, and behind ">" what comes out; `base` where it moves, and
    `force` where any is measured.
    """
    given, _, made = words.partition(" > ")
    lengths = {**extra, "mass": size * size, "coriolis": size * size}
    named = [word for word in given.split() if extra.get(word, 1)]
    texts = ["double t" if word == "t" else f"const double {word}[{lengths.get(word, size)}]" for word in named]
    return ", ".join([*texts, f"double {made}[{lengths.get(made, size)}]"])


def _conventions(ready: Ready) -> str:
    """Return the order and the zero of the joints, and their units, as lines of the comment."""
    model = ready.model
    if not model.chain:
        return (
            f"Joint order {', '.join(model.joint_names)}. q in rad (hip from the downward vertical, knee relative to\n"
            " * the thigh, flexion negative), dq in rad/s, ddq in rad/s^2, t in s since the model's time began (only\n"
            " * drifts use it); torques in N.m." + _pushed(model)
        )
    lines = ["Joints, in order, with the units of q, dq, ddq and tau:"]
    for joint in model.joints:
        units = ", ".join(_ascii(joint.unit(quantity)) for quantity in ("q", "dq", "ddq", "tau"))
        lines.append(f"  {joint.name:<12} {units}")
    if model.spatial:
        lines.append("Zeros and signs are those of the model's axes and origins. t in s since the")
    else:
        lines.append(
            "An angle is that from the parent link, at the base from the downward vertical. t in s since the"
        )
    lines.append("model's time began (only drifts use it).")
    if model.moving_base and model.spatial:
        lines.append("base: angles about the fixed axes x, y, z in this order (rad), their rates, the rates of")
        lines.append("these, acceleration along the world's x, y, z m/s^2, without gravity.")
    elif model.moving_base:
        lines.append(
            "base: angle rad (added to the angles at the base), rad/s, rad/s^2, acceleration forwards and"
        )
        lines.append("upwards m/s^2, without gravity.")
    return "\n * ".join(lines) + _pushed(model)


def _pushed(model: Model) -> str:
    """Return the names of the measured forces, as further lines of the comment."""
    if not model.forces:
        return ""
    each = [f"{name} ({in_comment(force.name)})" for force in model.forces for name in force.columns]
    lines = ["", f"force: {', '.join(each)}, N or N.m, on the machine.", "A delay of theirs is not undone here."]
    return "\n * ".join(lines)


def _machine(ready: Ready) -> str:
    size = len(ready.model.joints)
    count = {1: "one joint", 2: "two joints"}.get(size, f"{size} joints")
    return f"{'machine' if ready.model.chain else 'leg'} with {count}"


def _size(ready: Ready) -> str:
    return "" if ready.model.chain else f"thigh {ready.model.thigh_length:g} m, "


def _ascii(unit: str) -> str:
    return unit.replace("·", ".").replace("²", "^2")


def _units(joints: Sequence[Joint], quantity: str) -> str:
    return _ascii(units(joints, quantity))


def _sign_text(options: Options) -> str:
    if options.sign_width == 0.0:
        return "a step, 0 at rest"
    return f"tanh(dq / {options.sign_width:g}), which does not chatter at rest"


def _state_struct(ready: Ready, options: Options) -> str:
    fields = [f"  double {_field(k, m)};" for k, m in enumerate(ready.memories) if m.operator != "delay"]
    fields += [f"  double last{k};" for k in range(len(ready.memories))]
    for k, memory in enumerate(ready.memories):
        if memory.operator == "delay":
            fields += [f"  double past{k}[{_ring(memory, options)}];", f"  int next{k};"]
    body = "\n".join(fields)
    name = options.name
    return f"""
/* What the effects with memory remember. One per machine; yours to keep. A sample with a NaN or an infinity in it gives
   a torque that is not finite; it is not remembered, and the next sample is good again. */
typedef struct {name}_state {{
{body}
  int started;
}} {name}_state;
"""


def _field(k: int, memory: ExportedOperator) -> str:
    return f"{memory.operator}{k}"


def _ring(memory: ExportedOperator, options: Options) -> int:
    assert memory.parameter is not None and options.sample_time is not None
    return math.floor(memory.parameter / options.sample_time) + 2


def _source(ready: Ready, options: Options) -> str:
    n = options.name
    memory = bool(ready.memories)
    first = f"{n}_state *state, " if memory else ""
    parts = [
        f'/* Written by exoid; do not edit. See {n}.h. */\n#include "{n}.h"\n\n#include <math.h>\n',
        _sign(options),
    ]
    if memory:
        parts.append(f"void {n}_init({n}_state *state) {{\n  const {n}_state empty = {{0}};\n  *state = empty;\n}}\n")
    size, extra = len(ready.model.joints), _extra(ready)
    motion = _arguments("t q dq ddq base force > tau", size, extra)
    steps = _memory_steps(ready, options)
    for name, function, words, before in (
        ("torque", ready.torque, f"{first}{motion}", steps),
        ("rigid_torque", ready.rigid, _arguments("t q dq ddq base > tau", size, extra), ""),
        ("gravity", ready.gravity, _arguments("t q base > tau", size, extra), ""),
        ("mass_matrix", ready.mass, _arguments("q > mass", size, extra), ""),
        ("coriolis", ready.coriolis, _arguments("q dq > coriolis", size, extra), ""),
        ("forward_dynamics", ready.forward, _arguments("t q dq base force tau > ddq", size, extra), ""),
    ):
        if function is not None:
            parts.append(_function(f"void {n}_{name}({words})", function, before))
    return "\n".join(parts)


def _sign(options: Options) -> str:
    value = "(double)((dq > 0.0) - (dq < 0.0))" if options.sign_width == 0.0 else f"tanh(dq / {options.sign_width!r})"
    return f"static double sign_of(double dq) {{ return {value}; }}\n"


def _inputs(function: Any) -> list[tuple[str, ...]]:
    """Return the names in C of the entries of a function's arguments."""
    found: list[tuple[str, ...]] = []
    for k, name in enumerate(function.name_in()):
        entries = range(function.size1_in(k))
        plain = name in ("sign", "memory")
        found.append(("t",) if name == "t" else tuple(f"{name}{j}" if plain else f"{name}[{j}]" for j in entries))
    return found


def _function(head: str, function: Any, before: str = "") -> str:
    out = re.findall(r"double (\w+)\[\d+\]\)$", head)[0]
    body = scalar_c(function, _inputs(function), f"{out}[{{k}}] = {{value}};", PLAIN)
    text = before + body
    size = function.size1_in(function.name_in().index("q"))
    signs = "".join(f"  const double sign{j} = sign_of(dq[{j}]);\n" for j in range(size) if _uses(text, f"sign{j}"))
    given = re.findall(r"const double (\w+)\[|double (t),", head)
    unused = "".join(f"  (void){g};\n" for g in map("".join, given) if not _uses(signs + text, g))
    return f"{head} {{\n{unused}{signs}{before}{body}\n}}\n"


def _uses(text: str, word: str) -> bool:
    return re.search(rf"(?<![\w]){word}(?![\w])", text) is not None


def _memory_steps(ready: Ready, options: Options) -> str:
    """Return the statements that bring every operator to this sample, in the order in which they feed each other."""
    lines: list[str] = []
    for k, memory in enumerate(ready.memories):
        inside = scalar_c(memory.argument, _inputs(memory.argument), f"x{k} = {{value}};", PLAIN)
        lines += [f"  double x{k};", f"  double memory{k};", "  {", inside, "  }"]
        # x - x is 0 for every finite number, and NaN for every other.
        lines += [f"  const double gap{k} = x{k} - x{k};", f"  if (!(gap{k} == 0.0)) {{", f"    x{k} = state->last{k};"]
        lines += ["    whole = 0;", "  }", *_step(k, memory, options), f"  state->last{k} = x{k};"]
        lines += [f"  memory{k} += gap{k};", f"  (void)memory{k};"]  # its factor may be zero at every state
    if not lines:
        return ""
    return "\n".join(["  int whole = 1;", *lines, "  if (whole) state->started = 1;", ""])


def _step(k: int, memory: ExportedOperator, options: Options) -> list[str]:
    p = memory.parameter
    own = f"state->{_field(k, memory)}"
    if memory.operator == "play":
        return [
            f"  if (!state->started) {own} = x{k};",
            f"  if (x{k} - ({p!r}) > {own}) {own} = x{k} - ({p!r});",
            f"  else if (x{k} + ({p!r}) < {own}) {own} = x{k} + ({p!r});",
            f"  memory{k} = {own};",
        ]
    if memory.operator == "dahl":
        return [
            "  if (state->started) {",
            f"    const double move = x{k} - state->last{k}, keep = exp(-({p!r}) * fabs(move));",
            f"    {own} = keep * {own} + (double)((move > 0.0) - (move < 0.0)) * (1.0 - keep);",
            "  }",
            f"  memory{k} = {own};",
        ]
    assert options.sample_time is not None
    if memory.operator == "ddt":
        return [
            f"  {own} = state->started ? (x{k} - state->last{k}) / {options.sample_time!r} : 0.0;",
            f"  memory{k} = {own};",
        ]
    assert p is not None
    if memory.operator in ("lag", "slow"):
        rate = 2.0 * math.pi * p if memory.operator == "slow" else 1.0 / max(p, 1e-30)
        share = -math.expm1(-rate * options.sample_time)
        return [
            f"  {own} = state->started ? {own} + {share!r} * (x{k} - {own}) : x{k};",
            f"  memory{k} = {own};",
        ]
    ring, back = _ring(memory, options), p / options.sample_time
    whole = min(math.floor(back), ring - 2)
    return [
        "  {",
        "    int i;",
        f"    if (!state->started) for (i = 0; i < {ring}; ++i) state->past{k}[i] = x{k};",
        f"    state->past{k}[state->next{k}] = x{k};",
        f"    i = (state->next{k} + {ring - whole}) % {ring};",
        f"    memory{k} = ({1.0 - (back - whole)!r}) * state->past{k}[i]"
        f" + ({back - whole!r}) * state->past{k}[(i + {ring - 1}) % {ring}];",
        f"    state->next{k} = (state->next{k} + 1) % {ring};",
        "  }",
    ]
