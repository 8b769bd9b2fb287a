"""Model -> C: seven CasADi functions, the loops over samples around them, a header, and a manifest.

The text depends on the model and on the versions of SymPy and CasADi alone: no dates, no paths, no machine.
So `generated/` can be compared byte for byte with what the derivation gives today.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from exoid.ground.files import sha256
from exoid.ground.text import filled, in_comment
from exoid.symbolic.codegen.equation import Expressions, model_expressions
from exoid.symbolic.codegen.fingerprint import equations_key, joint_record, library_versions
from exoid.symbolic.codegen.instructions import template
from exoid.symbolic.codegen.layout import state_names, widths
from exoid.symbolic.mechanics.base_parameters import base_parameters
from exoid.symbolic.mechanics.regressor import derive_regressor

if TYPE_CHECKING:
    from exoid.symbolic.model_structure import ModelStructure

PREFIX = "leg"
NEWTON_STEPS = 4
"""Corrections of θ'' where the torque is not linear in it (load-dependent friction): it is piecewise
smooth.
"""


def meanings(model: ModelStructure) -> dict[str, str]:
    """Return {function: what it computes}."""
    names, square = ", ".join(model.joint_names), f"{len(model.joints)} x {len(model.joints)}"
    torque, rate = "N m", "rad/s^2"
    rigid, end = "leg", "the shank `reach` m below the knee"
    if model.chain:
        rigid, end = "machine", f"the last link `reach` m beyond {model.joint_names[-1]}"
    if model.spatial:
        end = f"the last link, `reach` m along the axis of {model.joint_names[-1]}, in the frame of the base"
    if not all(joint.turns for joint in model.joints):
        torque, rate = "N m or N", "rad/s^2 or m/s^2"
    return {
        "columns": "non-zero entries of the regressor Y, in the order of the table below",
        "inverse_dynamics": f"torque ({names}) in {torque} for a motion",
        "forward_dynamics": f"acceleration ({names}) in {rate} for a torque; "
        "the accelerations in `state` are not used",
        "mass_matrix": f"M, {square} by columns, of the rigid {rigid}",
        "coriolis": f"Christoffel C, {square} by columns, of the rigid {rigid}",
        "gravity": f"G ({names}) of the rigid {rigid}, {torque}",
        "jacobian": f"J, {3 if model.spatial else 2} x {len(model.joints)} by columns, of a point on {end}",
    }


@dataclass(frozen=True, eq=False)
class Sources:
    """Generated text: C `code`, `header`, and `manifest` (JSON).

    `entries` are the (joint, parameter) of the regressor that the C computes; `needs_reference` says whether some of
    them depend on the linear parameters.
    """

    code: str
    header: str
    manifest: str
    entries: tuple[tuple[int, int], ...]
    needs_reference: bool

    @property
    def files(self) -> dict[str, str]:
        """Return {file name: text}."""
        return {f"{PREFIX}.c": self.code, f"{PREFIX}.h": self.header, "manifest.json": self.manifest}


def functions(expressions: Expressions) -> dict[str, Any]:
    """Return the CasADi functions {name: Function}, each of (state (1 + 4 J,), linear (P,), shape (S,),
    memory (K,), extra).

    `extra` is the torque (J,) for forward_dynamics and `reach` for jacobian; the others have none.
    """
    import casadi

    x = expressions
    state = casadi.vertcat(x.t, x.q, x.dq, x.ddq, x.sign, x.base_motion, x.force)
    inputs = [state, x.linear, x.shape, x.memory]
    tau = casadi.SX.sym("tau", x.q.numel())
    outputs = {
        "columns": (inputs, casadi.vertcat(*(entry for _, _, entry in x.columns))),
        "inverse_dynamics": (inputs, x.torque),
        "forward_dynamics": ([*inputs, tau], _forward(casadi, x, tau)),
        "mass_matrix": (inputs, casadi.densify(casadi.vec(x.M))),
        "coriolis": (inputs, casadi.densify(casadi.vec(x.C))),
        "gravity": (inputs, casadi.densify(x.G)),
        "jacobian": ([*inputs, x.reach], casadi.densify(casadi.vec(x.J))),
    }
    return {
        name: casadi.Function(f"{PREFIX}_{name}", given, [casadi.densify(value)], {"cse": True})
        for name, (given, value) in outputs.items()
    }


def _forward(casadi: Any, x: Expressions, tau: Any) -> Any:
    """Return θ'' with inverse_dynamics(θ'') = tau: one Newton step where that is linear, a few where it is
    not.
    """
    slope = casadi.jacobian(x.torque, x.ddq)
    residual = casadi.Function(
        "residual", [x.ddq, x.t, x.q, x.dq, x.sign, x.base_motion, x.force, x.linear, x.shape, x.memory, tau],
        [x.torque - tau, slope],
    )
    linear = not casadi.depends_on(slope, x.ddq)
    acceleration = casadi.SX.zeros(x.q.numel())
    for _ in range(1 if linear else NEWTON_STEPS):
        r, m = residual(
            acceleration, x.t, x.q, x.dq, x.sign, x.base_motion, x.force, x.linear, x.shape, x.memory, tau
        )
        acceleration = acceleration - _solved(casadi, casadi.densify(m), r)
    return acceleration


def _solved(casadi: Any, m: Any, r: Any) -> Any:
    """Return m⁻¹ r: Cramer's rule for two joints, elimination for more."""
    if r.numel() == 1:
        return r / m
    if r.numel() > 2:
        return casadi.solve(m, r)
    det = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
    return casadi.vertcat(m[1, 1] * r[0] - m[0, 1] * r[1], m[0, 0] * r[1] - m[1, 0] * r[0]) / det


