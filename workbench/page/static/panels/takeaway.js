// Everything that was done, to take away: as a command, as Python, as a model, as a report, as a folder.

import { ask, tell, url } from "../api.js";
import { button, fill, h } from "../dom.js";
import { view } from "../store.js";
import { doing, say } from "./status.js";

let kind = "cli";

export function drawTakeaway() {
  const place = document.getElementById("takeaway");
  if (!place.firstChild) {
    const choose = h("select", { id: "copy-kind", onchange: (event) => {
      kind = event.target.value;
      show();
    } }, [["cli", "command line"], ["python", "Python"], ["toml", "model (TOML)"]].map(([value, words]) => h("option", { value }, words)));
    const folder = h("input", { id: "save-folder", type: "text", "data-testid": "save-folder", value: view.state.folder });
    fill(place,
      h("h2", { id: "takeaway-title" }, "Take away"),
      h("div", { class: "row wrap" }, h("label", { for: "copy-kind" }, "as ", choose), button("Copy", copy, { "data-testid": "copy-command" })),
      h("pre", { id: "command", "data-testid": "command", tabindex: "0" }),
      h("div", { class: "row wrap" }, link("Report", "/api/report", "save-report"), link("Model", "/api/model", "save-model")),
      h("div", { class: "row wrap" }, h("label", { for: "save-folder" }, "folder ", folder),
        button("Save the session", () => doing(save(folder.value)), { "data-testid": "save-session" })),
      h("p", { class: "faint", id: "saved", role: "status" }),
    );
  }
  const saved = document.getElementById("saved");
  saved.textContent = view.state.saved ? `saved in ${view.state.saved}; exoid open that folder goes on from there` : "";
  show();
}

let texts = {};
let shownFor = "";

async function show() {
  const { state } = view;
  const now = JSON.stringify([state.key, state.verdict.kind, state.files.map((file) => [file.name, file.role]), state.own, state.fitted]);
  if (now !== shownFor) {
    shownFor = now;
    texts = (await doing(ask("/api/takeaway"))) || {};
  }
  document.getElementById("command").textContent = texts[kind] || "";
}

async function copy() {
  const text = texts[kind] || "";
  try {
    await navigator.clipboard.writeText(text);
    say("copied");
  } catch {
    const range = document.createRange();
    range.selectNodeContents(document.getElementById("command"));
    getSelection().removeAllRanges();
    getSelection().addRange(range);
    say("selected; press Ctrl+C");
  }
}

async function save(folder) {
  const { folder: place } = await tell("save", { folder });
  say(`saved in ${place}`);
}

function link(words, path, testid) {
  return h("a", { class: "button", href: url(path), download: "", "data-testid": testid }, words);
}
