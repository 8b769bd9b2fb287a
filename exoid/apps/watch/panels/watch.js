// A recording played through a watch: one number over time with its interval, and what changed, on the same axis.

import { ask, tell } from "../api.js";
import { button, h, refill } from "../dom.js";
import { seconds } from "../format.js";
import { Surface, axes } from "../plot/canvas.js";
import { on, view } from "../store.js";
import { doing } from "./status.js";

const LEFT = 52, RIGHT = 10, TOP = 24, BOTTOM = 34;
const SHOWN = ["change", "unexplained", "motion", "waiting", "reference", "summary"];

let data = null; // what /api/watch answered last
let shownFor = "";
let chosen = "";
let surface = null;

export const ABOVE = "stance";
on("recording", () => view.state.ready && draw());

export function draw() {
  const place = document.getElementById("watch"), { tasks: { watch }, recordings } = view.state;
  if (!place.firstChild) {
    place.append(h("div", { id: "watch-head" }), h("canvas", { class: "plot watch-plot", role: "img", "data-testid": "watch-plot", hidden: true }), h("div", { id: "watch-said", "aria-live": "polite" }));
    surface = new Surface(place.querySelector("canvas"), paint, () => surface.draw());
  }
  if (!watch) data = null;
  const name = recordings[view.recording ?? 0]?.name;
  const names = data && data.numbers ? Object.keys(data.numbers) : [];
  if (!names.includes(chosen)) chosen = names[0] || "";
  const choose = names.length > 0 && h("label", { for: "watch-number" }, "number ", h("select", { id: "watch-number", "data-testid": "watch-number", onchange: (event) => {
    chosen = event.target.value;
    surface.draw();
  } }, names.map((one) => h("option", { value: one, selected: one === chosen }, one))));
  refill(document.getElementById("watch-head"),
    h("h2", { id: "watch-title" }, "While it runs"),
    h("p", { class: "faint" }, "Plays the recording as if it came now: the model’s numbers with their intervals, and what changed meanwhile."),
    h("div", { class: "row wrap" },
      button(`Play ${name || "the recording"}`, () => doing(tell("play", { recording: view.recording ?? 0 })), { "data-testid": "watch-play", disabled: Boolean(watch && watch.running) }),
      watch && watch.running && h("progress", { max: "1", value: String(watch.fraction), "aria-label": "played so far" }), choose),
  );
  refill(document.getElementById("watch-said"), watch && watch.error ? h("div", { class: "finding refused" }, h("p", {}, watch.error.what), h("p", { class: "remedy" }, watch.error.remedy)) : data && h("ul", { class: "watch-events", "data-testid": "watch-events" },
    (data.events || []).filter((one) => SHOWN.includes(one.event)).map((one) => h("li", { class: one.event, "data-event": one.event }, h("strong", {}, `${one.t.toFixed(0)} s `), one.sentence))));
  const canvas = place.querySelector("canvas");
  canvas.hidden = !(data && names.length > 0 && data.t.length > 0);
  canvas.setAttribute("aria-label", data ? `${chosen} over ${seconds(data.to - data.from)} of ${recordings[data.recording]?.name || "the recording"}; what changed is in the list below` : "");
  surface.draw();
  const key = watch ? JSON.stringify([watch.recording, watch.blocks, watch.running]) : "";
  if (key === shownFor) return;
  shownFor = key;
  if (watch) doing(ask("/api/watch").then((found) => {
    data = found;
    draw();
  }));
}

function paint(context, width, height) {
  if (!data || !data.numbers || !data.numbers[chosen] || !data.t.length) return false;
  const { value, low, high, unit } = data.numbers[chosen], { t } = data;
  const frame = { left: LEFT, right: width - RIGHT, top: TOP, bottom: height - BOTTOM };
  const all = [...value, ...low, ...high].filter((x) => x !== null);
  const bottom = Math.min(...all), top = Math.max(...all), pad = 0.06 * (top - bottom || 1);
  const { px, py } = axes(surface, frame, [data.from, data.to], [bottom - pad, top + pad], { x: "time [s]", y: unit === "1" ? chosen : `${chosen} [${unit}]` });
  for (const one of data.events || []) {
    if (one.event !== "change" && one.event !== "unexplained") continue;
    if (one.since) {
      context.fillStyle = surface.colour("brush");
      context.fillRect(px(Math.max(one.since.low, data.from)), frame.top, Math.max(2, px(one.since.high) - px(Math.max(one.since.low, data.from))), frame.bottom - frame.top);
    }
    line(context, [[px(one.t), frame.top], [px(one.t), frame.bottom]], surface.colour("bad"), [4, 4]);
  }
  const known = t.map((_, k) => k).filter((k) => low[k] !== null && high[k] !== null);
  context.fillStyle = surface.colour("model");
  context.globalAlpha = 0.2;
  context.beginPath();
  for (const k of known) context.lineTo(px(t[k]), py(high[k]));
  for (const k of known.reverse()) context.lineTo(px(t[k]), py(low[k]));
  context.fill();
  context.globalAlpha = 1;
  line(context, t.map((at, k) => [px(at), py(value[k])]), surface.colour("model"), []);
  return true;
}

function line(context, points, colour, dash) {
  context.strokeStyle = colour;
  context.lineWidth = 1.5;
  context.setLineDash(dash);
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  context.stroke();
  context.setLineDash([]);
}