def generate(model: ModelStructure) -> Sources:
    """Derive `model` and return its C code, header and manifest."""
    expressions = model_expressions(model)
    made = functions(expressions)
    entries = [(joint, parameter) for joint, parameter, _ in expressions.columns]
    code = _TITLE + _casadi_text(made) + _loops(model, len(expressions.memories), len(entries))
    header = _header(model, entries, [memory.operator for memory in expressions.memories])
    needed = reference_needed(expressions)
    manifest = {
        "model": model_record(model),
        "equations": equations_key(model),
        "versions": library_versions(),
        "regressor": [f"{model.joint_names[joint]} {column_name(model, p)}" for joint, p in entries],
        "regressor_needs_reference": needed,
        "operations": {name: operations(function) for name, function in made.items()},
        "sha256": {f"{PREFIX}.c": sha256(code), f"{PREFIX}.h": sha256(header)},
    }
    text = json.dumps(manifest, indent=2, ensure_ascii=False) + "\n"
    return Sources(code, header, text, tuple(entries), needed)


def reference_needed(expressions: Expressions) -> bool:
    """True if some column of the regressor depends on the linear parameters."""
    import casadi

    return any(casadi.depends_on(entry, expressions.linear) for _, _, entry in expressions.columns)


def model_record(model: ModelStructure) -> dict[str, Any]:
    """Return the model as plain data: geometry, terms, and its numbers with their units."""
    lengths: dict[str, Any] = {"thigh_length": model.thigh_length}
    if model.chain:
        lengths = {"joints": [joint_record(joint) for joint in model.chain]}
    return {
        "name": model.name,
        **lengths,
        "gravity": model.gravity if model.gravity_vector is None else list(model.gravity_vector),
        **({"base": "measured"} if model.moving_base else {}),
        **({"forces": {force.name: list(force.columns) for force in model.forces}} if model.forces else {}),
        "terms": [term.name for term in model.terms],
        "parameters": {parameter.name: parameter.unit for parameter in model.parameters},
        "inertial": inertial(model),
        "shape": {shape.name: shape.shape.unit for shape in model.shapes},
    }


def column_name(model: ModelStructure, parameter: int) -> str:
    """Return the name of a column of the regressor: of its parameter, or "known" for what needs none."""
    return model.parameters[parameter].name if parameter < len(model.parameters) else "known"


def inertial(model: ModelStructure) -> dict[str, str]:
    """Return {name: formula} of the base parameters in masses, lengths and inertias, as derived."""
    if model.chain:
        found = base_parameters(model.chain, model.pull, model.moving_base)
        return {p.name: base.formula(model.chain) for p, base in zip(model.inertial, found, strict=True)}
    form = derive_regressor(model.mechanism)
    return {name: str(formula) for name, formula in zip(form.names, form.parameters, strict=True)}


