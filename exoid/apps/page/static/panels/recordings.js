// The recordings: which are fitted, which held out, what the audit says, and how their columns are read.

import { tell } from "../api.js";
import { button, h, refill } from "../dom.js";
import { number, seconds } from "../format.js";
import { view } from "../store.js";
import { inPage, openMapping } from "./mapping.js";
import { picker } from "./start.js";
import { doing } from "./status.js";

let open = true;

export function drawRecordings() {
  const { files, model } = view.state;
  const list = h("details", { open, ontoggle: (event) => (open = event.target.open) },
    h("summary", {}, `${files.length} file${files.length === 1 ? "" : "s"}, model: ${model}`),
    h("ul", { class: "files" }, files.map(row)),
    view.state.left_out && h("p", { class: "faint", "data-testid": "left-out" }, view.state.left_out),
    h("div", { class: "row" }, picker("Add files …", "add-files")),
  );
  const place = document.getElementById("recordings");
  place.dataset.testid = "recordings";
  refill(place, h("h2", { id: "recordings-title" }, "Recordings"), list);
}

function row(file, place, files) {
  const same = place > 0 && file.error && files[place - 1].error?.what === file.error.what; // said once
  const id = `role-${file.id}`;
  const role = h("select", { id, "aria-label": `${file.name} is`, "data-testid": `role-${file.id}`,
    onchange: (event) => doing(tell("role", { file: file.id, role: event.target.value })) },
    h("option", { value: "fit" }, "fitted"), h("option", { value: "verify" }, "held out"));
  role.value = file.role;
  const worst = file.findings.filter((finding) => finding.severity !== "info");
  return h("li", {},
    h("div", { class: "row" }, h("span", { class: "file-name", title: file.rate ? `${seconds(file.seconds)} at ${number(file.rate)} Hz` : "" }, file.name), role,
      button("⋯", () => openMapping(file.id), { class: "icon", title: "which column is what", "aria-label": `columns of ${file.name}`, "data-testid": `map-${file.id}` }),
      button("✕", () => doing(tell("close", { file: file.id })), { class: "icon", "aria-label": `close ${file.name}`, "data-testid": `close-${file.id}` })),
    !file.read && h("p", { class: "faint" }, "being read …"),
    same && h("p", { class: "finding refused" }, "the same question"),
    file.error && !same && h("div", { class: "finding refused" }, h("p", {}, file.error.what), file.error.remedy && h("p", { class: "remedy" }, inPage(file.error.remedy)),
      h("div", { class: "row" }, button("Say which column is what …", () => openMapping(file.id)))),
    worst.length > 0 && h("details", {}, h("summary", {}, `${worst.length} note${worst.length === 1 ? "" : "s"} of the audit`),
      worst.map((finding) => h("div", { class: `finding ${finding.severity}` }, h("p", {}, finding.what), finding.remedy && h("p", { class: "remedy" }, finding.remedy)))),
  );
}
