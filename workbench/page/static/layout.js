// How the page is laid out, remembered on this machine: widths of the panes, what is folded; and links that lead to a state.

import { look, on, view } from "./store.js";

const PLACE = "exoid-layout";
const WIDTHS = { side: [200, 560], right: [240, 640] };
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
  for (const pane of Object.keys(WIDTHS)) if (Number.isFinite(kept[pane])) setWidth(pane, kept[pane]);
  for (const split of document.querySelectorAll(".split")) listen(split, split.dataset.pane);
  const fold = document.getElementById("fold-side");
  fold.addEventListener("click", () => foldSide(!document.body.classList.contains("no-side")));
  foldSide(Boolean(kept.folded));
}

export function foldSide(folded) {
  document.body.classList.toggle("no-side", folded);
  document.getElementById("fold-side").setAttribute("aria-expanded", String(!folded));
  keep({ folded });
}

function setWidth(pane, width) {
  const [low, high] = WIDTHS[pane];
  const set = Math.round(Math.min(high, Math.max(low, width)));
  document.body.style.setProperty(`--${pane}`, `${set}px`);
  return set;
}

function listen(split, pane) {
  const place = () => document.querySelector(`.${pane}`).getBoundingClientRect().width;
  const sign = pane === "side" ? 1 : -1;
  let drag = null;
  split.addEventListener("pointerdown", (event) => {
    split.setPointerCapture(event.pointerId);
    drag = { x: event.clientX, width: place() };
  });
  split.addEventListener("pointermove", (event) => drag && setWidth(pane, drag.width + sign * (event.clientX - drag.x)));
  split.addEventListener("pointerup", (event) => {
    if (drag) keep({ [pane]: setWidth(pane, drag.width + sign * (event.clientX - drag.x)) });
    drag = null;
  });
  split.addEventListener("pointercancel", () => (drag = null));
  split.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: -STEP, ArrowRight: STEP }[event.key];
    if (!by) return;
    event.preventDefault();
    keep({ [pane]: setWidth(pane, place() + sign * by) });
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
