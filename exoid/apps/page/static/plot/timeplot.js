// Signals over time: zoom and pan, one cursor and one brush for all of them, keys for those who use no mouse.

import { Surface, axes } from "./canvas.js";
import { extent, pyramid } from "./decimate.js";
import { number } from "../format.js";
import { look, view } from "../store.js";

const LEFT = 52, RIGHT = 10, TOP = 20;

export class TimePlot {
  // `content()` returns {dt, t0, count, recording, joint, series: [{values, colour, width, band}], marks, unit, label} or null.
  constructor(canvas, content, options) {
    this.canvas = canvas;
    this.content = content;
    this.options = options;
    this.bottom = options.axis ? 34 : 8;
    this.surface = new Surface(canvas, (context, width, height) => this.paint(context, width, height), () => this.draw());
    canvas.tabIndex = 0;
    this.listen();
  }

  draw() {
    this.surface.draw();
  }

  span(content) {
    return view.range || [0, content.dt * Math.max(1, content.count - 1)];
  }

  paint(context, width, height) {
    const content = this.content();
    if (!content) return false;
    const [from, to] = this.span(content);
    const frame = { left: LEFT, right: width - RIGHT, top: TOP, bottom: height - this.bottom };
    const first = Math.floor(from / content.dt), last = Math.ceil(to / content.dt) + 1;
    let [low, high] = extent(content.series.filter((s) => s.scales !== false).map((s) => s.values), first, last);
    if (content.zero) [low, high] = [Math.min(low, 0), Math.max(high, 0)];
    const pad = 0.06 * (high - low || 1);
    const words = { y: `${content.label} [${content.unit}]`, ...(this.options.axis ? { x: "time [s]" } : {}) };
    const { px, py } = axes(this.surface, frame, [from, to], [low - pad, high + pad], words);
    this.x = { px, from, to, frame, content };
    context.save();
    context.beginPath();
    context.rect(frame.left, frame.top, frame.right - frame.left, frame.bottom - frame.top);
    context.clip();
    this.brush(context, content, frame, px);
    for (const series of content.series) this.line(context, series, content, frame, px, py);
    this.marks(context, content, frame, px);
    if (view.cursor !== null) {
      context.strokeStyle = this.surface.colour("ink");
      context.lineWidth = 1;
      context.beginPath();
      context.moveTo(px(view.cursor), frame.top);
      context.lineTo(px(view.cursor), frame.bottom);
      context.stroke();
      this.dots(context, content, px, py);
    }
    context.restore();
    this.values(context, content, frame);
    if (view.cursor !== null && this.canvas.matches(":hover")) this.tooltip(context, content, frame, px);
    this.surface.focus(frame);
    return true;
  }

  sample(content) {
    return Math.min(content.count - 1, Math.max(0, Math.round(view.cursor / content.dt)));
  }

  dots(context, content, px, py) {
    const k = this.sample(content);
    for (const { values, colour, name } of content.series) {
      if (name === undefined || !Number.isFinite(values[k])) continue;
      context.fillStyle = this.surface.colour(colour);
      context.beginPath();
      context.arc(px(k * content.dt), py(values[k]), 3.5, 0, 2 * Math.PI);
      context.fill();
    }
  }

  // Above the frame, at its right end: what each curve is called, with its value at the cursor.
  values(context, content, frame) {
    context.textAlign = "right";
    context.textBaseline = "bottom";
    let right = frame.right;
    for (const { values, colour, name } of [...content.series].reverse()) {
      if (name === undefined) continue;
      const value = view.cursor === null ? "" : number(values[this.sample(content)]);
      const text = `${name} ${value}`.trim();
      context.fillStyle = this.surface.colour(colour);
      context.fillText(text, right, frame.top - 4);
      right -= context.measureText(text).width + 12;
    }
  }

