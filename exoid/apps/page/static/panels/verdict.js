// What can be said now: verdict, error and noise of every joint, the falling error, and the whole search.

import { tell } from "../api.js";
import { button, h, refill, svg } from "../dom.js";
import { percent, rms } from "../format.js";
import { keep } from "../layout.js";
import { view } from "../store.js";
import { inPage } from "./mapping.js";
import { doing } from "./status.js";
import { sure, titleOf } from "./suspects.js";

const NAMES = {
  adequate: "nothing missing", missing: "found", ambiguous: "found, with look-alikes", unexplained: "not explained",
  check_channels: "check the channels", open: "not judged yet", unknown: "…",
};

// Before there is a session: what goes on, or what is missing.
export function drawWaiting() {
  const { busy, files, problem } = view.state;
  const unread = files.filter((file) => file.error).length;
  refill(document.getElementById("verdict"),
    h("h2", { id: "verdict-title", class: "hidden" }, "Verdict"),
    busy ? [h("p", { class: "lead" }, `${busy} …`), h("progress", { "aria-label": busy })]
      : problem ? h("p", { class: "lead" }, "These recordings cannot be fitted as they are; the reason stands above.")
      : [h("p", { class: "lead" }, "Nothing to fit yet."), h("p", {}, unread ? "Say which column is what (columns …), or add another recording." : "Mark at least one recording as fitted, or add one.")]);
}

export function draw() {
  const { state } = view;
  const { verdict, joints, search } = state;
  const rows = [
    h("h2", { id: "verdict-title", class: "hidden" }, "Verdict"),
    h("div", { "data-testid": "verdict", "data-verdict": verdict.kind },
      h("p", { class: "lead" }, h("span", { class: `verdict ${verdict.kind}` }, NAMES[verdict.kind] || verdict.kind), " ",
        verdict.headline ? withFigures(verdict.headline.replace(/^(Found: |Nothing is missing |Check the channels: )/, "").replace(/; (very sure|fairly sure|cannot tell)( which [^;]*)?/, "")) : verdict.sentence),
      h("div", { class: "said" }, verdict.sureness && sure(verdict.sureness),
      (verdict.why || verdict.next) && h("details", {}, h("summary", {}, verdict.judged ? "why, and what to measure next" : "what comes next"),
        verdict.headline && h("p", { class: "faint" }, verdict.sentence),
        verdict.next && h("p", { class: "faint" }, verdict.judged ? `measure next: ${inPage(verdict.next)}` : verdict.next),
        verdict.why && h("p", { class: "faint" }, verdict.why),
        (verdict.stability || []).map((text) => h("p", { class: "faint" }, text)),
        (verdict.possible || []).map((text) => h("p", { class: "faint" }, `possible: ${text}`)))),
    ),
    discover(search),
    h("div", { class: "tiles" }, joints.map(tile)),
  ];
  refill(document.getElementById("verdict"), rows);
  refill(document.getElementById("history"), staircase());
  refill(document.getElementById("notes"), h("h2", { id: "notes-title" }, "Notes"),
    state.audit.length === 0 ? h("p", { class: "faint" }, "Nothing to note about the recordings.") : h("ul", { class: "notes" }, state.audit.map((text) => h("li", {}, text))),
    state.forces.length > 0 && [h("h3", {}, "Measured forces"), h("ul", { class: "notes", "data-testid": "forces" }, state.forces.map((text) => h("li", {}, text)))],
    h("p", { class: "faint" }, `filter: ${state.filter}`));
}

// A headline with what stands in brackets, its numbers, drawn lighter.
function withFigures(text) {
  const parts = [""];
  let depth = 0;
  for (const letter of text) {
    if (letter === "(" && depth++ === 0) parts.push("");
    parts[parts.length - 1] += letter;
    if (letter === ")" && --depth === 0) parts.push("");
  }
  return parts.map((part) => (part.startsWith("(") ? h("span", { class: "figures" }, part) : part));
}

function automatic(on) {
  keep({ auto: on });
  doing(tell("auto", { on }));
}

// Share of the torque that the model explains: 1 − RMS of the error / RMS of the torque.
const fit = (error, signal) => `${(100 * (1 - error / signal)).toFixed(1).replace("-", "−")} %`;

function tile(joint, j) {
  const { judged, fitted } = view.state;
  return h("div", { class: `tile joint-${j}`, title: `RMS error on ${judged} motion${fitted ? "" : ", foreseen"}, of a torque of ${rms(joint.signal)} ${joint.unit}; fit: 1 − error / torque` },
    h("span", { class: "tile-head" }, joint.name),
    h("span", { class: "tile-number", "data-testid": `error-${joint.name}` }, `${rms(joint.error)} ${joint.unit}`),
    joint.after !== null && joint.after !== undefined && h("span", { class: "tile-number after", "data-testid": `after-${joint.name}` }, `→ ${rms(joint.after)}`),
    joint.signal > 0 && h("span", { class: "faint", "data-testid": `fit-${joint.name}` }, `fit ${fit(joint.error, joint.signal)}${joint.after ? ` → ${fit(joint.after, joint.signal)}` : ""},`),
    h("span", { class: "faint" }, `${judged}, noise `, h("span", { "data-testid": `noise-${joint.name}` }, `${rms(joint.noise)} ${joint.unit}`)),
  );
}

