"""The recursive estimator in C99, for the controller (`exoid export --updater`) and for `Estimator.steps`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from exoid.symbolic.codegen.cache import CompiledLibrary, GeneratedC, load_library
from exoid.symbolic.codegen.compiler import EXACT


def filled(text: str, values: Mapping[str, Any]) -> str:
    """Return `text` with a value for every @KEY@."""
    for key, value in values.items():
        text = text.replace(f"@{key}@", str(value))
    return text


def layout(count: int, joints: int) -> np.dtype[Any]:
    """Return `FIELDS` as NumPy sees them, for `count` parameters."""
    p, j, square = (count,), (joints,), (count, count)
    shapes = {"linear": p, "variance": p, "root": square, "right": p, "credit": p, "score": p, "meat": square,
              "pace": p, "blocks": p, "feigned": square, "scale": j, "unit": j}  # fmt: skip
    return np.dtype([*((name, "f8", shape) for name, shape in shapes.items()), ("inside", np.intc)], align=True)


def kernel(values: Mapping[str, Any]) -> Any:
    """Return the compiled function for the constants `values`; None without a compiler."""
    found = _loaded(filled(_KERNEL, {"FIELDS": FIELDS, "ESTIMATION": ESTIMATION, "TYPE": "exoid_estimator", **values}))
    return None if found is None else found.c.exoid_estimate


@cache
def _loaded(text: str) -> CompiledLibrary | None:
    return load_library("estimator", text, EXACT, lambda: GeneratedC(text, EXACT, {}))


FIELDS = """  double linear[@P@];   /* the numbers as they are now */
  double variance[@P@]; /* as white noise of the first scale would have it, not valid for intervals */
  double root[@P@][@P@], right[@P@], credit[@P@], score[@P@], meat[@P@][@P@], pace[@P@];
  double blocks[@P@];   /* remembered of each number, in blocks of its intervals */
  double feigned[@P@][@P@]; /* the part of the information that noise of the angles makes up */
  double scale[@J@], unit[@J@];
  int inside;
"""

_KERNEL = """#include <math.h>

enum { J = @J@, P = @P@ };

typedef struct @TYPE@ {
@FIELDS@} @TYPE@;

@ESTIMATION@
void exoid_estimate(@TYPE@ *u, long count, double *columns, const double *tau, const int *use, double *errors) {
  long k;
  for (k = 0; k < count; ++k)
    estimate(u, (double(*)[P])(columns + k * J * P), tau + k * J, use + k * J,
             (double(*)[J][P])(errors + k * J * J * P));
}
"""

ESTIMATION = """static double weight_of(const @TYPE@ *u, int j, double left) {
  const double size = fabs(left) > 1e-300 ? fabs(left) : 1e-300, inside = @ROBUST@ * u->scale[j] / size;
  return (inside < 1.0 ? inside : 1.0) / (u->unit[j] * u->unit[j]);
}

static void rotate(@TYPE@ *u, const double given[P], double value, double weight) {
  double row[P];
  int k, m;
  for (k = 0; k < P; ++k) row[k] = given[k] * weight;
  value *= weight;
  for (k = 0; k < P; ++k) {
    double size, c, s, old;
    if (row[k] == 0.0) continue;
    size = hypot(u->root[k][k], row[k]);
    c = u->root[k][k] / size;
    s = row[k] / size;
    for (m = k; m < P; ++m) {
      old = u->root[k][m];
      u->root[k][m] = c * old + s * row[m];
      row[m] = c * row[m] - s * old;
    }
    old = u->right[k];
    u->right[k] = c * old + s * value;
    value = c * value - s * old;
  }
}

static void invert(const double root[P][P], double inverse[P][P]) {
  int i, k, m;
  for (k = 0; k < P; ++k) {
    for (i = 0; i < P; ++i) inverse[i][k] = 0.0;
    inverse[k][k] = 1.0 / root[k][k];
    for (i = k - 1; i >= 0; --i) {
      double sum = 0.0;
      for (m = i + 1; m <= k; ++m) sum += root[i][m] * inverse[m][k];
      inverse[i][k] = -sum / root[i][i];
    }
  }
}

/* into = a b, or a b' */
static void product(double a[P][P], double b[P][P], int turned, double into[P][P]) {
  int k, m, n;
  for (k = 0; k < P; ++k)
    for (m = 0; m < P; ++m) {
      into[k][m] = 0.0;
      for (n = 0; n < P; ++n) into[k][m] += a[k][n] * (turned ? b[m][n] : b[n][m]);
    }
}

