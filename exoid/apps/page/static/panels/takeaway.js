// Everything that was done, to take away: as a command, as Python, as a model, as a report, as a folder.

import { ask, download, tell } from "../api.js";
import { button, fill, h } from "../dom.js";
import { view } from "../store.js";
import { doing, say } from "./status.js";

const FORMATS = { c: "C", casadi: "CasADi", numpy: "NumPy", urdf: "URDF", mjcf: "MJCF", fmu: "FMU", ros2: "ROS 2", updater: "updating C" };

let kind = "cli";

export function draw() {
  const place = document.getElementById("takeaway");
  if (!place.firstChild) {
    const choose = h("select", { id: "copy-kind", onchange: (event) => {
      kind = event.target.value;
      show();
    } }, [["cli", "command line"], ["python", "Python"], ["toml", "model (TOML)"]].map(([value, words]) => h("option", { value }, words)));
    const format = h("select", { id: "export-format", "data-testid": "export-format" }, view.state.formats.map((name) => h("option", { value: name }, FORMATS[name] || name)));
    const folder = h("input", { id: "save-folder", type: "text", "data-testid": "save-folder", value: view.state.folder });
    choose.value = kind;
    fill(place,
      h("h2", { id: "takeaway-title" }, "Take away"),
      h("div", { class: "row wrap" }, h("label", { for: "copy-kind" }, "as ", choose), button("Copy", copy, { "data-testid": "copy-command" })),
      h("pre", { id: "command", "data-testid": "command", tabindex: "0" }),
      h("div", { class: "row wrap" }, keep("Report", () => download("/api/report", {}, "report.html"), "save-report"),
        keep("Model", () => download("/api/model", {}, "model.toml"), "save-model"),
        h("label", { for: "export-format" }, "code for ", format), keep("Export", () => download("/api/export", { format: format.value }, `exoid-model-${format.value}.zip`), "export-model")),
      h("div", { class: "row wrap" }, h("label", { for: "save-folder" }, "folder ", folder),
        button("Save the session", () => doing(save(folder.value)), { "data-testid": "save-session" })),
      h("p", { class: "faint", id: "saved", role: "status" }),
    );
  }
  const saved = document.getElementById("saved");
  saved.dataset.kept = String(view.state.kept);
  saved.textContent = view.state.saved ? `saved in ${view.state.saved}; exoid open that folder goes on from there` : "";
  show();
}

let texts = {};
let shownFor = "";

async function show() {
  const { state } = view;
  const now = JSON.stringify([state.key, state.verdict.kind, state.verdict.judged, state.files.map((file) => [file.name, file.role]), state.own]);
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

// A button for what takes a moment to make: it says so meanwhile, and is not pressed twice.
function keep(words, make, testid) {
  const press = button(words, async () => {
    press.disabled = true;
    press.textContent = `${words} …`;
    await doing(make());
    press.textContent = words;
    press.disabled = false;
  }, { "data-testid": testid });
  return press;
}
