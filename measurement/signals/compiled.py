"""What is done to rows of samples in C where there is a compiler: filtering both ways, bridging, banded equations."""

from __future__ import annotations

from ctypes import c_long, c_void_p
from functools import lru_cache

import numpy as np

from symbolic.codegen.cache import CompiledLibrary, GeneratedC, load_library
from symbolic.codegen.compiler import FAST
from symbolic.motion import Float

POLES = 2
"""Pairs of poles of the filter that everything goes through."""

LANES = 8
"""Rows that are filtered side by side in C; fewer are filtered by products."""

_SOURCE = """
#include <stdlib.h>
#include <string.h>
#define WIDE 4
#define VECTORS (LANES / WIDE)
typedef double V __attribute__((vector_size(8 * WIDE), aligned(8), may_alias));

/* One sample more: state * pole + x[n]. */
#define STEP                                                                   \\
  for (int p = 0; p < POLES; ++p)                                              \\
    for (int v = 0; v < VECTORS; ++v) {                                        \\
      const V r = re[p][v], i = im[p][v];                                      \\
      re[p][v] = pole[2 * p] * r + (x[n][v] - pole[2 * p + 1] * i);            \\
      im[p][v] = pole[2 * p] * i + pole[2 * p + 1] * r;                        \\
    }
#define ADD_UP                                                                 \\
  for (int p = 0; p < POLES; ++p)                                              \\
    for (int v = 0; v < VECTORS; ++v) sum[v] += factor[2 * p] * re[p][v] - factor[2 * p + 1] * im[p][v];

/* x: the samples of LANES rows side by side; out: those kept, the same way. */
static void filter(long samples, long first, long step, long count, double extra, const double *pole,
                   const double *factor, const V (*restrict x)[VECTORS], V (*restrict out)[VECTORS]) {
  V re[POLES][VECTORS], im[POLES][VECTORS];
  memset(re, 0, sizeof re);
  memset(im, 0, sizeof im);
  long n = 0;
  for (long j = 0; j < count; ++j) {
    for (const long k = first + j * step; n <= k; ++n) { STEP }
    V sum[VECTORS];
    for (int v = 0; v < VECTORS; ++v) sum[v] = extra * x[n - 1][v];
    ADD_UP
    memcpy(out[j], sum, sizeof sum);
  }
  memset(re, 0, sizeof re);
  memset(im, 0, sizeof im);
  n = samples - 1;
  for (long j = count - 1; j >= 0; --j) {
    for (const long k = first + j * step; n >= k; --n) { STEP }
    V sum[VECTORS];
    memcpy(sum, out[j], sizeof sum);
    ADD_UP
    memcpy(out[j], sum, sizeof sum);
  }
}

/* 0, or 1 where there is no memory. */
int exoid_both_ways_at(long rows, long samples, long first, long step, long count, long before, long after,
                       double extra, const double *poles, const double *factors, const double *x, double *out) {
  const long all = before + samples + after;
  double *beside = malloc((size_t)(all + count) * LANES * sizeof(double));
  if (!beside) return 1;
  double *kept = beside + all * LANES;
  for (long at = 0; at < rows; at += LANES) {
    const int some = (int)(rows - at < LANES ? rows - at : LANES);
    const double *row[LANES];
    for (int k = 0; k < LANES; ++k) row[k] = x + (at + (k < some ? k : 0)) * samples;
    double *to = beside;
    for (long n = before; n > 0; --n, to += LANES)
      for (int k = 0; k < LANES; ++k) to[k] = 2.0 * row[k][0] - row[k][n];
    for (long n = 0; n < samples; ++n, to += LANES)
      for (int k = 0; k < LANES; ++k) to[k] = row[k][n];
    for (long n = samples - 2; n > samples - 2 - after; --n, to += LANES)
      for (int k = 0; k < LANES; ++k) to[k] = 2.0 * row[k][samples - 1] - row[k][n];
    filter(all, before + first, step, count, extra, poles, factors, (const V(*)[VECTORS])beside,
           (V(*)[VECTORS])kept);
    for (long j = 0; j < count; ++j)
      for (int k = 0; k < some; ++k) out[(at + k) * count + j] = kept[j * LANES + k];
  }
  free(beside);
  return 0;
}

/* Solves A x = right in place, A symmetric and positive definite with two diagonals beside its own (LDL'). */
void exoid_pentadiagonal(long n, double *own, double *next, double *second, double *x) {
  for (long i = 0; i < n; ++i) {
    const double by_one = i + 1 < n ? next[i] / own[i] : 0.0, by_two = i + 2 < n ? second[i] / own[i] : 0.0;
    if (i + 1 < n) {
      own[i + 1] -= by_one * next[i];
      x[i + 1] -= by_one * x[i];
    }
    if (i + 2 < n) {
      next[i + 1] -= by_one * second[i];
      own[i + 2] -= by_two * second[i];
      x[i + 2] -= by_two * x[i];
    }
    next[i] = by_one;
    second[i] = by_two;
  }
  for (long i = n - 1; i >= 0; --i) {
    x[i] /= own[i];
    if (i + 1 < n) x[i] -= next[i] * x[i + 1];
    if (i + 2 < n) x[i] -= second[i] * x[i + 2];
  }
}

/* Puts lines across hidden samples; the ends of a line are means of `beside`, end after end from `begins` on. */
void exoid_bridge(long rows, long stride, long hidden, const long *at, const long *ends, const double *share,
                  long means, const long *begins, const long *beside, double *level, double *x) {
  for (long k = 0; k < rows; ++k, x += stride) {
    for (long m = 0; m < means; ++m) {
      double sum = 0.0;
      for (long n = begins[m]; n < begins[m + 1]; ++n) sum += x[beside[n]];
      level[m] = sum / (double)(begins[m + 1] - begins[m]);
    }
    for (long h = 0; h < hidden; ++h) {
      const double before = level[ends[h]];
      x[at[h]] = before + share[h] * (level[ends[hidden + h]] - before);
    }
  }
}
"""
"""Filters rows both ways and keeps every step-th sample: what came before is carried forwards, what comes after is
carried backwards, mode by mode. Reflections beyond the ends are as many as products take."""


@lru_cache
def row_library(poles: int) -> CompiledLibrary | None:
    """Return `exoid_both_ways_at` for filters of so many poles, and the other functions; None without a compiler."""
    text = f"#define POLES {poles}\n#define LANES {LANES}\n{_SOURCE}"
    return load_library("rows", text, FAST, lambda: GeneratedC(text, FAST, {}))


def solved_banded(bands: Float, right: Float) -> Float:
    """Return x (N,) of A x = `right` (N,), A symmetric and positive definite with `bands` (3, N): the second diagonal
    from place 2 on, the first from place 1 on, its own. SciPy does it without a compiler; its import takes longer.
    """
    library = row_library(POLES)
    if library is None:
        from scipy.linalg import solveh_banded

        return np.asarray(solveh_banded(bands, right))
    second, first, own = (np.append(band[k:], np.zeros(k)) for k, band in zip((2, 1, 0), bands, strict=True))
    x = np.array(right, dtype=float)
    library.c.exoid_pentadiagonal(c_long(x.size), *(c_void_p(each.ctypes.data) for each in (own, first, second, x)))
    return x
