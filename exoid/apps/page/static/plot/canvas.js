// A canvas that is sharp on every screen and knows the colours of the page, in light and in dark.

export class Surface {
  // `draw(context, width, height)` paints and says whether there was anything; `dark` is called when light and dark change.
  constructor(canvas, draw, dark) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.paint = draw;
    this.waiting = false;
    this.width = 0;
    this.height = 0;
    new ResizeObserver(() => this.draw()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", dark);
  }

  // Draws before the next frame, however often it is asked to.
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      const { clientWidth: width, clientHeight: height } = this.canvas;
      if (!width || !height) return;
      const ratio = devicePixelRatio || 1;
      if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
        this.canvas.width = Math.round(width * ratio);
        this.canvas.height = Math.round(height * ratio);
      }
      this.width = width;
      this.height = height;
      this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
      this.context.clearRect(0, 0, width, height);
      this.context.font = "12px system-ui, sans-serif";
      if (this.paint(this.context, width, height)) this.canvas.dataset.drawn = "true";
    });
  }

  // Frames the plot that has the keyboard.
  focus(frame) {
    if (document.activeElement !== this.canvas) return;
    this.context.strokeStyle = this.colour("accent");
    this.context.lineWidth = 2;
    this.context.strokeRect(frame.left, frame.top, frame.right - frame.left, frame.bottom - frame.top);
  }

  colour(name) {
    return getComputedStyle(this.canvas).getPropertyValue(`--${name}`).trim() || "gray";
  }
}

export function ticks(low, high, most) {
  const span = high - low;
  if (!(span > 0 && span < Infinity)) return [low];
  const rough = span / Math.max(1, most);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
  const out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * span; k++) out.push(k * step);
  return out.length > 1 ? out : ticks(low, high, 2 * Math.max(1, most)); // one number tells no scale
}

export function tickText(value, step) {
  const places = Math.max(0, Math.min(6, -Math.floor(Math.log10(step || 1) + 1e-9)));
  return (Math.abs(value) < 1e-12 ? 0 : value).toFixed(places).replace("-", "−");
}

// Axes with grid and numbers in the frame {left, right, top, bottom}; returns functions from values to pixels.
export function axes(surface, frame, x, y, words) {
  const { context } = surface;
  const px = (v) => frame.left + ((v - x[0]) / (x[1] - x[0])) * (frame.right - frame.left);
  const py = (v) => frame.bottom - ((v - y[0]) / (y[1] - y[0])) * (frame.bottom - frame.top);
  const grid = surface.colour("line"), faint = surface.colour("faint");
  context.lineWidth = 1;
  context.strokeStyle = grid;
  context.fillStyle = faint;
  const xs = ticks(x[0], x[1], (frame.right - frame.left) / 80), ys = ticks(y[0], y[1], (frame.bottom - frame.top) / 24);
  context.beginPath();
  for (const v of xs) {
    context.moveTo(Math.round(px(v)) + 0.5, frame.top);
    context.lineTo(Math.round(px(v)) + 0.5, frame.bottom);
  }
  for (const v of ys) {
    context.moveTo(frame.left, Math.round(py(v)) + 0.5);
    context.lineTo(frame.right, Math.round(py(v)) + 0.5);
  }
  context.stroke();
  context.textBaseline = "middle";
  context.textAlign = "right";
  for (const v of ys) context.fillText(tickText(v, ys[1] - ys[0]), frame.left - 5, py(v));
  if (words.x !== undefined) {
    context.textBaseline = "top";
    context.textAlign = "center";
    for (const v of xs) context.fillText(tickText(v, xs[1] - xs[0]), px(v), frame.bottom + 4);
    context.textAlign = "right";
    context.fillText(words.x, frame.right, frame.bottom + 18);
  }
  context.textAlign = "left";
  context.textBaseline = "bottom";
  context.fillText(words.y, frame.left - 44, frame.top - 4);
  return { px, py };
}