/* As if the numbers had moved by steps of covariance by by' since the last sample; `known` where they have, and their
   size counts. */
static void moved(@TYPE@ *u, double by[P][P], int known) {
  double inverse[P][P], rows[P][2 * P + 1], step[2 * P + 1], whole[P][P], left[P][P], one[P][P];
  int c, i, k, m, n;
  invert((const double(*)[P])u->root, inverse);
  for (k = 0; k < P; ++k) {
    for (m = 0; m < P; ++m) {
      rows[k][m] = 0.0;
      for (n = k; n < P; ++n) rows[k][m] -= u->root[k][n] * by[n][m];
      rows[k][P + m] = u->root[k][m];
    }
    rows[k][2 * P] = u->right[k];
  }
  for (c = 0; c < P; ++c) {
    for (n = 0; n <= 2 * P; ++n) step[n] = 0.0;
    step[c] = 1.0;
    for (i = P - 1; i >= 0; --i) {
      double length, turn, lean;
      if (rows[i][c] == 0.0) continue;
      length = hypot(step[c], rows[i][c]);
      turn = step[c] / length;
      lean = rows[i][c] / length;
      for (n = c; n <= 2 * P; ++n) {
        const double old = step[n];
        step[n] = turn * old + lean * rows[i][n];
        rows[i][n] = turn * rows[i][n] - lean * old;
      }
    }
  }
  for (k = 0; k < P; ++k) {
    for (m = 0; m < P; ++m) u->root[k][m] = m < k ? 0.0 : rows[k][P + m];
    u->right[k] = rows[k][2 * P];
  }
  for (k = 0; k < P; ++k)
    for (m = 0; m < P; ++m) {
      whole[k][m] = 0.0;
      for (n = 0; n <= k && n <= m; ++n) whole[k][m] += u->root[n][k] * u->root[n][m];
    }
  product(whole, inverse, 0, one);
  product(one, inverse, 1, left);
  for (k = 0; k < P; ++k) {
    step[k] = 0.0;
    for (m = 0; m < P; ++m) step[k] += left[k][m] * u->score[m];
  }
  for (k = 0; k < P; ++k) u->score[k] = step[k];
  product(left, u->feigned, 0, one);
  for (k = 0; k < P; ++k)
    for (m = 0; m < P; ++m) u->feigned[k][m] = one[k][m];
  product(left, u->meat, 0, one);
  product(one, left, 1, u->meat);
  if (!known) return;
  product(whole, by, 0, one);
  product(one, one, 1, left);
  for (k = 0; k < P; ++k)
    for (m = 0; m < P; ++m) u->meat[k][m] += left[k][m];
}

