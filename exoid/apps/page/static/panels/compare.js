// Measured and modelled torque and their difference: over time, against everything else, and the leg at the cursor.

import { ask, numbers } from "../api.js";
import { button, fill, h, refill, set, svg } from "../dom.js";
import { number } from "../format.js";
import { Scatter } from "../plot/scatter.js";
import { TimePlot, showRange, zoom } from "../plot/timeplot.js";
import { clear, inWords, selected, variable, variables } from "../selection.js";
import { error as errorOf, look, motion as motionOf, view } from "../store.js";
import { drawPosture } from "./posture.js";
import { doing } from "./status.js";

let plots = [];
let data = null;
let built = "";
let layers = { measured: true, model: true, after: true, band: true };
let other = null; // the error of one recording before effects were added, or after what Discover found by itself
let colouring = "direction";
const axisOf = new Map();
const clouds = new Map();
const memory = new WeakMap();

// Measured torque minus error, kept as long as the error is.
function modelled(motion, error, j) {
  if (!memory.has(error)) memory.set(error, []);
  const kept = memory.get(error);
  if (!kept[j]) kept[j] = Float32Array.from(motion.arrays.torque[j], (v, k) => v - error.arrays.error[j][k]);
  return kept[j];
}

// Errors are only drawn where they count.
function masked(values, motion, j) {
  if (!memory.has(values)) memory.set(values, Float32Array.from(values, (v, k) => (motion.arrays.use[j][k] ? v : NaN)));
  return memory.get(values);
}

export function draw() {
  drawSelection();
  doing(loadCompare());
}

export async function loadCompare() {
  const { state } = view;
  if (!state.ready) return;
  if (view.recording === null || view.recording >= state.recordings.length) {
    const held = state.recordings.findIndex((one) => one.role === "verify");
    return look({ recording: Math.max(0, held) });
  }
  build();
  const { recording } = view;
  document.getElementById("which").value = String(recording); // keys and links choose it too
  const [motion, error] = await Promise.all([motionOf(recording), errorOf(recording, state.key)]);
  if (recording !== view.recording) return;
  data = { recording, motion, error };
  redraw();
  await loadOther(recording);
  await Promise.all(state.recordings.map(async (_, k) => {
    const [m, e] = await Promise.all([motionOf(k), errorOf(k, state.key)]);
    clouds.set(k, { recording: k, motion: m, error: e });
  }));
  for (const k of clouds.keys()) if (k >= state.recordings.length) clouds.delete(k);
  redraw();
}

const added = () => view.state.layers.some((one) => one.on);
const otherWord = () => (added() ? "before" : "after");

async function loadOther(recording) {
  const { verdict } = view.state;
  const word = document.getElementById("word-after");
  word.textContent = otherWord();
  word.parentElement.className = `key-${otherWord()}`;
  const words = added() || (verdict.proposed && verdict.steps.length > 1) ? otherWord() : "";
  const key = `${recording}|${words}|${words === "after" ? verdict.headline : ""}`;
  if (!words) other = null;
  else if (!other || other.key !== key) {
    try {
      other = { ...(await numbers("/api/answer", { recording })), key, words };
    } catch {
      other = null;
    }
    redraw();
  }
}

// The other error as a curve: what comes after in the colour of what is good, what was before as a trace behind.
function drawn(values) {
  return other.words === "after" ? { values, colour: "after", width: 1.6, name: "after" } : { values, colour: "faint", width: 1.2, name: "before" };
}

// The plots over time as large as the screen.
function fullScreen() {
  const place = document.getElementById("compare");
  const corners = svg("svg", { viewBox: "0 0 12 12", class: "corners", "aria-hidden": "true" }, svg("path", { d: "M1 4V1h3M8 1h3v3M11 8v3H8M4 11H1V8" }));
  return button(corners, () => (document.fullscreenElement ? document.exitFullscreen() : place.requestFullscreen()), { title: "plots as large as the screen (m)", "aria-label": "full screen", id: "full-screen" });
}

