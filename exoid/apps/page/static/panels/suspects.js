// What could be missing, best first: pointing at a suspect draws the error as it would become.

import { ask, numbers, tell } from "../api.js";
import { button, h, refill } from "../dom.js";
import { number, percent, rms } from "../format.js";
import { remembered } from "../layout.js";
import { look, view } from "../store.js";
import { doing } from "./status.js";

const WEAK = 0.015; // drawn smaller below this share of the error
const FOLDED = 0.01; // behind a fold below it

let asked = null;
let shown = null;

export function draw() {
  const { ranking } = view.state;
  const place = document.getElementById("suspects-list");
  const head = h("h2", { id: "suspects-title" }, "Suspects");
  if (!ranking) {
    refill(place, head, h("p", { class: "faint" }, "ranked as soon as the model is fitted …"));
    return;
  }
  const chosen = view.explained;
  const suspects = [...ranking.suspects];
  if (chosen) suspects.sort((a, b) => (chosen[b.name] ?? -9) - (chosen[a.name] ?? -9));
  const progress = ranking.finished ? "all placebos asked"
    : ranking.weighed < 1 ? `${percent(ranking.weighed)} of the catalogue weighed` : "asking placebos; the p-values narrow";
  refill(place, head,
    h("p", { class: "faint small", title: "what each would take away of the squared error of its own joints, on one fitted recording after the other, each left out of the fit in turn; of what was found, on the motion that the steps show", "data-testid": "ranking-progress", "data-finished": String(ranking.finished) },
      chosen ? "Share of the selected error; " : "Share of the error on unseen motion; ", progress),
    lists(suspects, chosen),
    h("div", { class: "about", id: "about" },
      h("div", { class: "split", "data-pane": "detail", role: "separator", "aria-orientation": "horizontal", "aria-label": "height of what is said of a suspect", "aria-valuenow": remembered("detail") ?? 0, tabindex: "0", id: "detail-edge" }),
      detailPanel()),
  );
}

const shareOf = (suspect, chosen) => (chosen ? chosen[suspect.name] : suspect.share);

// What explains a percent or more, and the rest behind a fold, which opens where one of it is pointed at.
function lists(suspects, chosen) {
  const rows = (some) => h("ul", { class: "suspects" }, some.map((suspect) => row(suspect, chosen)));
  const folded = suspects.filter((one) => !(shareOf(one, chosen) >= FOLDED));
  if (!folded.length || folded.length === suspects.length) return rows(suspects);
  const fold = document.getElementById("fold");
  if (fold && folded.some((one) => one.name === view.pointed)) fold.open = true;
  return [rows(suspects.filter((one) => !folded.includes(one))),
    h("details", { class: "fold", id: "fold" }, h("summary", {}, `${folded.length} more below ${percent(FOLDED)}`), rows(folded))];
}

function row(suspect, chosen) {
  const share = shareOf(suspect, chosen);
  const bar = h("span", { class: "share-bar" });
  bar.style.setProperty("--share", `${Math.round(100 * Math.max(0, Math.min(1, share || 0)))}%`);
  const on = () => point(suspect.name);
  const name = button(suspect.title, on, { class: "link", "aria-describedby": `p-${suspect.name}`, title: `${suspect.explains}\n${evidence(suspect)}` });
  const kinds = [view.pointed === suspect.name && "pointed", suspect.sureness === "very sure" && "sure", !(share >= WEAK) && "weak"];
  return h("li", {
    "data-testid": `suspect-${suspect.name}`, class: kinds.filter(Boolean).join(" "),
    onpointermove: (event) => moved(event) && on(), onfocusin: on,
  },
    h("div", { class: "suspect-head" }, name, bar, h("span", { class: "share" }, percent(share)),
      button("add", () => doing(tell("add", { effect: suspect.name })), { "data-testid": `add-${suspect.name}`, "aria-label": `add ${suspect.name}` })),
    h("div", { class: "small", id: `p-${suspect.name}`, title: evidence(suspect) },
      suspect.sureness && sure(suspect.sureness), suspect.caution && h("span", { class: "faint" }, ` ${suspect.caution}`),
      h("span", { class: "hidden" }, ` ${suspect.name} ${evidence(suspect)}`)),
  );
}