static int estimate(@TYPE@ *u, double columns[J][P], const double tau[J], const int use[J],
                    double errors[J][J][P]) {
  double inverse[P][P], lost[P], plain[P], rest[P];
  int i, j, k, m, any = 0;
  for (j = 0; j < J; ++j) {
    double left = tau[j], most, square, weight;
    if (!use[j]) continue;
    any = 1;
    for (k = 0; k < P; ++k) left -= columns[j][k] * u->linear[k];
    weight = weight_of(u, j, left);
    rotate(u, columns[j], tau[j], sqrt(weight));
    for (i = 0; i < J; ++i)
      for (k = 0; k < P; ++k)
        for (m = 0; m < P; ++m) u->feigned[k][m] += weight * errors[j][i][k] * errors[j][i][m];
    square = u->scale[j] * u->scale[j];
    most = left * left < 9.0 * square ? left * left : 9.0 * square;
    u->scale[j] = sqrt(square + @FOLLOW@ * (most - square));
  }
  if (!any) return 0;
  invert((const double(*)[P])u->root, inverse);
  for (k = 0; k < P; ++k) {
    double value = 0.0, variance = 0.0, gain, most = @CREDIT@ * u->pace[k];
    for (m = k; m < P; ++m) {
      value += inverse[k][m] * u->right[m];
      variance += inverse[k][m] * inverse[k][m];
    }
    u->linear[k] = plain[k] = value;
    gain = 1.0 - variance / u->variance[k];
    gain = gain < 0.0 ? 0.0 : gain > 1.0 ? 1.0 : gain;
    u->credit[k] = u->credit[k] + gain < most ? u->credit[k] + gain : most;
    lost[k] = u->pace[k] < u->credit[k] ? u->pace[k] : u->credit[k];
    u->credit[k] -= lost[k];
    u->blocks[k] *= (1.0 - lost[k]) * (1.0 - lost[k]);
    u->variance[k] = variance / (1.0 - lost[k]);
  }
  for (i = 0; i < @TERMS@; ++i) {
    double back[P];
    for (k = 0; k < P; ++k) {
      rest[k] = 0.0;
      for (m = 0; m < P; ++m) rest[k] += u->feigned[k][m] * u->linear[m];
    }
    for (k = 0; k < P; ++k) {
      back[k] = 0.0;
      for (m = 0; m <= k; ++m) back[k] += inverse[m][k] * rest[m];
    }
    for (k = 0; k < P; ++k) {
      u->linear[k] = plain[k];
      for (m = k; m < P; ++m) u->linear[k] += inverse[k][m] * back[m];
    }
  }
  for (k = 0, any = 0; k < P; ++k) {
    any = any || lost[k] > 0.0;
    for (m = 0; m < P; ++m) inverse[k][m] *= sqrt(lost[k] / (1.0 - lost[k]));
  }
  if (any) moved(u, inverse, 0);
  for (j = 0; j < J; ++j) {
    double left = tau[j], weight;
    if (!use[j]) continue;
    for (k = 0; k < P; ++k) left -= columns[j][k] * u->linear[k];
    weight = weight_of(u, j, left);
    for (k = 0; k < P; ++k) u->score[k] += weight * left * columns[j][k];
    for (i = 0; i < J; ++i) {
      double size = 0.0;
      for (k = 0; k < P; ++k) size += errors[j][i][k] * u->linear[k];
      for (k = 0; k < P; ++k) u->score[k] += weight * errors[j][i][k] * size;
    }
  }
  if (++u->inside == @BLOCK@) {
    for (k = 0; k < P; ++k)
      for (m = 0; m < P; ++m) u->meat[k][m] += u->score[k] * u->score[m];
    for (k = 0; k < P; ++k) {
      u->score[k] = 0.0;
      u->blocks[k] += 1.0;
    }
    u->inside = 0;
  }
  return 1;
}
"""

FORGETTING = """static void forget(@TYPE@ *u, const int which[P]) {
  double inverse[P][P], by[P][P];
  int k, m;
  for (k = 0; k < P; ++k) {
    for (m = 0; m < P; ++m) by[k][m] = 0.0;
    if (!which[k]) continue;
    by[k][k] = @FORGOTTEN@ * fabs(u->linear[k]) + @FORGOTTEN_LEAST@;
    u->credit[k] = u->blocks[k] = 0.0;
  }
  moved(u, by, 1);
  invert((const double(*)[P])u->root, inverse);
  for (k = 0; k < P; ++k) {
    u->variance[k] = 0.0;
    for (m = k; m < P; ++m) u->variance[k] += inverse[k][m] * inverse[k][m];
  }
}
"""

SPREADING = """/* bread: the inverse of the information without what noise of the angles makes up. */
static void correct(const @TYPE@ *u, double inverse[P][P], double bread[P][P]) {
  double plain[P][P], step[P][P], next[P][P];
  int i, k, m, n;
  for (k = 0; k < P; ++k)
    for (m = 0; m < P; ++m) {
      plain[k][m] = 0.0;
      for (n = k > m ? k : m; n < P; ++n) plain[k][m] += inverse[k][n] * inverse[m][n];
      bread[k][m] = plain[k][m];
    }
  for (k = 0; k < P; ++k)
    for (m = 0; m < P; ++m) {
      step[k][m] = 0.0;
      for (n = 0; n < P; ++n) step[k][m] += plain[k][n] * u->feigned[n][m];
    }
  for (i = 0; i < @TERMS@; ++i) {
    for (k = 0; k < P; ++k)
      for (m = 0; m < P; ++m) {
        next[k][m] = plain[k][m];
        for (n = 0; n < P; ++n) next[k][m] += step[k][n] * bread[n][m];
      }
    for (k = 0; k < P; ++k)
      for (m = 0; m < P; ++m) bread[k][m] = next[k][m];
  }
}
"""
