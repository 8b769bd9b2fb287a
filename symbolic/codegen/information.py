"""Information in periodic motions: Σ over samples of YᵀY, for a whole population of Fourier motions at once, in C.

    θ_i = θ_i0 + f_i Σ_k a_ik sin(kωt) + b_ik cos(kωt),        G_j = Σ_n y_jn y_jnᵀ / N

y_jn (M,) is the derivative of joint j's torque at sample n by every number of the model: the regressor's row for a
model that is linear in its numbers, with one more entry per shape parameter where there are some. CasADi derives
the products of one sample, a loop over the grid sums them, and the compiler vectorises it. What bounds the motion (f)
is found in the same pass, because it needs the same angles.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from symbolic.codegen.cache import CompiledLibrary, GeneratedC, load_library
from symbolic.codegen.compiler import FAST
from symbolic.codegen.fingerprint import equations
from symbolic.codegen.instructions import PREAMBLE, scalar_c
from symbolic.columns import model_columns, model_torque, needs_reference
from symbolic.motion import Float, Motion

if TYPE_CHECKING:
    from symbolic.model import Model

Entries = tuple[tuple[int, int, int], ...]


@dataclass(frozen=True, eq=False)
class Sums:
    """For I motions: `gram` (I, J, M, M), and `factor` (I, J) by which each swing may grow until it meets a limit."""

    gram: Float
    factor: Float


@dataclass(frozen=True, eq=False)
class Information:
    """The sums of one `model` at its numbers `linear` (P,), `shape` (S,), over a `grid` of one `period` (s).

    `names` (M,) are the numbers, `rates` (K,) the harmonics' kω in rad/s, `limits` (J, 4) what a motion may reach: low
    and high angle, speed, acceleration.
    """

    model: Model
    names: tuple[str, ...]
    linear: Float
    shape: Float
    period: float
    grid: int
    rates: Float
    limits: Float
    library: CompiledLibrary | None
    entries: Entries
    machine: Any

    @property
    def backend(self) -> str:
        """Return "c", "vm" for CasADi's virtual machine, or "python" where operators need a motion's past."""
        return "c" if self.library is not None else "python" if self.machine is None else "vm"

    @property
    def times(self) -> Float:
        """The grid (N,) in s, one period without its end."""
        return np.asarray(np.arange(self.grid) * (self.period / self.grid), dtype=float)

    def sums(self, swings: Any, offsets: Any, *, rescale: bool, doublings: int = 0) -> Sums:
        """Return the sums of motions with `swings` (I, J, 2K: sines, then cosines) about `offsets` (I, J) in rad.

        `rescale` stretches or shrinks every swing to the first limit it meets, before the sums are made. With
        `doublings` the largest use of a limit is replaced by the norm of order 2^doublings over all samples and limits,
        which has no kinks where another sample becomes the largest (and may leave the limits a little).
        """
        swing = np.ascontiguousarray(swings, dtype=float)
        centre = np.ascontiguousarray(offsets, dtype=float)
        wanted = (len(centre), len(self.limits), 2 * len(self.rates))
        if swing.shape != wanted or centre.shape != wanted[:2]:
            raise ValueError(f"swings {swing.shape} and offsets {centre.shape} do not fit, expected {wanted}")
        if self.library is None:
            return self._slowly(swing, centre, rescale, doublings)
        return self._in_c(self.library.c, swing, centre, rescale, doublings)

    def _in_c(self, library: ctypes.CDLL, swing: Float, centre: Float, rescale: bool, doublings: int) -> Sums:
        count, size = len(swing), len(self.names)
        factor, packed = np.empty((count, len(self.limits))), np.zeros((count, len(self.entries)))
        angle = np.outer(self.rates, self.times)
        table = np.ascontiguousarray(np.concatenate([np.sin(angle), np.cos(angle)]))
        numbers = np.concatenate([self.linear, self.shape])
        scratch = np.empty(3 * len(self.limits) * self.grid)
        arrays = (self.times, table, self.rates, swing, centre, self.limits, numbers, scratch, factor, packed)
        held = [np.ascontiguousarray(a) for a in arrays]
        library.exoid_gram(
            ctypes.c_long(count), ctypes.c_long(self.grid), ctypes.c_int(int(rescale)), ctypes.c_int(doublings),
            *(a.ctypes.data_as(_DOUBLES) for a in held),
        )  # fmt: skip
        gram = np.zeros((count, len(self.limits), size, size))
        for k, (joint, p, r) in enumerate(self.entries):
            gram[:, joint, p, r] = gram[:, joint, r, p] = held[-1][:, k]
        return Sums(gram / self.grid, held[-2])

    def _slowly(self, swing: Float, centre: Float, rescale: bool, doublings: int) -> Sums:
        """Do the same in NumPy, one motion at a time."""
        angle = np.outer(self.times, self.rates)
        sine, cosine, count = np.sin(angle), np.cos(angle), len(self.rates)
        factors, grams = [], []
        for one, about in zip(swing, centre, strict=True):
            a, b = one[:, :count].T, one[:, count:].T
            rate = self.rates[:, None]
            swung = sine @ a + cosine @ b
            speed = cosine @ (rate * a) - sine @ (rate * b)
            pull = -sine @ (rate**2 * a) - cosine @ (rate**2 * b)
            factor = largest_factor(swung, speed, pull, about, self.limits)
            if doublings:
                factor = _softer(factor, swung, speed, pull, about, self.limits, doublings)
            scale = factor if rescale else np.ones(len(self.limits))
            q, dq, ddq = about + scale * swung, scale * speed, scale * pull
            grams.append(self._gram(q, dq, ddq))
            factors.append(factor)
        return Sums(np.array(grams), np.array(factors))

    def _gram(self, q: Float, dq: Float, ddq: Float) -> Float:
        """Return the sums (J, M, M) of one motion, a sample with a reversal in its cell counted with both signs."""
        sign = mean_sign(dq, ddq, self.period / self.grid)
        joints = len(self.limits)
        out = np.zeros((joints, len(self.names), len(self.names)))
        if self.machine is None:  # an operator's past cannot be cut into cells
            rows = self.sensitivities(Motion(self.times, q, dq, ddq))
            return np.einsum("jnp,jnr->jpr", rows, rows) / self.grid
        for way in product((1.0, -1.0), repeat=joints):
            weight = 0.5**joints * np.prod(1.0 + np.array(way) * sign, axis=1)
            live = weight > 0.0
            if live.any():
                signs = np.tile(way, (int(live.sum()), 1))
                rows = self.sensitivities(Motion(self.times[live], q[live], dq[live], ddq[live], signs))
                out += np.einsum("jnp,jnr,n->jpr", rows, rows, weight[live])
        return out / self.grid

    def sensitivities(self, motion: Motion) -> Float:
        """Return the derivatives (J, N, M) of the torque along `motion` by every number."""
        if self.machine is None:
            return central_differences(self.model, motion, self.linear, self.shape)
        return _evaluated(self.machine, motion, self.linear, self.shape, len(self.names))


_DOUBLES = ctypes.POINTER(ctypes.c_double)


def information(
    model: Model,
    linear: Any,
    shape: Any,
    limits: Any,
    *,
    period: float,
    harmonics: int,
    grid: int,
    backend: str = "auto",
) -> Information:
    """Return what `model` needs to weigh motions of `period` s; arguments as in Information.

    `backend` "auto" takes C where there is a compiler and the model has no operator with memory; "vm" never does.
    """
    from symbolic.memory import memory_operations

    names = number_names(model)
    rates = np.asarray(np.arange(1, harmonics + 1) * (2.0 * np.pi / period), dtype=float)
    linear, shape = np.asarray(linear, dtype=float), np.asarray(shape, dtype=float)
    library: CompiledLibrary | None = None
    entries: Entries = ()
    machine = None
    if not memory_operations(model):
        if backend == "auto":
            content = [equations(model), harmonics]
            library = load_library("gram", content, FAST, lambda: _source(model, harmonics))
        if library is not None:
            entries = tuple((int(j), int(p), int(r)) for j, p, r in library.record["entries"])
        machine = _Lazy(model)
    return Information(
        model, names, linear, shape, float(period), int(grid), rates, np.asarray(limits, dtype=float), library, entries,
        machine,
    )  # fmt: skip


def number_names(model: Model) -> tuple[str, ...]:
    """Return the names (M,) of what a motion can inform about: parameters, then shapes that are not choices."""
    return tuple(p.name for p in model.parameters) + tuple(s.name for s in model.shapes if not s.shape.choices)


class _Lazy:
    """CasADi's function of the sensitivities, derived when it is first called: the C does without."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._function: Any = None

    def __call__(self, *arguments: Any) -> Any:
        if self._function is None:
            self._function = _function(self._model)
        return self._function(*arguments)