def operations(function: Any) -> int:
    """Number of arithmetic operations of one evaluation."""
    import casadi

    silent = {casadi.OP_INPUT, casadi.OP_OUTPUT, casadi.OP_CONST}
    return sum(function.instruction_id(k) not in silent for k in range(function.n_instructions()))


def stale_files(model: ModelStructure, folder: str | Path) -> tuple[str, ...]:
    """Return the names of files in `folder` that differ from what the model generates today, byte for byte."""
    stale = []
    for name, text in generate(model).files.items():
        path = Path(folder) / name
        if not path.is_file() or path.read_bytes() != text.encode():
            stale.append(name)
    return tuple(stale)


def _casadi_text(made: dict[str, Any]) -> str:
    import casadi

    generator = casadi.CodeGenerator(PREFIX, {"with_header": False, "main": False, "mex": False})
    for function in made.values():
        generator.add(function)
    return str(generator.dump())


_TITLE = "/* Written by `exoid generate` through SymPy and CasADi; never edited by hand. See the header. */\n"


def _loops(model: ModelStructure, memories: int, entries: int) -> str:
    """Return the C loops over samples; arrays are row by row, a sample per row."""
    joints = len(model.joints)
    states = len(state_names(joints, model.base_state, len(model.channels)))
    extras = {"forward_dynamics": joints, "jacobian": 1}
    text = f"\n/* Loops over samples: `state` (n, {states}), `memory` (n, K), `extra` and `out` row by row. */\n"
    text += '#ifdef __cplusplus\nextern "C" {\n#endif\n'
    for name, width in {"columns": entries, **widths(joints, model.spatial)}.items():
        text += "\n" + filled(template("loop.c.in"), {
            "PREFIX": PREFIX, "NAME": name, "WIDTH": width, "EXTRA": extras.get(name, 0), "MEMORIES": memories,
            "STATES": states,
        })  # fmt: skip
    return text + "#ifdef __cplusplus\n}\n#endif\n"


def _header(model: ModelStructure, entries: list[tuple[int, int]], memories: list[str]) -> str:
    parameters = [f"  {k}: {in_comment(f'{p.name} [{p.unit}]')}" for k, p in enumerate(model.parameters)]
    shapes = [f"  {k}: {in_comment(f'{s.name} [{s.shape.unit}]')}" for k, s in enumerate(model.shapes)]
    names, state = model.joint_names, state_names(
        len(model.joints), model.base_state, len(model.channels)
    )
    table = [f"  {k}: {in_comment(f'Y[{names[j]}][{column_name(model, p)}]')}" for k, (j, p) in enumerate(entries)]
    sliding = "" if all(joint.turns for joint in model.joints) else "; m for rad where a joint slides"
    sliding += f"; {', '.join(model.channels)} in N or N m" if model.forces else ""
    sliding += f"; {', '.join(n for n in model.base_state if '_a' in n)} in m/s^2" if model.moving_base else ""
    prototypes = "".join(
        f"\n/* {meaning} */\nvoid {PREFIX}_{name}_many(long n, const double *state, const double *linear,\n"
        "    const double *shape, const double *memory, const double *extra, double *out);\n"
        for name, meaning in meanings(model).items()
    )
    return _HEADER.format(
        name=in_comment(model.name),
        state=", ".join(state),
        count=len(state),
        joints=", ".join(names),
        units="s, rad, rad/s, rad/s^2, -1..1" + sliding,
        parameters="\n".join(parameters),
        shapes="\n".join(shapes) or "  none",
        memories="\n".join(f"  {k}: {word}" for k, word in enumerate(memories)) or "  none",
        table="\n".join(table),
        prototypes=prototypes,
        guard=f"EXOID_{PREFIX.upper()}_H",
    )


_HEADER = """/* Written by `exoid generate` from the model "{name}"; never edited by hand.

state ({count} per sample): {state}  [{units}]
linear:
{parameters}
shape:
{shapes}
memory (one value per sample of each operator with memory):
{memories}
entries of the regressor:
{table}

`extra` is the torque ({joints}) for forward_dynamics, `reach` for jacobian, and NULL for the rest. */
#ifndef {guard}
#define {guard}
#ifdef __cplusplus
extern "C" {{
#endif
{prototypes}
#ifdef __cplusplus
}}
#endif
#endif
"""
