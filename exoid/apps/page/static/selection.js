// The one brush: a stretch of time, or a box in the plane of a variable and an error; where it lies everywhere.

import { tell } from "./api.js";
import { look, on, view } from "./store.js";

// A function of the sample's number that says whether it is selected, for joint j of a recording.
export function selected(selection, recording, j, motion, error) {
  if (!selection) return null;
  const { dt } = motion.head;
  if (selection.kind === "time") {
    if (selection.recording !== recording || (selection.joint !== null && selection.joint !== j)) return null;
    return (k) => k * dt >= selection.from && k * dt <= selection.to;
  }
  if (selection.joint !== j) return null;
  const xs = variable(selection.variable, j, motion), ys = error.arrays.error[j];
  const [x, y] = [selection.x, selection.y];
  return (k) => xs(k) >= x[0] && xs(k) <= x[1] && ys[k] >= y[0] && ys[k] <= y[1];
}

// A function of the sample's number: the value of a variable such as "angle:knee", "load" or "time".
export function variable(name, j, motion) {
  if (name === "time") return (k) => k * motion.head.dt;
  if (name === "load") return (k) => motion.arrays.load[j][k];
  const [kind, joint] = name.split(":");
  const of = view.state.joints.findIndex((one) => one.name === joint);
  const values = motion.arrays[kind][of];
  return (k) => values[k];
}

export function variables(joints) {
  const unit = (joint, power) => (joint.kind === "revolute" ? "rad" : "m") + ["", "/s", "/s²"][power];
  const kinds = ["angle", "velocity", "acceleration"];
  return [
    ...kinds.flatMap((kind, power) => joints.map((joint) => ({
      name: `${kind}:${joint.name}`, words: `${joint.name} ${joint.kind === "revolute" || power ? kind : "position"}`, unit: unit(joint, power),
    }))),
    { name: "load", words: "rigid-body load of the joint", unit: "N·m" },
    { name: "time", words: "time in the recording", unit: "s" },
  ];
}

export function inWords(selection) {
  const joints = view.state.joints;
  if (selection.kind === "time") {
    const name = view.state.recordings[selection.recording].name;
    return `${selection.from.toFixed(2)} to ${selection.to.toFixed(2)} s of ${name}`;
  }
  const entry = variables(joints).find((one) => one.name === selection.variable);
  return `${joints[selection.joint].name}: ${entry.words} ${selection.x.map((v) => v.toFixed(2)).join(" to ")} ${entry.unit}, error ${selection.y.map((v) => v.toFixed(2)).join(" to ")} ${joints[selection.joint].unit}`;
}

export function clear() {
  look({ selection: null, explained: null });
}

let asked = null;
let timer = 0;

// Asks which suspects explain the selection; an answer to an older question is dropped.
async function explain() {
  const { selection } = view;
  if (asked) asked.abort();
  if (!selection) return;
  asked = new AbortController();
  const message = { joint: selection.joint };
  if (selection.kind === "time") {
    const t0 = selection.t0;
    message.spans = [[selection.recording, t0 + selection.from, t0 + selection.to]];
  } else message.box = { variable: selection.variable, x: selection.x, y: selection.y };
  try {
    const { explained } = await tell("brush", message, asked.signal);
    if (view.selection === selection) look({ explained });
  } catch (error) {
    if (error.name !== "AbortError") look({ explained: {} });
  }
}

export function followSelection() {
  const soon = () => {
    clearTimeout(timer);
    timer = setTimeout(explain, 60);
  };
  on("selection", soon);
  on("state", () => view.selection && soon());
}
