"""The recursive estimator in C99: a struct, no allocation, no dependency but math.h; the numbers of
`diagnosis.watching.estimator` step by step.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from diagnosis.watching.estimator import ROBUST, Estimator, constants
from diagnosis.watching.estimator_c import ESTIMATION, FIELDS, filled
from diagnosis.watching.front import COMMON_ORDER, HALF, ORDER, SIGN_WIDTH, SPIKE, Filters
from diagnosis.watching.window import LEAST_WEIGHT
from ground.text import in_comment
from optimisation.preparation.filtering import STICK
from symbolic.codegen.instructions import PLAIN, scalar_c
from symbolic.model import Model, require_still_base
from symbolic.model_file import Numbers
from symbolic.motion import Float
from workbench.identified import ExportError

if TYPE_CHECKING:
    import numpy as np

USUAL_SCALE = 0.5
"""N·m; the scale of the residual at first, where the model file does not say its Huber thresholds."""
SPREAD, LEAST = 0.3, 0.05
"""A number is known to this part of itself at first, and to no less than this in its unit."""


def write_updater(
    model: Model, numbers: Numbers, *, name: str, sample_time: float | None, cutoff: float
) -> dict[str, str]:
    """Return {file name: text} of the estimator for a loop of period `sample_time` s; ExportError where that is not
    given, or the model has an effect with memory.
    """
    if sample_time is None:
        raise ExportError("the updater needs the period of the control loop", remedy="add --sample-time SECONDS")
    require_still_base(model, "the updater")
    import numpy as np

    function = _columns(model, numbers)
    linear = np.array([numbers.linear[p.name] for p in model.parameters])
    filters = Filters(1.0 / sample_time, cutoff)
    unit = residual_scale(model, numbers)
    start = first_estimator(model, linear, unit, filters.working / filters.stride)
    joints, count = len(model.joints), len(model.parameters)
    values = {
        "FIELDS": FIELDS.rstrip(), "ESTIMATION": ESTIMATION, "TYPE": f"{name}_updater", "name": name,
        "guard": f"{name}_updater_h".upper(), "J": joints, "P": count, "W": count + 2,
        "MODEL": in_comment(model.name),
        "NAMES": ", ".join(f"{k}: {in_comment(f'{p.name} [{p.unit}]')}" for k, p in enumerate(model.parameters)),
        "JOINTS": ", ".join(model.joint_names), "TS": repr(sample_time), "RATE": repr(filters.rate),
        "HALF": HALF, "RING": 2 * HALF + 1, "SPIKE": repr(SPIKE), "ORDER": ORDER, "COMMON": COMMON_ORDER,
        "KEEP": repr(filters.keep), "SECOND": repr(filters.common), "FACTOR": filters.factor,
        "STRIDE": filters.stride, "STICK": repr(STICK), "REACH": repr(filters.reach), "SIGN": repr(SIGN_WIDTH),
        "LEAST": repr(LEAST_WEIGHT), **constants(start), "DELAY": f"{filters.delay:.3g}",
        "LINEAR": _list(linear), "SPREAD": _list(np.sqrt(start.variance)), "FORGET": _list(start.forget),
        "UNIT": _list(unit), "BODY": _body(function, joints),
        "OPERATIONS": _operations(function, joints, count, filters),
    }  # fmt: skip
    return {f"{name}_updater.h": filled(_HEADER, values), f"{name}_updater.c": filled(_SOURCE, values)}


def first_estimator(model: Model, linear: Float, unit: Float, rate: float) -> Estimator:
    """Return an estimator that begins at identified numbers (P,); `unit` (J,) N·m is the scale of the residual."""
    names, units = [p.name for p in model.parameters], [p.unit for p in model.parameters]
    return Estimator.start(names, units, linear, SPREAD * abs(linear) + LEAST, unit, rate, len(model.inertial))


def residual_scale(model: Model, numbers: Numbers) -> np.ndarray:
    """Return the scale (J,) of the residual at first, N·m."""
    import numpy as np

    if numbers.delta is None:
        return np.full(len(model.joints), USUAL_SCALE)
    return np.maximum(np.array(numbers.delta) / ROBUST, 1e-3)


def _columns(model: Model, numbers: Numbers) -> Any:
    """Return the CasADi function of all columns (J · P,), row by row, at the identified numbers."""
    import casadi as ca

    from symbolic.codegen.equation import model_expressions

    x = model_expressions(model)
    if x.memories:
        raise ExportError(
            "the model has an effect with memory, whose columns the updater cannot follow",
            remedy="leave that effect out of the model, or estimate in Python with exoid watch",
        )
    joints, count = len(model.joints), len(model.parameters)
    cells = [ca.SX(0)] * (joints * count)
    for j, p, expression in x.columns:
        cells[j * count + p] = cells[j * count + p] + expression
    linear = ca.SX(ca.DM([numbers.linear[p.name] for p in model.parameters]))
    shape = ca.SX(ca.DM([numbers.shape[s.name] for s in model.shapes]))
    put = ca.substitute([ca.densify(ca.vertcat(*cells))], [x.linear, x.shape], [linear, shape])[0]
    given = [x.t, x.q, x.dq, x.ddq, x.sign]
    return ca.Function("columns", given, [put], ["t", "q", "dq", "ddq", "sign"], ["columns"], {"cse": True})


def _body(function: Any, joints: int) -> str:
    names = [("t",), *(tuple(f"{word}[{j}]" for j in range(joints)) for word in ("q", "dq", "ddq", "sign"))]
    return scalar_c(function, names, "columns[{k}] = {value};", PLAIN)


def _operations(function: Any, joints: int, count: int, filters: Filters) -> str:
    """Return how much a period takes, in words; counted, not measured."""
    always = 2 * joints * ORDER * 3 + joints * (2 * HALF + 1) ** 2
    working = function.n_instructions() + joints * (count + 2) * COMMON_ORDER * 3
    kept = joints * 6 * count**2 + count**3 // 3 + 8 * count**2
    return (
        f"about {always} operations in every period, {working} more in every {_nth(filters.factor)}, and {kept} more "
        f"in every {_nth(filters.factor * filters.stride)}"
    )


def _nth(number: int) -> str:
    return f"{number}th" if number > 1 else "one"


def _list(values: np.ndarray) -> str:
    return ", ".join(repr(float(v)) for v in values)


_HEADER = """/* @MODEL@:
 * its numbers, followed while it runs. Written by exoid; do not edit.
 *
 * A square-root information filter with a forgetting factor per parameter, which rests without excitation. Nothing is
 * allocated; all it remembers is in the struct. The answer is @DELAY@ s late.
 * Takes @OPERATIONS@.
 * Joints: @JOINTS@. Period of the loop: @TS@ s; call the step once per period.
 * Parameters: @NAMES@.
 */