def _function(model: Model) -> Any:
    """Return the CasADi function (state (1 + 4J,), numbers (P + S,)) -> sensitivities (J, M)."""
    import casadi

    from symbolic.codegen.equation import model_expressions

    x = model_expressions(model)
    kept = [x.shape[k] for k, s in enumerate(model.shapes) if not s.shape.choices]
    slopes = casadi.jacobian(x.torque, casadi.vertcat(x.linear, *kept))
    state = casadi.vertcat(x.t, x.q, x.dq, x.ddq, x.sign)
    return casadi.Function("sensitivities", [state, casadi.vertcat(x.linear, x.shape)], [slopes], {"cse": True})


def _evaluated(function: Any, motion: Motion, linear: Float, shape: Float, size: int) -> Float:
    state = np.column_stack([motion.t, motion.q, motion.dq, motion.ddq, motion.sign]).T
    values = function(state, np.concatenate([linear, shape]))
    flat = np.asarray(values.full() if hasattr(values, "full") else values)
    return flat.reshape(motion.q.shape[1], len(motion), size)


def central_differences(model: Model, motion: Motion, linear: Float, shape: Float) -> Float:
    """Return the derivatives (J, N, M) of the torque by central differences, for models whose operators have a past."""
    at = np.concatenate([linear, shape])
    count = len(linear)
    places = [*range(count), *(count + k for k, s in enumerate(model.shapes) if not s.shape.choices)]
    typical = [max(abs(v), abs(p.typical or 1.0)) for v, p in zip(linear, model.parameters, strict=True)]
    steps = [1e-5 * size for size in typical] + [1e-4 * (s.shape.max - s.shape.min) for s in model.shapes]
    if not needs_reference(model):
        out = [*np.moveaxis(model_columns(model, motion, shape), 2, 0)]
        places = places[count:]
    else:
        out = []
    for place in places:
        sides = []
        for sign in (1.0, -1.0):
            values = at.copy()
            values[place] += sign * steps[place]
            sides.append(model_torque(model, motion, values[:count], values[count:]).T)
        out.append((sides[0] - sides[1]) / (2.0 * steps[place]))
    return np.stack(out, axis=2)


