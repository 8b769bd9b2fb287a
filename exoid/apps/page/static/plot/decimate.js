// A long signal drawn in as many columns as there are pixels: the least and the largest value of each column.

const STEP = 8;
const LEVELS_FROM = 4096;

// Least and largest of ever longer stretches, so that any range needs about as many looks as pixels.
export class Pyramid {
  constructor(values) {
    this.values = values;
    this.levels = [];
    let low = values, high = values;
    while (low.length > LEVELS_FROM) {
      const count = Math.ceil(low.length / STEP);
      const nextLow = new Float32Array(count), nextHigh = new Float32Array(count);
      for (let k = 0; k < count; k++) {
        let a = Infinity, b = -Infinity;
        for (let i = k * STEP; i < Math.min(low.length, (k + 1) * STEP); i++) {
          if (low[i] < a) a = low[i];
          if (high[i] > b) b = high[i];
        }
        nextLow[k] = a <= b ? a : NaN;
        nextHigh[k] = a <= b ? b : NaN;
      }
      this.levels.push({ low: nextLow, high: nextHigh });
      low = nextLow;
      high = nextHigh;
    }
  }

  // [least, largest] of the samples from..to (to excluded), NaN where there is none.
  between(from, to) {
    let a = Infinity, b = -Infinity, level = 0, size = 1;
    from = Math.max(0, from);
    to = Math.min(this.values.length, to);
    while (level < this.levels.length && to - from > 2 * STEP * size) {
      level += 1;
      size *= STEP;
    }
    const { low, high } = level ? this.levels[level - 1] : { low: this.values, high: this.values };
    const last = Math.min(low.length, Math.ceil(to / size));
    for (let k = Math.floor(from / size); k < last; k++) {
      if (low[k] < a) a = low[k];
      if (high[k] > b) b = high[k];
    }
    return a <= b ? [a, b] : [NaN, NaN];
  }
}

const made = new WeakMap();

export function pyramid(values) {
  if (!made.has(values)) made.set(values, new Pyramid(values));
  return made.get(values);
}

export function extent(series, from = 0, to = Infinity) {
  let a = Infinity, b = -Infinity;
  for (const values of series) {
    const [low, high] = pyramid(values).between(from, Math.min(to, values.length));
    if (low < a) a = low;
    if (high > b) b = high;
  }
  return a <= b ? [a, b] : [-1, 1];
}