  // Beside the cursor, in the plot under the pointer: time and values.
  tooltip(context, content, frame, px) {
    const k = this.sample(content);
    const named = content.series.filter((one) => one.name !== undefined);
    const rows = [{ text: `${(k * content.dt).toFixed(2)} s`, colour: "ink" },
      ...named.map(({ values, colour, name }) => ({ text: `${name} ${number(values[k])} ${content.unit}`.trim(), colour }))];
    const width = Math.max(...rows.map(({ text }) => context.measureText(text).width)) + 12, height = 15 * rows.length + 6;
    const at = px(view.cursor), x = at + 10 + width > frame.right ? at - 10 - width : at + 10;
    context.fillStyle = this.surface.colour("paper");
    context.strokeStyle = this.surface.colour("line");
    context.fillRect(x, frame.top, width, height);
    context.strokeRect(x, frame.top, width, height);
    context.textAlign = "left";
    context.textBaseline = "top";
    rows.forEach(({ text, colour }, row) => {
      context.fillStyle = this.surface.colour(colour);
      context.fillText(text, x + 6, frame.top + 5 + 15 * row);
    });
  }

  brush(context, content, frame, px) {
    const s = view.selection;
    if (!s || s.kind !== "time" || s.recording !== content.recording) return;
    if (s.joint !== null && s.joint !== content.joint) return;
    context.fillStyle = this.surface.colour("brush");
    context.fillRect(px(s.from), frame.top, Math.max(1, px(s.to) - px(s.from)), frame.bottom - frame.top);
  }

  // Samples that a box selected elsewhere, as ticks along the lower edge.
  marks(context, content, frame, px) {
    if (!content.chosen || view.selection.kind === "time") return;
    context.fillStyle = this.surface.colour("mark");
    const [from, to] = this.span(content);
    let drawn = -1;
    for (let k = Math.max(0, Math.floor(from / content.dt)); k < Math.min(content.count, Math.ceil(to / content.dt)); k++) {
      if (!content.chosen(k)) continue;
      const x = Math.round(px(k * content.dt));
      if (x !== drawn) context.fillRect(x, frame.bottom - 7, 1.5, 7);
      drawn = x;
    }
  }

  line(context, series, content, frame, px, py) {
    const { dt } = content;
    const [from, to] = this.span(content);
    const first = Math.max(0, Math.floor(from / dt) - 1), last = Math.min(content.count, Math.ceil(to / dt) + 2);
    const colour = this.surface.colour(series.colour);
    context.strokeStyle = colour;
    context.lineWidth = series.width || 1.4;
    context.lineJoin = "round";
    context.setLineDash(series.dash || []);
    if (series.band) {
      this.band(context, series, content, frame, py, colour);
      return;
    }
    const pixels = frame.right - frame.left;
    context.beginPath();
    let pen = false;
    if (last - first <= 2 * pixels) {
      for (let k = first; k < last; k++) {
        const v = series.values[k];
        if (!Number.isFinite(v)) pen = false;
        else {
          if (pen) context.lineTo(px(k * dt), py(v));
          else context.moveTo(px(k * dt), py(v));
          pen = true;
        }
      }
    } else {
      const tree = pyramid(series.values), perPixel = (to - from) / pixels / dt;
      for (let p = 0; p < pixels; p++) {
        const start = from / dt + p * perPixel;
        const [low, high] = tree.between(Math.floor(start), Math.max(Math.floor(start) + 1, Math.floor(start + perPixel)));
        if (!Number.isFinite(low)) {
          pen = false;
          continue;
        }
        if (pen) context.lineTo(frame.left + p, py(high));
        else context.moveTo(frame.left + p, py(high));
        context.lineTo(frame.left + p, py(low) + 0.5);
        pen = true;
      }
    }
    context.stroke();
    context.setLineDash([]);
  }

  // Between two series, column by column.
  band(context, series, content, frame, py, colour) {
    const [from, to] = this.span(content);
    const pixels = frame.right - frame.left, perPixel = (to - from) / pixels / content.dt;
    const low = pyramid(series.band), high = pyramid(series.values);
    context.globalAlpha = 0.28;
    context.fillStyle = colour;
    for (let p = 0; p < pixels; p++) {
      const start = Math.floor(from / content.dt + p * perPixel), end = Math.max(start + 1, Math.floor(start + perPixel));
      const a = low.between(start, end)[0], b = high.between(start, end)[1];
      if (Number.isFinite(a)) context.fillRect(frame.left + p, py(b), 1, Math.max(1, py(a) - py(b)));
    }
    context.globalAlpha = 1;
  }