def mean_sign(dq: Float, ddq: Float, step: float) -> Float:
    """Return the sign (N, J) of a velocity averaged over each sample's own `step` s: at a reversal it passes zero.

    The sums then change smoothly with the motion, and are closer to what faster sampling would give.
    """
    return np.clip(dq / np.maximum(0.5 * step * np.abs(ddq), 1e-300), -1.0, 1.0)


def largest_factor(swung: Float, speed: Float, pull: Float, centre: Float, limits: Float) -> Float:
    """Return the factor (J,) that brings each swing to the first limit it meets; 0 where the centre is outside."""
    low, high, fastest, strongest = limits.T
    up, down = np.maximum(swung.max(axis=0), 0.0), np.maximum(-swung.min(axis=0), 0.0)
    rooms = np.array([high - centre, centre - low, fastest, strongest])
    uses = np.array([up, down, np.abs(speed).max(axis=0), np.abs(pull).max(axis=0)])
    ratio = np.maximum(rooms, 0.0) / np.maximum(uses, 1e-300)
    return np.minimum(ratio.min(axis=0), 1e300)


def _softer(
    factor: Float, swung: Float, speed: Float, pull: Float, centre: Float, limits: Float, doublings: int
) -> Float:
    """Return the factor (J,) that brings the norm of all uses of the limits to one, from the `largest_factor`."""
    low, high, fastest, strongest = limits.T
    scale = np.minimum(factor, 1e200)  # without a swing nothing is met
    room = np.maximum(np.where(swung > 0.0, high - centre, centre - low), 1e-300)
    uses = scale * np.array([swung / room, speed / fastest, pull / strongest])
    order = 2**doublings
    norm = np.maximum((np.abs(uses) ** order).mean(axis=1).sum(axis=0), 1e-300) ** (1.0 / order)
    return np.where(factor > 1e200, factor, factor / norm)


def products(model: Model) -> tuple[Entries, Any]:
    """Return the (joint, number, number) of every product that is not zero, and the CasADi function of their values.

    It takes (state (1 + 4J,), numbers (P + S,)), the state's signs being means over a sample's cell: in a cell with a
    reversal the product is averaged over both signs, so that sgn² stays one.
    """
    import casadi

    count = len(model.parameters) + len(model.shapes)
    joints = len(model.joints)
    state, numbers = casadi.SX.sym("state", 1 + 4 * joints), casadi.SX.sym("numbers", count)
    rows = _function(model)(state, numbers)
    pattern = [[p for p in range(rows.shape[1]) if rows.sparsity().has_nz(j, p)] for j in range(joints)]
    entries = tuple((j, p, r) for j in range(joints) for i, p in enumerate(pattern[j]) for r in pattern[j][i:])
    values = casadi.vertcat(*(rows[j, p] * rows[j, r] for j, p, r in entries))
    for sign in (state[1 + 3 * joints + j] for j in range(joints)):
        forward, backward = casadi.substitute([values], [sign], [1])[0], casadi.substitute([values], [sign], [-1])[0]
        values = casadi.simplify(0.5 * (forward + backward)) + sign * casadi.simplify(0.5 * (forward - backward))
    return entries, casadi.Function("terms", [state, numbers], [casadi.densify(values)], {"cse": True})


def _source(model: Model, harmonics: int) -> GeneratedC:
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