// Any column of the file, drawn below the torques on the same time.
function further() {
  const choose = h("select", { id: "further-column", "data-testid": "further-column", "aria-label": "also draw a column of the file" }, h("option", { value: "" }, "also draw …"));
  const offer = async () => {
    const { file } = view.state.recordings[view.recording] || {};
    if (!file || choose.dataset.file === String(file)) return;
    choose.dataset.file = String(file);
    const table = await doing(ask("/api/columns", { file }));
    if (table) fill(choose, h("option", { value: "" }, "also draw …"), table.columns.map((one) => h("option", { value: one.name }, one.name)));
  };
  choose.addEventListener("focus", offer);
  choose.addEventListener("pointerenter", offer);
  choose.addEventListener("change", () => {
    if (choose.value) doing(drawColumn(choose.value));
    choose.value = "";
  });
  return choose;
}

async function drawColumn(name) {
  const asked = { recording: -1, values: null, unit: "" };
  const load = async () => {
    if (asked.recording === view.recording) return;
    asked.recording = view.recording;
    const found = await numbers("/api/column", { recording: asked.recording, column: name });
    Object.assign(asked, { values: found.arrays.values[0], unit: found.head.unit, head: found.head });
    plot.draw();
  };
  const canvas = h("canvas", { class: "plot short", role: "img", "data-testid": `column-${name}`, "aria-label": `Column ${name} of the file over time` });
  const plot = new TimePlot(canvas, () => {
    if (!data) return null;
    load().catch(() => (asked.values = null));
    if (!asked.values || asked.recording !== data.recording) return null;
    const { t0, dt, count } = data.motion.head;
    return { t0, dt, count, recording: data.recording, joint: null, series: [{ values: asked.values, colour: "ink", name: "" }], label: name, unit: asked.unit || "as in the file" };
  }, { axis: true });
  const block = h("div", { class: "joint-block" }, button("✕", () => {
    plots = plots.filter((one) => one !== plot);
    block.remove();
  }, { class: "icon", "aria-label": `no longer draw ${name}` }), canvas);
  document.getElementById("further").append(block);
  await load();
  plots.push(plot);
  plot.draw();
  block.scrollIntoView({ block: "nearest" });
  canvas.focus({ preventScroll: true }); // not the list: keys are for the page again
}

export function redraw(fresh = true) {
  for (const place of document.getElementById("suspects-curves").children) place.hidden = !view.preview;
  for (const plot of plots) plot.draw(fresh);
  readout();
}

function build() {
  const { joints, recordings } = view.state;
  const key = JSON.stringify([joints.map((one) => one.name), recordings]);
  if (key === built) return;
  built = key;
  plots = [];
  clouds.clear();
  data = other = null;
  document.body.style.setProperty("--joints", String(joints.length));
  fill(document.getElementById("compare"), head(recordings),
    joints.map((joint, j) => timePanels(joint, j)), h("div", { id: "further" }),
  );
  fill(document.getElementById("against"),
    h("div", { class: "row wrap scatter-head" }, h("h3", {}, "Error against"), colours()),
    h("div", { class: "scatters" }, joints.map((joint, j) => scatterPanel(joint, j))),
  );
  fill(document.getElementById("suspects-curves"), joints.map(curve));
}

function head(recordings) {
  const choose = h("select", { id: "which", onchange: (event) => look({ recording: Number(event.target.value), range: null, cursor: null }) },
    recordings.map((one, k) => h("option", { value: String(k) }, `${one.name} (${one.role === "verify" ? "unseen" : "fitted"})`)));
  choose.value = String(view.recording);
  const longest = () => (data ? data.motion.head.dt * Math.max(1, data.motion.head.count - 1) : 1);
  const span = () => view.range || [0, longest()];
  const by = (factor) => () => zoom((span()[0] + span()[1]) / 2, factor, ...span(), longest());
  const move = (share) => () => showRange(span()[0] + share * (span()[1] - span()[0]), span()[1] + share * (span()[1] - span()[0]), longest());
  const mode = h("button", { type: "button", "aria-pressed": String(Boolean(view.moving)), title: "what dragging does in plots over time" }, "pan");
  mode.addEventListener("click", () => {
    view.moving = !view.moving;
    set(mode, { "aria-pressed": String(view.moving) });
    document.body.classList.toggle("moving", view.moving);
  });
  return [
    h("h2", { id: "compare-title", class: "hidden" }, "Model against measurement"),
    h("div", { class: "row wrap compare-tools" },
      h("label", { for: "which", "aria-label": "recording" }, choose),
      h("div", { class: "group" }, button("−", by(1.5), { "aria-label": "zoom out" }), button("+", by(1 / 1.5), { "aria-label": "zoom in" }),
      button("◀", move(-0.5), { "aria-label": "earlier" }), button("▶", move(0.5), { "aria-label": "later" }),
      button("all", () => look({ range: null }), { title: "the whole recording (double click)" }), mode),
      ...Object.keys(layers).map((name) => toggle(name)), further(), fullScreen(),
    ),
    h("div", { class: "row under-tools" }, h("div", { class: "readout", id: "readout" }), h("div", { class: "row selection", id: "selection", "aria-live": "polite" })),
  ];
}