  time(event) {
    const { frame, from, to } = this.x;
    const x = event.clientX - this.canvas.getBoundingClientRect().left;
    return from + ((x - frame.left) / (frame.right - frame.left)) * (to - from);
  }

  listen() {
    const { canvas } = this;
    let drag = null;
    canvas.addEventListener("pointerdown", (event) => {
      if (!this.x || event.button !== 0) return;
      canvas.setPointerCapture(event.pointerId);
      drag = { at: this.time(event), x: event.clientX, moved: false, moves: view.moving || event.shiftKey, range: [this.x.from, this.x.to] };
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!this.x) return;
      const { content, frame } = this.x;
      const longest = content.dt * Math.max(1, content.count - 1);
      look({ cursor: Math.min(longest, Math.max(0, this.time(event))) });
      if (!drag || (!drag.moved && Math.abs(event.clientX - drag.x) < 4)) return;
      drag.moved = true;
      if (drag.moves) {
        const [from, to] = drag.range;
        const shift = ((drag.x - event.clientX) / (frame.right - frame.left)) * (to - from);
        showRange(from + shift, to + shift, longest);
      } else this.select(drag.at, this.time(event));
    });
    const end = () => (drag = null);
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
    canvas.addEventListener("dblclick", () => look({ range: null }));
    canvas.addEventListener("wheel", (event) => {
      if (!this.x || !(event.ctrlKey || event.metaKey || event.shiftKey || document.activeElement === canvas || event.deltaX)) return;
      event.preventDefault();
      const { from, to, content } = this.x;
      const longest = content.dt * Math.max(1, content.count - 1);
      const sideways = event.shiftKey ? event.deltaY || event.deltaX : event.deltaX;
      if (sideways) showRange(from + (sideways / 500) * (to - from), to + (sideways / 500) * (to - from), longest);
      else zoom(this.time(event), Math.exp(event.deltaY / 300), from, to, longest);
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => this.key(event));
    for (const name of ["focus", "blur"]) canvas.addEventListener(name, () => this.draw());
  }

  select(a, b) {
    const { content } = this.x;
    const longest = content.dt * Math.max(1, content.count - 1);
    const inside = (t) => Math.min(longest, Math.max(0, t));
    const [from, to] = [inside(Math.min(a, b)), inside(Math.max(a, b))];
    look({ selection: { kind: "time", recording: content.recording, t0: content.t0, from, to, joint: null } });
  }

  key(event) {
    if (!this.x) return;
    const { from, to, content } = this.x;
    const longest = content.dt * Math.max(1, content.count - 1);
    const step = Math.max(content.dt, (to - from) / 100);
    const cursor = view.cursor === null ? from : view.cursor;
    const moves = { ArrowLeft: -step, ArrowRight: step };
    if (event.key in moves) {
      const next = Math.min(longest, Math.max(0, cursor + moves[event.key]));
      const start = view.selection && view.selection.kind === "time" && view.selection.recording === content.recording
        ? (Math.abs(view.selection.from - cursor) < Math.abs(view.selection.to - cursor) ? view.selection.to : view.selection.from) : cursor;
      look({ cursor: next });
      if (event.shiftKey) this.select(start, next);
    } else if (event.key === "+" || event.key === "=") zoom(cursor, 0.7, from, to, longest);
    else if (event.key === "-") zoom(cursor, 1.4, from, to, longest);
    else if (event.key === "PageUp") showRange(from - (to - from), from, longest);
    else if (event.key === "PageDown") showRange(to, to + (to - from), longest);
    else if (event.key === "Home" || event.key === "0") look({ range: null });
    else if (event.key === "Escape") look({ selection: null, explained: null });
    else return;
    event.preventDefault();
  }
}

export function zoom(at, factor, from, to, longest) {
  const width = Math.min(longest, Math.max(0.05, (to - from) * factor));
  const share = Math.min(1, Math.max(0, (at - from) / (to - from || 1)));
  showRange(at - share * width, at + (1 - share) * width, longest);
}

export function showRange(from, to, longest) {
  const width = Math.min(longest, to - from);
  const start = Math.min(longest - width, Math.max(0, from));
  look({ range: width >= longest ? null : [start, start + width] });
}
