// Which column is what: the columns with first values, what exoid thinks, and what it doubts.

import { ask, tell } from "../api.js";
import { button, h } from "../dom.js";
import { number } from "../format.js";
import { doing } from "./status.js";

const ROWS = 5;
const IDLE = "\u0000no drive"; // no name of a column
const SIDES = { left: "Left", right: "Right", ipsi: "Same side", contra: "Other side", both: "Both" };
const offered = new Set();

let waiting = null;

// A remedy of the command line, as it is done on the page.
export function inPage(remedy) {
  return remedy.replace(/--leg (left|right|ipsi|contra)( or --leg \w+)*( \(two recordings\))?/, "press the leg that is meant")
    .replace(/it is: --map (\w+=COLUMN,?){2,}/g, "each of them is").replace(/--map (\w+)=COLUMN/g, "choose one as $1").replace(/--map (\w+)=("[^"]*"|'[^']*'|[^\s,;]+)/g, "choose $2 as $1").replace(/--units (\S+)/g, "write the unit beside the column ($1)").replace(/--passive (\w+) where that joint has no drive/g, "choose “no drive” for the torque of the $1").replace(/first give --convention (\S+)/g, "first read them as $1").replace(/give --convention (\S+)/g, "read them as $1").replace(/--rate (\d+)( \([^)]*\))?/g, "write it beside “no clock” ($1)").replace(/--verify/g, "“held out”");
}

// A file that cannot be read as it is opens the dialog by itself, once; the dialog goes when the file could be read after all.
export function offerMapping(files) {
  const solved = waiting && !files.some((one) => one.id === waiting.id && one.error);
  if (solved && waiting.dialog) waiting.dialog.close();
  if (solved) waiting = null;
  const opening = waiting && !waiting.dialog;
  if (opening || document.querySelector("dialog[open]")) return;
  const file = files.find((one) => one.error && !offered.has(one.id));
  if (!file) return;
  waiting = { id: file.id, dialog: null };
  openMapping(file.id);
}

export async function openMapping(id) {
  offered.add(id);
  const own = waiting && waiting.id === id ? waiting : null; // opened by itself
  const table = await doing(ask("/api/columns", { file: id }));
  if (!table || (own && (!table.error || waiting !== own))) { // read meanwhile, as another file's answer says
    if (own && waiting === own) waiting = null;
    return;
  }
  const error = h("div", { role: "alert", "data-testid": "map-error" });
  const showError = (problem) => error.replaceChildren(...(problem ? [h("div", { class: "finding refused" }, h("p", {}, problem.what), problem.remedy ? h("p", { class: "remedy" }, inPage(problem.remedy)) : "")] : []));
  const sided = table.sides.length > 1;
  if (!(sided && !table.told.leg)) showError(table.error);
  const rows = table.wanted.map((wanted) => wantedRow(wanted, table));
  const leg = choice("map-leg", [["", "not said"], ...["left", "right", "both"].map((name) => [name, name])], table.told.leg);
  const convention = choice("map-convention", [["", "exoid's own"], ...table.conventions.map((one) => [one.name, `${one.name}: ${one.what}`])], table.convention);
  const rate = h("input", { id: "map-rate", type: "text", inputmode: "decimal", size: 8, "data-testid": "map-rate", placeholder: "Hz", value: table.told.rate || "" });
  const clocked = table.guess.t && !table.told.rate && !/--rate/.test(table.error?.remedy || "");
  const dialog = h("dialog", { class: "form", "data-testid": "map-dialog", "aria-labelledby": "map-title", onclose: () => dialog.remove() },
    h("h2", { id: "map-title" }, "Which column is what? ", h("span", { class: "file-name" }, table.name)),
    sided && sides(),
    error,
    table.findings.map((finding) => h("div", { class: `finding ${finding.severity}` }, h("p", {}, finding.what), finding.remedy && h("p", { class: "remedy" }, finding.remedy))),
    h("div", { class: "scroll", tabindex: "0", "aria-label": "the columns of the file" }, preview(table)),
    h("div", { class: "mapping" }, rows.filter((row) => row.required).map((row) => row.element)),
    h("div", { class: "row mapping-row", hidden: clocked }, h("label", { for: "map-rate" }, "no clock: samples a second"), rate),
    h("details", { open: rows.some((row) => !row.required && row.column.value) }, h("summary", {}, "what else the file may hold: velocities, accelerations, forces"),
      h("div", { class: "mapping" }, rows.filter((row) => !row.required).map((row) => row.element))),
    h("details", {}, h("summary", {}, "leg and convention"), h("label", { for: "map-leg" }, "leg ", leg), h("label", { for: "map-convention" }, "angles and torques are counted as ", convention)),
    h("p", { class: "faint" }, "Kept for the next file with these columns."),
    h("div", { class: "row" }, button("Use these columns", send, { class: sided && !table.told.leg ? "" : "primary", "data-testid": "map-apply" }), button("Cancel", () => dialog.close())),
  );
  // The file holds several legs: one click says which, and fills in what belongs to it.
  function sides() {
    const both = table.sides.includes("left") && table.sides.includes("right");
    return h("div", { class: "row wrap sides", role: "group", "aria-label": "which leg" }, h("strong", {}, "Which leg?"),
      [...table.sides, ...(both ? ["both"] : [])].map((side) => button(SIDES[side], () => takeSide(side), { "data-testid": `side-${side}`, class: "primary" })),
      h("span", { class: "faint" }, "holds for the other files too"));
  }
  async function takeSide(side) {
    leg.value = side;
    try {
      await tell("map", { file: id, columns: {}, units: {}, leg: side, convention: convention.value, rate: rate.value.trim() });
      dialog.close();
    } catch (problem) {
      const guess = table.guesses[side] || {};
      for (const row of rows) {
        row.column.value = guess[row.name]?.column || "";
        if (guess[row.name] && !row.unit.value) row.unit.placeholder = guess[row.name].unit;
      }
      showError(problem);
    }
  }
  async function send() {
    const named = rows.filter((row) => row.column.value && row.column.value !== IDLE);
    const passive = rows.filter((row) => row.column.value === IDLE).map((row) => row.joint);
    const columns = Object.fromEntries(named.map((row) => [row.name, row.column.value]));
    const units = Object.fromEntries(named.filter((row) => row.unit.value.trim()).map((row) => [row.name, row.unit.value.trim()]));
    try {
      await tell("map", { file: id, columns, units, passive, leg: leg.value, convention: convention.value, rate: rate.value.trim() });
      dialog.close();
    } catch (problem) {
      showError(problem);
    }
  }
  document.body.append(dialog);
  dialog.showModal();
  if (waiting && waiting.id === id) waiting.dialog = dialog;
}

function choice(id, known, value) {
  const options = known.some(([key]) => key === value) ? known : [...known, [value, value]];
  const select = h("select", { id, "data-testid": id }, options.map(([key, words]) => h("option", { value: key }, words)));
  select.value = value;
  return select;
}

function wantedRow(wanted, table) {
  const idle = wanted.joint && table.told.passive.includes(wanted.joint);
  const guess = idle ? { column: IDLE } : table.guess[wanted.name];
  const id = `map-${wanted.name}`;
  const column = choice(id, [["", wanted.required ? "choose …" : "not there"], ...(wanted.joint ? [[IDLE, `no drive: the ${wanted.joint} swings freely`]] : []), ...table.columns.map((one) => [one.name, one.name])], guess ? guess.column : "");
  const unit = h("input", { type: "text", size: 9, "aria-label": `unit of ${wanted.name}`, "data-testid": `map-unit-${wanted.name}`, placeholder: wanted.si,
    value: table.told.units[wanted.name] || (guess && guess.unit && guess.unit !== wanted.si ? guess.unit : "") });
  const words = h("label", { for: id, title: wanted.name }, wanted.said);
  return { name: wanted.name, joint: wanted.joint, required: wanted.required, column, unit, element: h("div", { class: "row mapping-row" }, words, column, unit) };
}

function preview(table) {
  const shown = table.columns.slice(0, 60);
  const count = Math.min(ROWS, Math.max(...shown.map((column) => column.first.length), 0));
  const cell = (value, digits) => (typeof value === "number" ? (digits > 5 ? String(value) : number(value, 5)) : value ?? "");
  // Of a clock in ms or in seconds since 1970 only the last digits differ.
  const digits = (column) => (column.first.some((v, k) => k && v !== column.first[k - 1] && cell(v, 5) === cell(column.first[k - 1], 5)) ? 17 : 5);
  return h("table", {},
    h("caption", { class: "caption" }, `${table.columns.length} columns, the first ${count} rows`),
    h("thead", {}, h("tr", {}, shown.map((column) => h("th", { scope: "col" }, column.name, column.unit ? ` [${column.unit}]` : "")))),
    h("tbody", {}, Array.from({ length: count }, (_, k) => h("tr", {}, shown.map((column) => h("td", { class: "number" }, cell(column.first[k], digits(column))))))),
  );
}