// The falling error: one column per step of the history; a click goes back to it.
function staircase() {
  const { history, joints, search } = view.state;
  const found = search.running ? search.steps.slice(1).map((step) => ({ ...step, coming: true })) : [];
  const { verdict } = view.state; // what was found by itself is foreseen as long as nothing was added
  if (verdict.proposed && history.steps.length === 1 && !search.running) found.push(...verdict.steps.slice(1).map((step) => ({ ...step, rms: [...step.rms], coming: true })));
  const steps = [...history.steps, ...found];
  const most = Math.max(...steps.flatMap((step) => step.rms || []), ...joints.map((joint) => joint.noise), 1e-9);
  return h("div", { class: "staircase-block" },
    h("div", { class: "row wrap" },
      h("h3", { id: "history-title" }, "The error falling"),
      h("span", { class: "faint keys" }, joints.map((joint, j) => h("span", { class: "key-entry" }, h("span", { class: `dot joint-${j}` }), ` ${joint.name}`)), h("span", { class: "key-entry" }, h("span", { class: "noise-key" }), " noise")),
      button("↶", () => doing(tell("undo")), { class: "icon", "data-testid": "undo", disabled: !history.undo, title: "undo (Ctrl+Z)", "aria-label": "undo" }),
      button("↷", () => doing(tell("redo")), { class: "icon", "data-testid": "redo", disabled: !history.redo, title: "redo (Ctrl+Shift+Z)", "aria-label": "redo" }),
    ),
    h("ol", { class: "staircase scroll", "data-testid": "staircase", tabindex: "0", "aria-label": "steps of the model" },
      steps.map((step, place) => h("li", {}, stepButton(step, place, most, history.at))),
    ),
  );
}

function stepButton(step, place, most, at) {
  const { joints } = view.state;
  const texts = joints.map((joint, j) => `${joint.name} ${step.rms ? rms(step.rms[j]) : "not fitted yet"}`);
  const label = `${step.label}: ${texts.join(", ")}${step.provisional ? ", foreseen" : ""}`;
  const open = step.coming ? null : () => doing(tell("go", { at: place }));
  return h("button", {
    type: "button", class: `step-button${place === at && !step.coming ? " now" : ""}${place > at ? " later" : ""}`,
    title: label, "aria-current": place === at && !step.coming ? "step" : null,
    disabled: Boolean(step.coming), onclick: open || (() => {}), "data-testid": `step-${place}`,
  }, bars(step, most), h("span", { class: "step-text" }, h("span", { class: "step-label" }, called(step.label)), h("span", { class: "hidden" }, step.label), h("span", { class: "step-numbers" }, step.rms ? step.rms.map(rms).join(" / ") : "…")));
}

// "+ stribeck:hip" in the words of the catalogue.
function called(label) {
  const name = label.replace(/^\+ /, "");
  const title = view.state.layers.find((one) => one.name === name)?.title || titleOf(name);
  return title === name ? label : `+ ${title}`;
}

function bars(step, most) {
  const { joints } = view.state;
  const width = 18, gap = 6, height = 56;
  const picture = svg("svg", { viewBox: `0 0 ${joints.length * (width + gap)} ${height}`, class: "bars", "aria-hidden": "true" });
  joints.forEach((joint, j) => {
    const x = j * (width + gap) + gap / 2, size = step.rms ? (step.rms[j] / most) * (height - 4) : 0;
    const floor = height - (joint.noise / most) * (height - 4);
    picture.append(svg("rect", { x, y: height - size, width, height: size, class: `bar joint-${j}${step.provisional || step.coming ? " foreseen" : ""}` }));
    picture.append(svg("line", { x1: x - 2, x2: x + width + 2, y1: floor, y2: floor, class: "floor-line" }));
  });
  return picture;
}

// The convention that the torques speak for, with its file where it is that one's alone.
function otherReading(remedy) {
  const text = /--convention (\S+)/.exec(remedy || "")?.[1].replace(/[.,;]$/, "");
  if (!text) return null;
  const file = view.state.files.find((one) => text.startsWith(`${one.name}=`));
  return file ? { file: file.name, convention: text.slice(file.name.length + 1) } : { convention: text };
}

function discover(search) {
  const { auto, verdict } = view.state;
  if (!search.running) {
    const other = verdict.kind === "check_channels" ? otherReading(verdict.next) : null;
    const words = verdict.proposed && verdict.accepted.length ? "Add what was found" : "Discover";
    return h("div", { class: "row wrap discover" },
      other && button(`Read ${other.file || "all files"} as ${other.convention}`, () => doing(tell("read_as", other)), { "data-testid": "read-as", class: "primary" }),
      button(words, () => doing(tell("discover")), { "data-testid": "discover", class: other || (verdict.judged && words === "Discover") ? "" : "primary", title: "searches the whole catalogue, adds what is missing, and judges it (d)" }),
      auto.running && h("span", { class: "faint", "data-testid": "judging" }, h("progress", { "aria-label": "judging" }), " judging …"),
      search.message && h("span", { class: "faint" }, search.message),
      h("label", { class: "auto" }, h("input", { type: "checkbox", checked: auto.on, "data-testid": "auto", onchange: (event) => automatic(event.target.checked) }), " auto-run"),
    );
  }
  const bar = h("progress", { max: "1", value: search.fraction, "data-testid": "progress", "aria-label": "progress of the search" });
  return h("div", { class: "row wrap running" },
    bar, h("span", { class: "faint" }, `${percent(search.fraction)} ${search.text}`),
    button("Cancel", () => doing(tell("cancel")), { "data-testid": "cancel" }),
  );
}
