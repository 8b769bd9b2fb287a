"""The C that sums a model's information over periodic motions, from the CasADi products of one sample."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

from exoid.symbolic.codegen.cache import GeneratedC
from exoid.symbolic.codegen.compiler import FAST
from exoid.symbolic.codegen.equation import model_expressions
from exoid.symbolic.codegen.instructions import PREAMBLE, scalar_c

if TYPE_CHECKING:
    from exoid.symbolic.model import Model

Entries = tuple[tuple[int, int, int], ...]


@lru_cache(maxsize=8)
def sensitivity_function(model: Model) -> Any:
    """Return the CasADi function (state (1 + 4J,), numbers (P + S,)) -> sensitivities (J, M)."""
    import casadi

    x = model_expressions(model)
    kept = [x.shape[k] for k, s in enumerate(model.shapes) if not s.shape.choices]
    slopes = casadi.jacobian(x.torque, casadi.vertcat(x.linear, *kept))
    state = casadi.vertcat(x.t, x.q, x.dq, x.ddq, x.sign)
    return casadi.Function("sensitivities", [state, casadi.vertcat(x.linear, x.shape)], [slopes], {"cse": True})


def products(model: Model) -> tuple[Entries, Any]:
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


def information_code(model: Model, harmonics: int) -> GeneratedC:
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
    text = _C.format(
        preamble=PREAMBLE,
        joints=total,
        waves=harmonics,
        **lines,
        size=len(entries),
        sums=", ".join(f"{s} = 0" for s in sums),
        reduction=",".join(sums),
        body=body,
        store="\n".join(f"    out[i * {len(entries)} + {k}] = {s};" for k, s in enumerate(sums)),
    )
    return GeneratedC(text, FAST, {"entries": entries})


_PER_JOINT = {
    "pointers": (
        "  double *restrict q{j} = scratch + {k} * 3 * grid, *restrict v{j} = q{j} + grid;\n"
        "  double *restrict a{j} = v{j} + grid;"
    ),
    "factors": (
        "    const double o{j} = offsets[{joints} * i + {k}];\n"
        "    const double f{j} = swing(grid, table, rates, c + {k} * 2 * WAVES, o{j}, limits + 4 * {k}, doublings,"
        " q{j}, v{j}, a{j});\n"
        "    const double scale{j} = rescale ? f{j} : 1;\n"
        "    factors[{joints} * i + {k}] = f{j};"
    ),
    "states": (
        "    const double x{j} = o{j} + scale{j} * q{j}[n], dx{j} = scale{j} * v{j}[n];\n"
        "    const double ddx{j} = scale{j} * a{j}[n];"
    ),
    "signs": "    const double s{j} = mean_sign(dx{j}, step * ddx{j});",
}
"""Lines of the C below that every joint has."""
_C = """/* Written by exoid: sums of products of a model's sensitivities along Fourier motions. */
#include <math.h>
{preamble}
#define WAVES {waves}

static double swing(long grid, const double *restrict table, const double *restrict rates, const double *restrict c,
                    double centre, const double *limits, int doublings, double *restrict q, double *restrict dq,
                    double *restrict ddq) {{
  double up = 0, down = 0, fast = 0, strong = 0;
#pragma omp simd reduction(max:up,down,fast,strong)
  for (long n = 0; n < grid; ++n) {{
    double x = 0, v = 0, a = 0;
    for (int k = 0; k < WAVES; ++k) {{
      const double s = table[k * grid + n], o = table[(WAVES + k) * grid + n], w = rates[k];
      x += c[k] * s + c[WAVES + k] * o;
      v += w * (c[k] * o - c[WAVES + k] * s);
      a -= w * w * (c[k] * s + c[WAVES + k] * o);
    }}
    q[n] = x; dq[n] = v; ddq[n] = a;
    up = x > up ? x : up;
    down = -x > down ? -x : down;
    fast = fabs(v) > fast ? fabs(v) : fast;
    strong = fabs(a) > strong ? fabs(a) : strong;
  }}
  const double room[4] = {{limits[1] - centre, centre - limits[0], limits[2], limits[3]}};
  const double use[4] = {{up, down, fast, strong}};
  double factor = 1e300;
  for (int k = 0; k < 4; ++k) {{
    const double ratio = (room[k] > 0 ? room[k] : 0) / (use[k] > 1e-300 ? use[k] : 1e-300);
    factor = ratio < factor ? ratio : factor;
  }}
  if (doublings == 0 || factor > 1e200) return factor; /* without a swing nothing is met */
  const double above = factor / (room[0] > 1e-300 ? room[0] : 1e-300);
  const double below = factor / (room[1] > 1e-300 ? room[1] : 1e-300);
  const double speed = factor / room[2], pull = factor / room[3];
  double sum = 0;
#pragma omp simd reduction(+:sum)
  for (long n = 0; n < grid; ++n) {{
    double x = q[n] > 0 ? q[n] * above : -q[n] * below, v = dq[n] * speed, a = ddq[n] * pull;
    for (int k = 0; k < doublings; ++k) {{ x *= x; v *= v; a *= a; }}
    sum += x + v + a;
  }}
  sum = sum / grid;
  return factor * pow(sum > 1e-300 ? sum : 1e-300, -1.0 / (double)(1L << doublings));
}}

/* The sign of a velocity v, averaged over the cell of its sample, in which it changes by +-reach. */
static inline double mean_sign(double v, double reach) {{
  const double half = fabs(reach) > 1e-300 ? fabs(reach) : 1e-300;
  const double ratio = v / half;
  return ratio > 1 ? 1 : ratio < -1 ? -1 : ratio;
}}

void exoid_gram(long count, long grid, int rescale, int doublings, const double *restrict t,
                const double *restrict table, const double *restrict rates,
                const double *restrict swings, const double *restrict offsets,
                const double *restrict limits, const double *restrict numbers, double *restrict scratch,
                double *restrict factors, double *restrict out) {{
{pointers}
  const double step = 0.5 * (t[1] - t[0]);
  for (long i = 0; i < count; ++i) {{
    const double *c = swings + i * {joints} * 2 * WAVES;
{factors}
    double {sums};
#pragma omp simd reduction(+:{reduction})
    for (long n = 0; n < grid; ++n) {{
{states}
{signs}
{body}
    }}
{store}
  }}
}}
"""
