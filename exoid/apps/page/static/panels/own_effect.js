// The user's own effect: typed in the language of the catalogue, refused with a caret under what is wrong.

import { tell } from "../api.js";
import { button, fill, h } from "../dom.js";
import { view } from "../store.js";

const WORDS = /[A-Za-z_][A-Za-z0-9_]*/g;
const MOTION = /^(d{0,2}theta|tau_rigid|tau_model)(\d{1,2}|_next)?$|^tau\d_by_/;

export function openOwnEffect() {
  const { joints } = view.state;
  const error = h("div", { class: "caret", "data-testid": "own-error", role: "alert" });
  const id = field("own-id", "name", "text", { value: "my_effect" });
  const torque = field("own-torque", "torque", "text", { value: "c * dtheta * abs(dtheta)", spellcheck: "false", autocomplete: "off" });
  const joint = h("select", { id: "own-joint", "data-testid": "own-joint" }, h("option", { value: "" }, "each joint"), joints.map((one) => h("option", { value: one.name }, one.name)));
  const rows = h("div", { class: "numbers" });
  const kept = new Map();
  const names = () => [...new Set(torque.input.value.replace(/\[[^\]]*\]/g, "").match(WORDS) || [])].filter((word) => !MOTION.test(word) && !view.state.words.includes(word));
  const draw = () => fill(rows, names().map((name) => numberRow(name, kept)));
  torque.input.addEventListener("input", draw);
  draw();
  const dialog = h("dialog", { class: "form", "data-testid": "own-dialog", "aria-labelledby": "own-title", onclose: () => dialog.remove() },
    h("h2", { id: "own-title" }, "Your own effect"),
    h("p", { class: "faint" }, "A torque that the drive has to supply, of theta, dtheta, ddtheta (this joint's; theta1, dtheta2, … of a certain one), t, tau_rigid. Nothing that is typed is ever run."),
    id.row, h("label", { for: "own-joint" }, "at ", joint), torque.row, error,
    h("h3", {}, "Its numbers"), rows,
    h("div", { class: "row" }, button("Add it to the suspects", send, { class: "primary", "data-testid": "own-add" }), button("Cancel", () => dialog.close())),
  );
  async function send() {
    const entry = { id: id.input.value.trim(), torque: torque.input.value, coefficients: {}, shape: {} };
    if (joint.value) entry.joint = joint.value;
    for (const name of names()) {
      const { kind, unit, min, max } = kept.get(name);
      const limits = Object.fromEntries([["min", min], ["max", max]].filter(([, value]) => value !== "").map(([key, value]) => [key, Number(value)]));
      entry[kind === "shape" ? "shape" : "coefficients"][name] = { ...(unit ? { unit } : {}), ...limits };
    }
    try {
      await tell("effect", { effect: entry });
      dialog.close();
    } catch (problem) {
      fill(error, problem.where && h("pre", { tabindex: "0" }, problem.where), h("p", {}, problem.what), problem.remedy && h("p", {}, `what to do: ${problem.remedy}`));
    }
  }
  document.body.append(dialog);
  dialog.showModal();
}

function field(id, words, type, attributes) {
  const input = h("input", { id, type, "data-testid": id, ...attributes });
  return { input, row: h("label", { class: "wide", for: id }, `${words} `, input) };
}

function numberRow(name, kept) {
  if (!kept.has(name)) kept.set(name, { kind: "coefficient", unit: "", min: "", max: "" });
  const now = kept.get(name);
  const input = (key, words, size) => h("input", { type: "text", size, value: now[key], "aria-label": `${words} of ${name}`, placeholder: words,
    "data-testid": `own-${key}-${name}`, id: `own-${key}-${name}`, oninput: (event) => (now[key] = event.target.value.trim()) });
  const kind = h("select", { "aria-label": `what ${name} is`, "data-testid": `own-kind-${name}`, onchange: (event) => (now.kind = event.target.value) },
    h("option", { value: "coefficient" }, "factor of the torque"), h("option", { value: "shape" }, "shape, between bounds"));
  kind.value = now.kind;
  return h("div", { class: "row wrap" }, h("code", {}, name), kind, input("unit", "unit", 10), input("min", "at least", 7), input("max", "at most", 7));
}
