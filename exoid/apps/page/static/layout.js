// How the page is laid out, remembered on this machine: sizes of the panes, what is folded; and links that lead to a state.

import { look, on, view } from "./store.js";

const PLACE = "exoid-layout";
// Pixels a pane may have, along which axis, and in which direction its edge is drawn to make it larger.
const PANES = {
  side: { within: [200, 560], axis: "x", sign: 1, of: ".side" }, right: { within: [240, 640], axis: "x", sign: -1, of: ".right" },
  plots: { within: [180, 2400], axis: "y", sign: 1, of: "#compare" }, detail: { within: [60, 900], axis: "y", sign: -1, of: "#detail" },
};
const STEP = 24;

let kept = read();

function read() {
  try {
    const found = JSON.parse(localStorage.getItem(PLACE));
    return found && typeof found === "object" ? found : {};
  } catch {
    return {};
  }
}

export function keep(changes) {
  kept = { ...kept, ...changes };
  try {
    localStorage.setItem(PLACE, JSON.stringify(kept));
  } catch {
    // Nothing is remembered then.
  }
}

export const remembered = (name) => kept[name];

export function layOut() {
  for (const pane of Object.keys(PANES)) if (Number.isFinite(kept[pane])) setSize(pane, kept[pane]);
  listen();
  const fold = document.getElementById("fold-side");
  fold.addEventListener("click", () => foldSide(!document.body.classList.contains("no-side")));
  foldSide(Boolean(kept.folded));
}

export function foldSide(folded) {
  document.body.classList.toggle("no-side", folded);
  document.getElementById("fold-side").setAttribute("aria-expanded", String(!folded));
  keep({ folded });
}

function setSize(pane, size) {
  const [low, high] = PANES[pane].within;
  const set = Math.round(Math.min(high, Math.max(low, size)));
  document.body.style.setProperty(`--${pane}`, `${set}px`);
  document.body.classList.add(`sized-${pane}`);
  for (const edge of document.querySelectorAll(`.split[data-pane=${pane}]`)) edge.setAttribute("aria-valuenow", String(set));
  return set;
}

// As large as it was made: what the window leaves.
function free(pane) {
  document.body.style.removeProperty(`--${pane}`);
  document.body.classList.remove(`sized-${pane}`);
  keep({ [pane]: null });
}

// One listener for all edges: some are drawn again while they are held.
function listen() {
  const paneAt = (event) => event.target.closest?.(".split")?.dataset.pane;
  const sizeOf = (pane) => document.querySelector(PANES[pane].of).getBoundingClientRect()[PANES[pane].axis === "x" ? "width" : "height"];
  const at = (event, pane) => (PANES[pane].axis === "x" ? event.clientX : event.clientY);
  let drag = null;
  const size = (event) => drag.size + PANES[drag.pane].sign * (at(event, drag.pane) - drag.from);
  const end = (event) => {
    if (drag?.moved) keep({ [drag.pane]: setSize(drag.pane, size(event)) });
    drag = null;
  };
  document.addEventListener("pointerdown", (event) => {
    const pane = paneAt(event);
    if (!pane) return;
    event.target.setPointerCapture(event.pointerId);
    drag = { pane, from: at(event, pane), size: sizeOf(pane), moved: false };
  });
  document.addEventListener("pointermove", (event) => {
    if (!drag) return;
    drag.moved = true;
    setSize(drag.pane, size(event));
  });
  document.addEventListener("pointerup", end);
  document.addEventListener("pointercancel", () => (drag = null));
  document.addEventListener("dblclick", (event) => paneAt(event) && free(paneAt(event)));
  document.addEventListener("keydown", (event) => {
    const pane = paneAt(event);
    const by = pane && (PANES[pane].axis === "x" ? { ArrowLeft: -STEP, ArrowRight: STEP } : { ArrowUp: -STEP, ArrowDown: STEP })[event.key];
    if (!by) return;
    event.preventDefault();
    keep({ [pane]: setSize(pane, sizeOf(pane) + PANES[pane].sign * by) });
  });
}

// The part of the address behind # says which recording and stretch is looked at, and which suspect is pointed at.
export function linkToState(point) {
  const write = () => {
    const said = new URLSearchParams();
    if (view.recording !== null) said.set("recording", String(view.recording));
    if (view.range) said.set("from", view.range[0].toFixed(3)), said.set("to", view.range[1].toFixed(3));
    if (view.pointed) said.set("suspect", view.pointed);
    const hash = said.toString();
    if (location.hash.slice(1) !== hash) history.replaceState(null, "", `#${hash}`);
  };
  for (const what of ["recording", "range", "pointed"]) on(what, write);
  const given = new URLSearchParams(location.hash.slice(1));
  let waiting = given.size > 0;
  on("state", () => {
    const { state } = view;
    if (!waiting || !state.ready) return;
    const recording = Number(given.get("recording"));
    if (given.has("recording") && recording < state.recordings.length && view.recording !== recording) look({ recording });
    const [from, to] = [Number(given.get("from")), Number(given.get("to"))];
    if (given.has("from") && to > from) look({ range: [from, to] });
    const suspect = given.get("suspect");
    const there = !suspect || (state.ranking && state.ranking.suspects.some((one) => one.name === suspect));
    waiting = !there;
    if (suspect && there) point(suspect);
  });
}
