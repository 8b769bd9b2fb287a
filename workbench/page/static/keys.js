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
  ["?", "this list", showKeys],
];
const OTHERS = [
  ["Ctrl+Z, Ctrl+Shift+Z", "undo, redo"], ["in a plot: ← →", "the cursor; with Shift a selection"],
  ["in a plot: + − 0", "zoom in, out, everything"], ["Escape", "clear the selection"], ["Tab", "every control, in order; the panes' edges move with ← →"],
];

export function listenToKeys() {
  document.addEventListener("keydown", keys);
  document.getElementById("show-keys").addEventListener("click", showKeys);
}

function keys(event) {
  const typing = event.target.matches("input:not([type=checkbox]), textarea, select");
  if (typing || document.querySelector("dialog[open]")) return;
  if (event.ctrlKey || event.metaKey) {
    if (event.key.toLowerCase() !== "z") return;
    event.preventDefault();
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
  point(next).then(() => document.querySelector(`[data-testid="suspect-${CSS.escape(next)}"]`)?.scrollIntoView({ block: "nearest" }));
}

function recording(by) {
  const count = view.state.recordings.length;
  look({ recording: (view.recording + by + count) % count, range: null, cursor: null });
}

function showKeys() {
  const dialog = h("dialog", { class: "form", "aria-labelledby": "keys-title", onclose: () => dialog.remove() },
    h("h2", { id: "keys-title" }, "Keys"),
    h("table", {}, h("tbody", {}, [...KEYS, ...OTHERS].map(([key, words]) => h("tr", {}, h("td", {}, h("kbd", {}, key)), h("td", {}, words))))),
    button("close", () => dialog.close()));
  document.body.append(dialog);
  dialog.showModal();
}
