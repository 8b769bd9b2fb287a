// Draws the page from the state of the workspace, again whenever that or what this tab looks at has changed.

import { follow, tell } from "./api.js";
import * as panels from "/panels.js";
import { drawSelection, loadCompare, redraw } from "./panels/compare.js";
import { offerMapping } from "./panels/mapping.js";
import { drawRecordings } from "./panels/recordings.js";
import { catchDrops, drawStart } from "./panels/start.js";
import { doing, problem, say } from "./panels/status.js";
import { point } from "./panels/suspects.js";
import { drawWaiting } from "./panels/verdict.js";
import { h } from "./dom.js";
import { listenToKeys } from "./keys.js";
import { layOut, linkToState, remembered } from "./layout.js";
import { followSelection } from "./selection.js";
import { forget, look, on, refresh, view } from "./store.js";

const $ = (id) => document.getElementById(id);

// Where the control that has the keyboard goes with what it did (an effect that is added is no suspect any more), its
// section takes over.
function draw() {
  const held = document.activeElement, home = held && held.closest("section");
  drawAll();
  if (!home || held.isConnected) return;
  home.tabIndex = -1;
  home.focus({ preventScroll: true });
}

function drawAll() {
  const { state } = view;
  const empty = state.files.length === 0;
  $("start").hidden = !empty;
  $("work").hidden = empty;
  $("status").classList.toggle("hidden", !empty && !state.ready); // said in full size then
  document.body.dataset.ready = String(state.ready && state.fitted);
  say(state.busy ? `${state.busy} …` : empty || state.ready || state.problem ? "" : "give at least one recording to fit");
  if (state.problem) problem(state.problem, false);
  else if (shownProblem) problem(null);
  shownProblem = Boolean(state.problem);
  if (empty) {
    if (!$("start").firstChild) drawStart();
    return;
  }
  drawRecordings();
  offerMapping(state.files);
  for (const id of ["fold-side", "show-keys"]) $(id).hidden = false;
  for (const section of document.querySelectorAll("#work section:not(#recordings, #verdict)")) section.hidden = !state.ready;
  if (!state.ready) {
    drawWaiting();
    return;
  }
  forget(JSON.stringify([state.recordings, state.filter, state.files.map((file) => file.samples)]));
  for (const panel of Object.values(panels)) panel.draw();
}

let shownProblem = false;
let refreshing = false;
let again = false;

// One request at a time; what changes meanwhile is fetched after it.
async function update() {
  again = true;
  if (refreshing) return;
  refreshing = true;
  while (again) {
    again = false;
    try {
      await refresh();
    } catch (error) {
      problem(error);
    }
  }
  refreshing = false;
}

// A panel that names a section has one of its own above it; where it has nothing to show it leaves it empty.
for (const [id, panel] of Object.entries(panels)) {
  if (panel.ABOVE) $(panel.ABOVE).before(h("section", { id, "data-testid": id, "aria-labelledby": `${id}-title`, hidden: true }));
}
on("state", draw);
on("recording", () => doing(loadCompare()));
for (const what of ["cursor", "range", "preview"]) on(what, () => redraw(false));
on("selection", () => redraw());
on("selection", drawSelection);
for (const what of ["explained", "pointed", "preview"]) on(what, () => view.state.ready && panels.suspects.draw());
on("state", () => view.pointed && !view.state.ranking?.suspects.some((one) => one.name === view.pointed) && look({ pointed: null, preview: null }));
followSelection();
catchDrops();
listenToKeys();
layOut();
linkToState(point);
if (remembered("auto") === false) doing(tell("auto", { on: false }));
follow(update, () => say("connection lost; exoid open may have ended"));
update();
