"""The C that sums a model's information over periodic motions, from the CasADi products of one sample."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

from exoid.ground.text import filled
from exoid.symbolic.codegen.cache import GeneratedC
from exoid.symbolic.codegen.compiler import FAST
from exoid.symbolic.codegen.equation import model_expressions
from exoid.symbolic.codegen.instructions import scalar_c, template

if TYPE_CHECKING:
    from exoid.symbolic.model_structure import ModelStructure

Entries = tuple[tuple[int, int, int], ...]


@lru_cache(maxsize=8)
def sensitivity_function(model: ModelStructure) -> Any:
    """Return the CasADi function (state (1 + 4J,), numbers (P + S,)) -> sensitivities (J, M)."""
    import casadi

    x = model_expressions(model)
    kept = [x.shape[k] for k, s in enumerate(model.shapes) if not s.shape.choices]
    slopes = casadi.jacobian(x.torque, casadi.vertcat(x.linear, *kept))
    state = casadi.vertcat(x.t, x.q, x.dq, x.ddq, x.sign)
    return casadi.Function("sensitivities", [state, casadi.vertcat(x.linear, x.shape)], [slopes], {"cse": True})


def products(model: ModelStructure) -> tuple[Entries, Any]:
    """Return the (joint, number, number) of every product that is not zero, and the CasADi function of their values.

    It takes (state (1 + 4J,), numbers (P + S,)), the state's signs being means over a sample's cell: in a cell with a
    reversal the product is averaged over both signs, so that sgn² stays one.
    """
    import casadi

    count = len(model.parameters) + len(model.shapes)
    joints = len(model.joints)
    state, numbers = casadi.SX.sym("state", 1 + 4 * joints), casadi.SX.sym("numbers", count)
    rows = sensitivity_function(model)(state, numbers)
    pattern = [[p for p in range(rows.shape[1]) if rows.sparsity().has_nz(j, p)] for j in range(joints)]
    entries = tuple((j, p, r) for j in range(joints) for i, p in enumerate(pattern[j]) for r in pattern[j][i:])
    values = casadi.vertcat(*(rows[j, p] * rows[j, r] for j, p, r in entries))
    for sign in (state[1 + 3 * joints + j] for j in range(joints)):
        forward, backward = casadi.substitute([values], [sign], [1])[0], casadi.substitute([values], [sign], [-1])[0]
        values = casadi.simplify(0.5 * (forward + backward)) + sign * casadi.simplify(0.5 * (forward - backward))
    return entries, casadi.Function("terms", [state, numbers], [casadi.densify(values)], {"cse": True})


def information_code(model: ModelStructure, harmonics: int) -> GeneratedC:
    """Return the C of one model, and which sums it makes."""
    entries, terms = products(model)
    count = len(model.parameters) + len(model.shapes)
    total = len(model.joints)
    joints = range(1, total + 1)
    lines = {
        name: "\n".join(line.format(j=j, k=j - 1, joints=total) for j in joints) for name, line in _PER_JOINT.items()
    }
    words = ["t[n]", *(f"{stem}{j}" for stem in ("x", "dx", "ddx", "s") for j in joints)]
    body = scalar_c(terms, [words, [f"numbers[{k}]" for k in range(count)]], "g{k} += {value};")
    sums = [f"g{k}" for k in range(len(entries))]
    text = filled(template("information.c.in"), {
        "PREAMBLE": template("sine.h"), "JOINTS": total, "WAVES": harmonics, **lines,
        "SUMS": ", ".join(f"{s} = 0" for s in sums), "REDUCTION": ",".join(sums), "BODY": body,
        "STORE": "\n".join(f"    out[i * {len(entries)} + {k}] = {s};" for k, s in enumerate(sums)),
    })  # fmt: skip
    return GeneratedC(text, FAST, {"entries": entries})


_PER_JOINT = {
    "POINTERS": (
        "  double *restrict q{j} = scratch + {k} * 3 * grid, *restrict v{j} = q{j} + grid;\n"
        "  double *restrict a{j} = v{j} + grid;"
    ),
    "FACTORS": (
        "    const double o{j} = offsets[{joints} * i + {k}];\n"
        "    const double f{j} = swing(grid, table, rates, c + {k} * 2 * WAVES, o{j}, limits + 4 * {k}, doublings,"
        " q{j}, v{j}, a{j});\n"
        "    const double scale{j} = rescale ? f{j} : 1;\n"
        "    factors[{joints} * i + {k}] = f{j};"
    ),
    "STATES": (
        "    const double x{j} = o{j} + scale{j} * q{j}[n], dx{j} = scale{j} * v{j}[n];\n"
        "    const double ddx{j} = scale{j} * a{j}[n];"
    ),
    "SIGNS": "    const double s{j} = mean_sign(dx{j}, step * ddx{j});",
}
"""Lines of `information.c.in` that every joint has."""
