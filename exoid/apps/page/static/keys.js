// The keyboard: what can be done without a mouse, and the list of it.

import { tell } from "./api.js";
import { button, h } from "./dom.js";
import { foldSide } from "./layout.js";
import { doing } from "./panels/status.js";
import { point } from "./panels/suspects.js";
import { look, view } from "./store.js";

const KEYS = [
  ["d", "Discover, or add what it found", () => press("discover")],
  ["a", "add the suspect pointed at", () => view.pointed && doing(tell("add", { effect: view.pointed }))],
  ["j", "point at the next suspect", () => step(1)],
  ["k", "point at the one before", () => step(-1)],
  ["[", "the recording before", () => recording(-1)],
  ["]", "the next recording", () => recording(1)],
  ["f", "fold the side bar, or unfold it", () => foldSide(!document.body.classList.contains("no-side"))],
  ["m", "plots as large as the screen", () => document.getElementById("full-screen")?.click()],
  ["?", "what to do", showKeys],
];
const OTHERS = [
  ["Ctrl+K or ?", "this list"], ["Ctrl+Z, Ctrl+Shift+Z", "undo, redo"], ["in a plot: ← →", "the cursor; with Shift a selection"],
  ["in a plot: + − 0", "zoom in, out, everything"], ["Escape", "clear the selection"], ["Tab", "every control, in order; the edges of panes move with the arrows"],
];

const MOST = 12; // entries found at once

export function listenToKeys() {
  document.addEventListener("keydown", keys);
  document.getElementById("show-keys").addEventListener("click", showKeys);
}

function keys(event) {
  const typing = event.target.matches("input:not([type=checkbox]), textarea, select");
  if (typing || document.querySelector("dialog[open]")) return;
  if (event.ctrlKey || event.metaKey) {
    const key = event.key.toLowerCase();
    if (key !== "z" && key !== "k") return;
    event.preventDefault();
    if (key === "k") return showKeys();
    doing(tell(event.shiftKey ? "redo" : "undo"));
    return;
  }
  if (event.altKey || !view.state?.ready) return;
  const found = KEYS.find(([key]) => key === event.key);
  if (!found) return;
  event.preventDefault();
  found[2]();
}

const press = (testid) => document.querySelector(`[data-testid="${testid}"]`)?.click();

function step(by) {
  const names = (view.state.ranking?.suspects || []).map((one) => one.name);
  if (!names.length) return;
  const next = names[Math.min(names.length - 1, Math.max(0, names.indexOf(view.pointed) + by))];
  reach(next);
}

function reach(name) {
  point(name).then(() => document.querySelector(`[data-testid="suspect-${CSS.escape(name)}"]`)?.scrollIntoView({ block: "nearest" }));
}

function recording(by) {
  const count = view.state.recordings.length;
  look({ recording: (view.recording + by + count) % count, range: null, cursor: null });
}

// Everything that can be done, found by its words or done by its key.
function showKeys() {
  const ready = view.state?.ready;
  const entries = [
    ...KEYS.slice(0, -1),
    ...(ready ? view.state.recordings : []).map((one, k) => ["", `show ${one.name}`, () => look({ recording: k, range: null, cursor: null })]),
    ...((ready && view.state.ranking?.suspects) || []).map((one) => ["", `point at ${one.title}`, () => reach(one.name)]),
  ];
  const find = h("input", { type: "text", placeholder: "find an action, a recording, a suspect", "aria-label": "find an action, a recording, a suspect", "data-testid": "find" });
  const list = h("ul", { class: "finder" });
  const others = h("table", { class: "small" }, h("tbody", {}, OTHERS.map(([key, words]) => h("tr", {}, h("td", {}, h("kbd", {}, key)), h("td", {}, words)))));
  const go = (act) => {
    dialog.close();
    act();
  };
  const draw = () => {
    const words = find.value.toLowerCase().split(/\s+/).filter(Boolean);
    const shown = entries.filter(([key, text]) => (words.length ? words.every((word) => text.toLowerCase().includes(word)) : key));
    others.hidden = words.length > 0;
    list.replaceChildren(...shown.slice(0, MOST).map(([key, text, act]) => h("li", {}, button(h("span", {}, text), () => go(act)), key && h("kbd", {}, key))));
  };
  find.addEventListener("input", draw);
  const dialog = h("dialog", { class: "form", "aria-labelledby": "keys-title", onclose: () => dialog.remove() },
    h("h2", { id: "keys-title" }, "What to do"),
    h("form", { onsubmit: (event) => {
      event.preventDefault();
      list.querySelector("button")?.click();
    } }, find),
    list, others, button("close", () => dialog.close()));
  dialog.addEventListener("keydown", (event) => {
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!by) return;
    event.preventDefault();
    const stops = [find, ...list.querySelectorAll("button")];
    stops[Math.min(stops.length - 1, Math.max(0, stops.indexOf(document.activeElement) + by))].focus();
  });
  document.body.append(dialog);
  draw();
  dialog.showModal();
  find.focus();
}