// A list that is sorted anew under a pointer at rest moves to it too: that is not pointing.
let at = "";

function moved(event) {
  const before = at;
  at = `${event.clientX},${event.clientY}`;
  return at !== before;
}

// How sure, in a word; a click says what the word means.
export function sure(word) {
  return h("details", { class: `sure-word ${word.replace(" ", "-")}` }, h("summary", {}, word), h("p", { class: "faint" }, view.state.sureness[word]));
}

// The figures behind the word, for a tooltip.
function evidence(suspect) {
  const parts = [suspect.name];
  if (suspect.p !== null) parts.push(`p = ${number(suspect.p, 2)} (${number(suspect.p_low, 2)} to ${number(suspect.p_high, 2)}, ${suspect.draws} placebos)`);
  if (suspect.splits) parts.push(`${suspect.splits[0]} of ${suspect.splits[1]} splits agree`);
  return parts.join(" · ");
}

export async function point(name) {
  if (view.pointed === name && view.preview) return;
  if (asked) asked.abort();
  asked = new AbortController();
  const { signal } = asked;
  look({ pointed: name });
  try {
    const [preview, details] = await Promise.all([
      numbers("/api/preview", { effect: name, recording: view.recording }, signal), ask("/api/details", { effect: name }, signal)]);
    if (view.pointed !== name) return;
    shown = details;
    look({ preview });
  } catch (error) {
    if (error.name !== "AbortError") look({ preview: null });
  }
}

// What a suspect is called, where it is known here.
export function titleOf(name) {
  return view.state.ranking?.suspects.find((one) => one.name === name)?.title || name;
}

// What does as well as a suspect, or better, of those that act on the same joint.
function rivals({ name, alike }) {
  const { suspects } = view.state.ranking || { suspects: [] };
  const own = suspects.find((one) => one.name === name);
  const better = own && suspects.filter((one) => !one.caution && one.share > own.share && (!one.joint || !own.joint || one.joint === own.joint));
  const best = better?.length && better.reduce((most, one) => (one.share > most.share ? one : most));
  const parts = alike.length ? [`These data cannot distinguish it from: ${alike.map(titleOf).join(", ")}.`] : [];
  if (best && !alike.includes(best.name)) parts.push(`${best.title} explains more: ${percent(best.share)}, this ${percent(own.share)}.`);
  return parts.join(" ") || "Nothing else does as well in these data.";
}

function detailPanel() {
  if (!shown || view.pointed !== shown.name) return h("div", { class: "detail", id: "detail" }, h("p", { class: "faint" }, "Point at a suspect: what it means, what it cannot be distinguished from, what to measure."));
  const { joints } = view.state;
  const falls = shown.rms ? joints.map((joint, j) => `${joint.name} ${rms(joint.error)} → ${rms(shown.rms[j])} ${joint.unit}`).join(", ") : "";
  return h("div", { class: "detail", id: "detail", "data-testid": "detail" },
    h("h3", {}, shown.title), h("p", {}, shown.explains),
    falls && h("p", {}, `Error as it would become on ${view.state.judged} motion: ${falls}. In the plots: the heavy line with it, grey what its placebos leave.`),
    shown.torque && h("p", {}, h("code", {}, shown.torque)),
    shown.numbers.length > 0 && h("p", { class: "faint" }, shown.numbers.map((one) => one.said).join(", ")),
    h("p", { class: "faint", "data-testid": "rivals" }, rivals(shown)),
    h("p", { class: "faint" }, `To measure: ${shown.tells_apart}`),
  );
}