function toggle(name) {
  const words = { measured: "measured", model: "model", after: otherWord(), band: "placebos" };
  const box = h("input", { type: "checkbox", checked: layers[name], onchange: (event) => {
    layers = { ...layers, [name]: event.target.checked };
    redraw();
  } });
  return h("label", { class: `key-${name}` }, box, " ", h("span", { id: `word-${name}` }, words[name]));
}

function timePanels(joint, j) {
  const words = `${joint.name} over time. Arrows move the cursor, with Shift they select; plus and minus zoom, 0 shows everything, Escape clears the selection.`;
  const torque = h("canvas", { class: "plot", role: "img", "data-testid": `plot-torque-${joint.name}`, "aria-label": `Measured and modelled torque of the ${words}` });
  const error = h("canvas", { class: "plot short error", role: "img", "data-testid": `plot-error-${joint.name}`, "aria-label": `Difference of measured and modelled torque of the ${words}` });
  plots.push(new TimePlot(torque, () => torqueContent(joint, j), { axis: false }), new TimePlot(error, () => errorContent(joint, j), { axis: j === view.state.joints.length - 1 }));
  return h("div", { class: `joint-block joint-${j}` }, torque, error);
}

// The error once more beside the suspects, for screens on which the plots are far away.
function curve(joint, j) {
  const canvas = h("canvas", { class: "plot short", role: "img", "aria-label": `Error of the ${joint.name} now, and as it would become with the suspect pointed at` });
  plots.push(new TimePlot(canvas, () => view.preview && errorContent(joint, j), { axis: true }));
  return h("div", { class: `joint-${j}`, hidden: true }, h("strong", { class: "joint-text" }, joint.name), canvas);
}

function content(joint, j, series, label) {
  const { motion, error, recording } = data;
  const { t0, dt, count } = motion.head;
  return { t0, dt, count, recording, joint: j, series, label, unit: joint.unit, chosen: selected(view.selection, recording, j, motion, error) };
}

const found = () => other !== null && data !== null && other.head.recording === data.recording;

function torqueContent(joint, j) {
  if (!data) return null;
  const { motion, error } = data;
  const series = [];
  if (layers.measured) series.push({ values: motion.arrays.torque[j], colour: "measured", width: 2.4, name: "measured" });
  if (layers.model) series.push({ values: modelled(motion, error, j), colour: "model", width: 1.3, name: "model" });
  if (layers.after && found() && other.words === "after") series.push({ ...drawn(modelled(motion, other, j)), width: 1.3 });
  return content(joint, j, series, `${joint.name}: torque`);
}

function errorContent(joint, j) {
  if (!data) return null;
  const { motion, error, recording } = data;
  const series = [{ values: masked(error.arrays.error[j], motion, j), colour: "model", name: "model" }];
  const { preview } = view;
  if (!preview && layers.after && found()) series[other.words === "after" ? "push" : "unshift"](drawn(masked(other.arrays.error[j], motion, j)));
  if (preview && preview.head.recording === recording) {
    const { arrays } = preview;
    if (layers.band) series.unshift({ values: masked(arrays.high[j], motion, j), band: masked(arrays.low[j], motion, j), colour: "faint", scales: false });
    series.push({ values: masked(arrays.error[j], motion, j), colour: "ink", width: 1.8, name: "with it" });
  }
  return { ...content(joint, j, series, `${joint.name}: ${preview ? "error now, and with it" : found() ? "error before and after" : "error"}`), zero: true };
}

