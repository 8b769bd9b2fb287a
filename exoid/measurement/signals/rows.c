/* Rows of samples, some side by side: filtered both ways, every step-th sample kept (what came before is carried
   forwards, what comes after backwards, mode by mode; reflections beyond the ends are as many as products take), bridged
   across hidden samples, and banded equations. POLES, pairs of poles of the filter, stands above. */
#include <stdlib.h>
#include <string.h>
#ifdef __AVX512F__
#define WIDE 8
#else
#define WIDE 4
#endif
#define VECTORS 2
#define LANES (VECTORS * WIDE)
typedef double V __attribute__((vector_size(8 * WIDE), aligned(8), may_alias));

/* What lies across runs of hidden samples: see `Bridge`. */
struct bridge {
  long hidden, means;
  const long *at, *ends, *begins, *beside;
  const double *share;
};

/* One sample more: state * pole + x[n]. */
#define STEP                                                                   \
  for (int p = 0; p < POLES; ++p)                                              \
    for (int v = 0; v < VECTORS; ++v) {                                        \
      const V r = re[p][v], i = im[p][v];                                      \
      re[p][v] = pole[2 * p] * r + (x[n][v] - pole[2 * p + 1] * i);            \
      im[p][v] = pole[2 * p] * i + pole[2 * p + 1] * r;                        \
    }
#define ADD_UP                                                                 \
  for (int p = 0; p < POLES; ++p)                                              \
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

/* Puts lines across hidden samples of rows side by side; ends of lines are means of samples `beside`, `level`. */
static inline void bridged(const long lanes, const struct bridge *b, double *restrict level, double *restrict x) {
  for (long m = 0; m < b->means; ++m) {
    double *to = level + m * lanes;
    for (long k = 0; k < lanes; ++k) to[k] = 0.0;
    for (long n = b->begins[m]; n < b->begins[m + 1]; ++n)
      for (long k = 0; k < lanes; ++k) to[k] += x[b->beside[n] * lanes + k];
    for (long k = 0; k < lanes; ++k) to[k] /= (double)(b->begins[m + 1] - b->begins[m]);
  }
  for (long h = 0; h < b->hidden; ++h) {
    const double *from = level + b->ends[h] * lanes, *to = level + b->ends[b->hidden + h] * lanes;
    for (long k = 0; k < lanes; ++k) x[b->at[h] * lanes + k] = from[k] + b->share[h] * (to[k] - from[k]);
  }
}

/* Continues rows side by side, `before` and `after` samples beyond their ends, by their odd reflection. */
static void reflect(long samples, long before, long after, double *x) {
  const double *last = x + (samples - 1) * LANES;
  for (long n = 1; n <= before; ++n)
    for (int k = 0; k < LANES; ++k) x[k - n * LANES] = 2.0 * x[k] - x[k + n * LANES];
  for (long n = 1; n <= after; ++n)
    for (int k = 0; k < LANES; ++k) x[(samples - 1 + n) * LANES + k] = 2.0 * last[k] - last[k - n * LANES];
}

/* 0, or 1 where there is no memory. */
int exoid_both_ways_at(long rows, long samples, long first, long step, long count, long before, long after,
                       double extra, const double *poles, const double *factors, const double *x, double *out) {
  const long all = before + samples + after;
  double *beside = malloc((size_t)(all + count) * LANES * sizeof(double));
  if (!beside) return 1;
  double *kept = beside + all * LANES, *begin = beside + before * LANES;
  for (long at = 0; at < rows; at += LANES) {
    const int some = (int)(rows - at < LANES ? rows - at : LANES);
    const double *row[LANES];
    for (int k = 0; k < LANES; ++k) row[k] = x + (at + (k < some ? k : 0)) * samples;
    for (long n = 0; n < samples; ++n)
      for (int k = 0; k < LANES; ++k) begin[n * LANES + k] = row[k][n];
    reflect(samples, before, after, begin);
    filter(all, before + first, step, count, extra, poles, factors, (const V(*)[VECTORS])beside,
           (V(*)[VECTORS])kept);
    for (long j = 0; j < count; j += WIDE)  /* as many samples of a row as lie side by side */
      for (int k = 0; k < some; ++k)
        for (long i = j; i < j + WIDE && i < count; ++i) out[(at + k) * count + i] = kept[i * LANES + k];
  }
  free(beside);
  return 0;
}

/* Sums over kept samples of products of WIDE waves' columns with each other and with `wide` signals, and what there is
   at each sample at most; `some` of them count. Signals and sums are as in `exoid_wave_products`. */