#ifndef @guard@
#define @guard@

#ifdef __cplusplus
extern "C" {
#endif

typedef struct @name@_updater {
@FIELDS@
  double angle[@RING@][@J@], torque[@RING@][@J@];
  double first[@ORDER@][2 * @J@], smooth[3][2 * @J@];
  double second[@COMMON@][@J@][@W@];
  long samples, filtered;
  int next, working, kept;
} @name@_updater;

/* Begins at the identified numbers. */
void @name@_updater_init(@name@_updater *u);

/* One sample: t [s], angles q [rad], torques tau [N.m]. Returns 1 where the numbers were updated. A sample that is not
   finite is passed over: the filters go on with the one before. */
int @name@_updater_step(@name@_updater *u, double t, const double q[@J@], const double tau[@J@]);

/* Standard deviations of the numbers, valid although residuals resemble their neighbours; 0 where the blocks remembered
   (u->blocks) are fewer than four. */
void @name@_updater_spread(const @name@_updater *u, double spread[@P@]);

#ifdef __cplusplus
}
#endif
#endif
"""

_SOURCE = """/* Written by exoid; do not edit. See @name@_updater.h. */
#include "@name@_updater.h"

#include <math.h>

enum { J = @J@, P = @P@, W = @W@, RING = @RING@ };

static void regressor(double t, const double q[J], const double dq[J], const double ddq[J], const double sign[J],
                      double columns[J * P]) {
  (void)t;
  (void)q;
  (void)dq;
  (void)ddq;
  (void)sign;
@BODY@
}

void @name@_updater_init(@name@_updater *u) {
  static const double linear[P] = {@LINEAR@};
  static const double spread[P] = {@SPREAD@};
  static const double forget[P] = {@FORGET@};
  static const double unit[J] = {@UNIT@};
  static const @name@_updater empty; /* all zero */
  int k;
  *u = empty;
  for (k = 0; k < P; ++k) {
    u->linear[k] = linear[k];
    u->forget[k] = forget[k];
    u->variance[k] = spread[k] * spread[k];
    u->root[k][k] = 1.0 / spread[k];
    u->right[k] = linear[k] / spread[k];
  }
  for (k = 0; k < J; ++k) u->scale[k] = u->unit[k] = unit[k];
}