function colours() {
  const choose = h("select", { id: "colouring", onchange: (event) => {
    colouring = event.target.value;
    redraw();
    legend();
  } }, h("option", { value: "direction" }, "direction of motion"), h("option", { value: "recording" }, "recording"));
  choose.value = colouring;
  return h("label", { for: "colouring" }, "coloured by ", choose, h("span", { id: "legend", class: "faint" }));
}

const FORWARDS = 4; // not the colours of model, after and joints
const CLOUD_COLOURS = ["cloud-0", "cloud-1", "cloud-2", "cloud-3", "cloud-4", "cloud-5"];

function legend() {
  const place = document.getElementById("legend");
  if (!place) return;
  const words = colouring === "direction" ? ["forwards", "backwards"] : view.state.recordings.map((one) => one.name);
  const from = colouring === "direction" ? FORWARDS : 0;
  fill(place, words.map((text, k) => h("span", { class: "key-entry" }, h("span", { class: `dot ${CLOUD_COLOURS[(from + k) % CLOUD_COLOURS.length]}` }), ` ${text} `)));
}

function scatterPanel(joint, j) {
  const entries = variables(view.state.joints);
  if (!axisOf.has(joint.name)) axisOf.set(joint.name, `velocity:${joint.name}`);
  const canvas = h("canvas", { class: "plot scatter", role: "img", "data-testid": `scatter-${joint.name}`,
    "aria-label": `Error of the ${joint.name} against a variable. Arrows move a box that selects points, with Shift they size it; Escape takes it away.` });
  const plot = new Scatter(canvas, () => scatterContent(joint, j, entries));
  const id = `against-${joint.name}`;
  const choose = h("select", { id, onchange: (event) => {
    axisOf.set(joint.name, event.target.value);
    plot.draw();
  } }, entries.map((one) => h("option", { value: one.name }, one.words)));
  choose.value = axisOf.get(joint.name);
  plots.push(plot);
  queueMicrotask(legend);
  return h("div", { class: `joint-block joint-${j}` }, h("label", { for: id }, h("strong", {}, joint.name), " against ", choose), canvas);
}

function scatterContent(joint, j, entries) {
  if (!clouds.size) return null;
  const name = axisOf.get(joint.name);
  const list = [...clouds.values()].sort((a, b) => a.recording - b.recording);
  const colourOf = colouring === "direction"
    ? (cloud) => (k) => (cloud.motion.arrays.velocity[j][k] >= 0 ? FORWARDS : FORWARDS + 1)
    : (cloud) => () => cloud.recording % CLOUD_COLOURS.length;
  return {
    joint: j, variable: name, unit: joint.unit, entry: entries.find((one) => one.name === name), colours: CLOUD_COLOURS,
    clouds: list.map((cloud) => ({ ...cloud, x: variable(name, j, cloud.motion), colourOf: colourOf(cloud) })),
  };
}

function readout() {
  const place = document.getElementById("readout");
  if (!place || !data) return;
  const { motion, error } = data;
  const k = view.cursor === null ? 0 : Math.min(motion.head.count - 1, Math.max(0, Math.round(view.cursor / motion.head.dt)));
  fill(place, h("output", {}, `t = ${(k * motion.head.dt).toFixed(2)} s`),
    view.state.joints.map((joint, j) => h("output", { class: "hidden" },
      `${joint.name}: measured ${number(motion.arrays.torque[j][k])}, difference ${number(error.arrays.error[j][k])} ${joint.unit}`)));
  drawPosture(document.getElementById("posture"), motion, k);
}

export function drawSelection() {
  const place = document.getElementById("selection");
  if (!place) return;
  refill(place, !view.selection ? h("span", { class: "faint" }, "drag over a plot to select a stretch")
    : [h("span", { "data-testid": "selection" }, `selected: ${inWords(view.selection)}`), button("clear", clear, { "data-testid": "clear-selection" })]);
}
