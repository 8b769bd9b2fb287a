// The error of a joint against a variable, coloured by direction of motion or by recording; a box selects a cloud.

import { Surface, axes } from "./canvas.js";
import { look, view } from "../store.js";
import { selected } from "../selection.js";

const MOST = 30000;
const LEFT = 52, RIGHT = 10, TOP = 24, BOTTOM = 34;

export class Scatter {
  // `content()` returns {joint, variable, entry, unit, clouds: [{recording, motion, error, x, colourOf}]} or null.
  constructor(canvas, content) {
    this.canvas = canvas;
    this.content = content;
    this.surface = new Surface(canvas, (context, width, height) => this.paint(context, width, height), () => this.draw());
    canvas.tabIndex = 0;
    this.listen();
  }

  // All points are painted again only where they may have changed; a moved cursor is drawn over them.
  draw(fresh = true) {
    if (fresh) this.layer = null;
    this.surface.draw();
  }

  paint(context, width, height) {
    const content = this.content();
    if (!content) return false;
    if (!this.layer || this.layer.width !== this.canvas.width || this.layer.height !== this.canvas.height) {
      if (!this.points(context, width, height, content)) return false;
      this.layer = document.createElement("canvas");
      this.layer.width = this.canvas.width;
      this.layer.height = this.canvas.height;
      this.layer.getContext("2d").drawImage(this.canvas, 0, 0);
    } else context.drawImage(this.layer, 0, 0, width, height);
    const { frame, px, py } = this.x;
    this.cursor(context, content.clouds, content.joint, px, py);
    this.surface.focus(frame);
    return true;
  }

  points(context, width, height, content) {
    const { joint, clouds } = content;
    const total = clouds.reduce((sum, cloud) => sum + cloud.motion.head.count, 0);
    const step = Math.max(1, Math.ceil(total / MOST));
    let x = [Infinity, -Infinity], y = [Infinity, -Infinity];
    const each = (visit) => {
      for (const cloud of clouds) {
        const errors = cloud.error.arrays.error[joint], use = cloud.motion.arrays.use[joint];
        for (let k = 0; k < errors.length; k += step) if (use[k] && Number.isFinite(errors[k])) visit(cloud, k, cloud.x(k), errors[k]);
      }
    };
    each((_, __, a, b) => {
      x = [Math.min(x[0], a), Math.max(x[1], a)];
      y = [Math.min(y[0], b), Math.max(y[1], b)];
    });
    if (!(x[0] <= x[1])) return false;
    const wide = ([low, high]) => [low - 0.05 * (high - low || 1), high + 0.05 * (high - low || 1)];
    const frame = { left: LEFT, right: width - RIGHT, top: TOP, bottom: height - BOTTOM };
    const words = { x: `${content.entry.words} [${content.entry.unit}]`, y: `error [${content.unit}]` };
    [x, y] = [wide(x), wide(y)];
    const { px, py } = axes(this.surface, frame, x, y, words);
    this.x = { frame, x, y, px, py, content };
    const colours = content.colours.map((name) => this.surface.colour(name));
    const tests = new Map(clouds.map((cloud) => [cloud, selected(view.selection, cloud.recording, joint, cloud.motion, cloud.error)]));
    context.globalAlpha = 0.55;
    each((cloud, k, a, b) => {
      context.fillStyle = colours[cloud.colourOf(k)];
      context.fillRect(px(a) - 1, py(b) - 1, 2, 2);
    });
    context.globalAlpha = 1;
    context.fillStyle = this.surface.colour("mark");
    each((cloud, k, a, b) => {
      const test = tests.get(cloud);
      if (test && test(k)) context.fillRect(px(a) - 1.5, py(b) - 1.5, 3, 3);
    });
    this.box(context, px, py, joint, content.variable);
    return true;
  }

  box(context, px, py, joint, variable) {
    const s = view.selection;
    if (!s || s.kind !== "box" || s.joint !== joint || s.variable !== variable) return;
    context.strokeStyle = this.surface.colour("ink");
    context.setLineDash([4, 3]);
    context.strokeRect(px(s.x[0]), py(s.y[1]), px(s.x[1]) - px(s.x[0]), py(s.y[0]) - py(s.y[1]));
    context.setLineDash([]);
  }

  cursor(context, clouds, joint, px, py) {
    if (view.cursor === null) return;
    const cloud = clouds.find((one) => one.recording === view.recording);
    if (!cloud) return;
    const k = Math.round(view.cursor / cloud.motion.head.dt);
    const error = cloud.error.arrays.error[joint][k];
    if (!Number.isFinite(error)) return;
    context.strokeStyle = this.surface.colour("ink");
    context.lineWidth = 2;
    context.beginPath();
    context.arc(px(cloud.x(k)), py(error), 5, 0, 2 * Math.PI);
    context.stroke();
  }

  place(event) {
    const { frame, x, y } = this.x;
    const box = this.canvas.getBoundingClientRect();
    const share = (v, low, high) => Math.min(1, Math.max(0, (v - low) / (high - low)));
    return [
      x[0] + share(event.clientX - box.left, frame.left, frame.right) * (x[1] - x[0]),
      y[1] - share(event.clientY - box.top, frame.top, frame.bottom) * (y[1] - y[0]),
    ];
  }

  listen() {
    const { canvas } = this;
    let drag = null;
    canvas.addEventListener("pointerdown", (event) => {
      if (!this.x || event.button !== 0) return;
      canvas.setPointerCapture(event.pointerId);
      drag = { at: this.place(event), x: event.clientX, y: event.clientY };
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!drag || Math.abs(event.clientX - drag.x) + Math.abs(event.clientY - drag.y) < 5) return;
      const now = this.place(event);
      this.select([0, 1].map((i) => [Math.min(drag.at[i], now[i]), Math.max(drag.at[i], now[i])]));
    });
    const end = () => (drag = null);
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
    canvas.addEventListener("keydown", (event) => this.key(event));
    for (const name of ["focus", "blur"]) canvas.addEventListener(name, () => this.draw(false));
  }

  select([x, y]) {
    const { joint, variable } = this.x.content;
    look({ selection: { kind: "box", joint, variable, x, y } });
  }

  // Arrows move a box of a tenth of the plane, with Shift its upper right corner; Escape takes it away.
  key(event) {
    if (!this.x) return;
    if (event.key === "Escape") return look({ selection: null, explained: null });
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step) return;
    event.preventDefault();
    const { x, y, content } = this.x;
    const s = view.selection;
    const mine = s && s.kind === "box" && s.joint === content.joint && s.variable === content.variable;
    const at = (axis, low, high) => [axis[0] + low * (axis[1] - axis[0]), axis[0] + high * (axis[1] - axis[0])];
    const box = mine ? [s.x, s.y] : [at(x, 0.4, 0.6), at(y, 0.6, 0.95)];
    const moved = [x, y].map((axis, i) => {
      const shift = (step[i] * (axis[1] - axis[0])) / 20;
      return event.shiftKey ? [box[i][0], Math.max(box[i][0], box[i][1] + shift)] : [box[i][0] + shift, box[i][1] + shift];
    });
    this.select(mine ? moved : box);
  }
}