static double median(const double values[RING]) {
  double sorted[RING];
  int i, k;
  for (i = 0; i < RING; ++i) {
    const double value = values[i];
    for (k = i; k > 0 && sorted[k - 1] > value; --k) sorted[k] = sorted[k - 1];
    sorted[k] = value;
  }
  return sorted[RING / 2];
}

@ESTIMATION@
int @name@_updater_step(@name@_updater *u, double t, const double q[J], const double tau[J]) {
  double x[2 * J], pose[J], speed[J], rise[J], sign[J], flat[J * P], columns[J][P], torque[J];
  int use[J], j, k, p, place, before;
  before = u->samples ? (u->next + RING - 1) % RING : -1;
  for (j = 0; j < J; ++j) {
    const int whole = isfinite(q[j]) && isfinite(tau[j]);
    if (!whole && before < 0) return 0;
    u->angle[u->next][j] = whole ? q[j] : u->angle[before][j];
    u->torque[u->next][j] = whole ? tau[j] : u->torque[before][j];
  }
  u->next = (u->next + 1) % RING;
  if (++u->samples < RING) return 0;
  u->samples = RING;
  place = (u->next + @HALF@) % RING;
  for (j = 0; j < J; ++j) {
    double values[RING], middle, scale;
    for (k = 0; k < RING; ++k) values[k] = u->torque[k][j];
    middle = median(values);
    for (k = 0; k < RING; ++k) values[k] = fabs(u->torque[k][j] - middle);
    scale = median(values) / 0.6745;
    x[j] = u->angle[place][j];
    x[J + j] = fabs(u->torque[place][j] - middle) > @SPIKE@ * scale ? middle : u->torque[place][j];
  }
  for (j = 0; j < 2 * J; ++j) {
    for (k = 0; k < @ORDER@; ++k) {
      if (!u->filtered) u->first[k][j] = x[j];
      u->first[k][j] = (1.0 - @KEEP@) * x[j] + @KEEP@ * u->first[k][j];
      x[j] = u->first[k][j];
    }
    u->smooth[0][j] = u->smooth[1][j];
    u->smooth[1][j] = u->smooth[2][j];
    u->smooth[2][j] = x[j];
  }
  if (++u->filtered < 3) return 0;
  u->filtered = 3;
  p = u->working;
  u->working = (u->working + 1) % @FACTOR@;
  if (p) return 0;
  for (j = 0; j < J; ++j) {
    pose[j] = u->smooth[1][j];
    speed[j] = 0.5 * @RATE@ * (u->smooth[2][j] - u->smooth[0][j]);
    rise[j] = @RATE@ * @RATE@ * (u->smooth[2][j] - 2.0 * u->smooth[1][j] + u->smooth[0][j]);
    sign[j] = tanh(speed[j] / @SIGN@);
  }
  regressor(t - (@HALF@ + 1) * @TS@, pose, speed, rise, sign, flat);
  for (j = 0; j < J; ++j) {
    const double weight = fabs(speed[j]) > @STICK@ + @REACH@ * fabs(rise[j]) ? 1.0 : 0.0;
    double total;
    for (p = 0; p < W; ++p) {
      double value = p == 0 ? weight : p == 1 ? weight * u->smooth[1][J + j] : weight * flat[j * P + p - 2];
      for (k = 0; k < @COMMON@; ++k) {
        u->second[k][j][p] = (1.0 - @SECOND@) * value + @SECOND@ * u->second[k][j][p];
        value = u->second[k][j][p];
      }
    }
    total = u->second[@COMMON@ - 1][j][0];
    use[j] = total > @LEAST@;
    if (total < 1e-6) total = 1e-6;
    torque[j] = u->second[@COMMON@ - 1][j][1] / total;
    for (p = 0; p < P; ++p) columns[j][p] = u->second[@COMMON@ - 1][j][p + 2] / total;
  }
  p = u->kept;
  u->kept = (u->kept + 1) % @STRIDE@;
  return p ? 0 : estimate(u, columns, torque, use);
}

void @name@_updater_spread(const @name@_updater *u, double spread[P]) {
  double inverse[P][P], bread[P][P];
  int k, m, n;
  invert((const double(*)[P])u->root, inverse);
  for (k = 0; k < P; ++k)
    for (m = 0; m < P; ++m) {
      bread[k][m] = 0.0;
      for (n = 0; n < P; ++n) bread[k][m] += inverse[k][n] * inverse[m][n];
    }
  for (k = 0; k < P; ++k) {
    double square = 0.0;
    for (m = 0; m < P; ++m)
      for (n = 0; n < P; ++n) square += bread[k][m] * u->meat[m][n] * bread[n][k];
    spread[k] = u->blocks < 4.0 || square < 0.0 ? 0.0 : sqrt(square);
  }
}
"""
