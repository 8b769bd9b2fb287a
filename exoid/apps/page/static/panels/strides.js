// Torque, model and error over the stride, where the motion has strides: means, and bands of one standard deviation.

import { ask } from "../api.js";
import { h, refill } from "../dom.js";
import { Surface, axes } from "../plot/canvas.js";
import { view } from "../store.js";
import { doing } from "./status.js";

export const ABOVE = "against";
const LEFT = 52, RIGHT = 10, TOP = 22, BOTTOM = 34, BETWEEN = 30, UPPER = 0.6;

let strides = null; // what /api/strides answered last
let shownFor = "";
let surfaces = [];

export function draw() {
  const { key, fitted, recordings, filter } = view.state, now = JSON.stringify([key, recordings, filter]);
  if (!fitted || now === shownFor) return;
  shownFor = now;
  doing(ask("/api/strides", { key }).then((found) => {
    strides = found.strides;
    build();
  }));
}

function build() {
  const place = document.getElementById("strides");
  if (!strides) {
    surfaces = [];
    place.replaceChildren();
    return;
  }
  const { joints } = view.state;
  if (surfaces.length !== joints.length) {
    surfaces = [];
    place.replaceChildren(h("div", { id: "strides-said" }), h("div", { class: "scatters" }, joints.map((joint, j) => {
      const canvas = h("canvas", { class: "plot scatter", role: "img", "data-testid": `stride-${joint.name}`, "aria-label": `Torque and error of the ${joint.name} over the stride, with bands of one standard deviation` });
      surfaces.push(new Surface(canvas, (context, width, height) => paint(j, context, width, height), () => surfaces[j].draw()));
      return h("figure", { class: `joint-block joint-${j}` }, canvas);
    })));
  }
  refill(document.getElementById("strides-said"),
    h("h2", { id: "strides-title" }, "Over the stride"),
    h("p", { class: "faint", "data-testid": "strides-said" }, strides.sentence),
    h("p", { class: "faint" }, h("span", { class: "key-measured" }, "measured"), " · ", h("span", { class: "key-model" }, "model"), ` · below, the error; bands: one standard deviation from stride to stride${strides.stance === null ? "" : "; on the ground up to the broken line"}`));
  for (const one of surfaces) one.draw();
}

function paint(j, context, width, height) {
  if (!strides) return false;
  const surface = surfaces[j], joint = view.state.joints[j], middle = TOP + UPPER * (height - TOP - BOTTOM - BETWEEN);
  const x = strides.phase.map((one) => 100 * one), right = width - RIGHT;
  const both = [[strides.measured[j], strides.measured_band[j]], [strides.error[j], strides.error_band[j]]];
  const upper = axes(surface, { left: LEFT, right, top: TOP, bottom: middle }, [0, 100], range(...both[0], strides.model[j]), { y: `${joint.name} [${joint.unit}]` });
  const lower = axes(surface, { left: LEFT, right, top: middle + BETWEEN, bottom: height - BOTTOM }, [0, 100], range(...both[1], [0]), { x: "stride [%]", y: `error [${joint.unit}]` });
  band(context, x, ...both[0], upper, surface.colour("measured"));
  line(context, x, both[0][0], upper, surface.colour("measured"));
  line(context, x, strides.model[j], upper, surface.colour("model"));
  band(context, x, ...both[1], lower, surface.colour(`j${j % 6}`));
  line(context, [0, 100], [0, 0], lower, surface.colour("faint"), 1);
  line(context, x, both[1][0], lower, surface.colour(`j${j % 6}`));
  if (strides.stance !== null) {
    context.setLineDash([4, 4]);
    for (const { px, from, to } of [{ ...upper, from: TOP, to: middle }, { ...lower, from: middle + BETWEEN, to: height - BOTTOM }]) {
      const at = px(100 * strides.stance);
      stroke(context, [[at, from], [at, to]], surface.colour("faint"), 1);
    }
    context.setLineDash([]);
  }
  return true;
}

function range(mean, spread, more) {
  const all = [...mean.flatMap((value, k) => (value === null ? [] : [value - (spread[k] || 0), value + (spread[k] || 0)])), ...more.filter((one) => one !== null)];
  const low = Math.min(...all, 0), high = Math.max(...all, 0), pad = 0.05 * (high - low || 1);
  return [low - pad, high + pad];
}

// Stretches between what nobody measured, each drawn by itself.
function stretches(values) {
  const out = [];
  values.forEach((value, k) => {
    if (value === null) return;
    if (k > 0 && values[k - 1] !== null && out.length) out.at(-1).push(k);
    else out.push([k]);
  });
  return out;
}

function band(context, x, mean, spread, { px, py }, colour) {
  context.fillStyle = colour;
  context.globalAlpha = 0.22;
  for (const part of stretches(mean)) {
    context.beginPath();
    for (const k of part) context.lineTo(px(x[k]), py(mean[k] + (spread[k] || 0)));
    for (const k of [...part].reverse()) context.lineTo(px(x[k]), py(mean[k] - (spread[k] || 0)));
    context.fill();
  }
  context.globalAlpha = 1;
}

function line(context, x, values, { px, py }, colour, width = 1.5) {
  for (const part of stretches(values)) stroke(context, part.map((k) => [px(x[k]), py(values[k])]), colour, width);
}

function stroke(context, points, colour, width) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  context.stroke();
}