static void multiply(int some, long all, long columns, long joints, long count, long units, long told, long wide,
                     const double *weights, const double *signals, const V *const *of, double *both, double *square,
                     double *largest) {
  for (long c = 0; c < columns; ++c) {
    for (long q = 0; q < told * wide; q += 4) {
      V sum[4] = {{0}};
      for (long a = 0; a < joints; ++a) {
        const V *x = of[a * columns + c];
        const double *by = signals + (q / wide * joints + a) * count * wide + q % wide;
        for (long k = 0; k < count; ++k)
          for (int i = 0; i < 4; ++i) sum[i] += by[k * wide + i] * x[k * VECTORS];
      }
      for (int k = 0; k < some; ++k)
        for (int i = 0; i < 4; ++i) both[((q / wide * all + k) * columns + c) * wide + q % wide + i] = sum[i][k];
    }
    for (long d = 0; d <= c; ++d)
      for (long u = 0; u < units; u += 4) {
        V sum[4] = {{0}};
        for (long a = 0; a < joints; ++a) {
          const V *x = of[a * columns + c], *y = of[a * columns + d];
          const double *by = weights + a * count * units + u;
          for (long k = 0; k < count; ++k) {
            const V product = x[k * VECTORS] * y[k * VECTORS];
            for (int i = 0; i < 4; ++i) sum[i] += by[k * units + i] * product;
          }
        }
        for (int k = 0; k < some; ++k)
          for (int i = 0; i < 4; ++i) {
            double *to = square + ((u + i) * all + k) * columns * columns;
            to[c * columns + d] = to[d * columns + c] = sum[i][k];
          }
      }
  }
  for (long n = 0; n < count; ++n) {
    V most = {0};
    for (long c = 0; c < columns * joints; ++c) {
      const V x = of[c][n * VECTORS] * of[c][n * VECTORS];
      for (int k = 0; k < WIDE; ++k) most[k] = x[k] > most[k] ? x[k] : most[k];
    }
    for (int k = 0; k < some; ++k) largest[k * count + n] = most[k];
  }
}

/* Filters carried[pair][joint] * sin and cos of `numbers` angles, each a `turn` beyond the one before, the first at
   `start`, bridged as is that joint: columns [number][pair][sine, cosine]. Sums over joints and kept samples of their
   products with weighted signals[unit][joint][kept][wide] of the `told` units go to both[unit][number][column][wide];
   with each other, by weights[joint][kept][unit], to square[unit][number][column][column], units lying `all` numbers
   apart; the largest square at each sample to largest[number][kept]. `wide` and units are multiples of 4.
   0, or 1 without memory. */
int exoid_wave_products(long numbers, long pairs, long joints, long samples, long first, long step, long count,
                        long before, long after, double extra, const double *poles, const double *factors,
                        const double *start, const double *turn, const double *carried, const struct bridge *bridges,
                        long units, long told, long wide, long all, const double *weights,
                        const double *signals, double *both, double *square, double *largest) {
  const long whole = before + samples + after, rows = pairs * joints, columns = 2 * pairs;
  long means = 0;
  for (long a = 0; a < joints; ++a) means = bridges[a].means > means ? bridges[a].means : means;
  double *beside = malloc((size_t)((whole + rows * count + samples + means) * LANES + 2 * samples) * sizeof(double));
  const V **of = malloc((size_t)(2 * rows) * sizeof(V *));
  if (!beside || !of) {
    free(beside);
    free(of);
    return 1;
  }
  double *begin = beside + before * LANES, *kept = beside + whole * LANES, *level = kept + rows * count * LANES;
  V(*const x)[VECTORS] = (V(*)[VECTORS])begin, (*const waves)[VECTORS] = (V(*)[VECTORS])(level + means * LANES);
  double *far = (double *)(waves + samples);
  for (long n = 0; n < samples; ++n) {
    double c[WIDE + 1] = {1.0}, s[WIDE + 1] = {0.0};
    for (int k = 0; k < WIDE; ++k) {
      c[k + 1] = c[k] * turn[2 * n] - s[k] * turn[2 * n + 1];
      s[k + 1] = c[k] * turn[2 * n + 1] + s[k] * turn[2 * n];
    }
    const V cosine = *(const V *)c, sine = *(const V *)s;
    waves[n][0] = start[2 * n + 1] * cosine + start[2 * n] * sine;
    waves[n][1] = start[2 * n] * cosine - start[2 * n + 1] * sine;
    far[2 * n] = c[WIDE];
    far[2 * n + 1] = s[WIDE];
  }
  for (long at = 0; at < numbers; at += WIDE) {
    for (long p = 0; p < rows; ++p) {
      V(*const out)[VECTORS] = (V(*)[VECTORS])(kept + p * count * LANES);
      for (long n = 0; n < samples; ++n)
        for (int way = 0; way < VECTORS; ++way) x[n][way] = carried[p * samples + n] * waves[n][way];
      bridged(LANES, bridges + p % joints, level, begin);
      reflect(samples, before, after, begin);
      filter(whole, before + first, step, count, extra, poles, factors, (const V(*)[VECTORS])beside, out);
      for (int way = 0; way < VECTORS; ++way) of[p % joints * columns + p / joints * 2 + way] = &out[0][way];
    }
    multiply((int)(numbers - at < WIDE ? numbers - at : WIDE), all, columns, joints, count, units, told, wide,
             weights, signals, of, both + at * columns * wide, square + at * columns * columns, largest + at * count);
    for (long n = 0; n < samples; ++n) {
      const V sine = waves[n][0], cosine = waves[n][1];
      waves[n][0] = sine * far[2 * n] + cosine * far[2 * n + 1];
      waves[n][1] = cosine * far[2 * n] - sine * far[2 * n + 1];
    }
  }
  free(beside);
  free(of);
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

/* Bridges rows that lie `stride` apart. */
void exoid_bridge(long rows, long stride, const struct bridge *across, double *level, double *x) {
  for (long k = 0; k < rows; ++k, x += stride) bridged(1, across, level, x);
}
