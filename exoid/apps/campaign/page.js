"use strict";
// Everything from files is set as text. The table draws only the rows that can be seen: 10 000 scroll smoothly.
const data = JSON.parse(document.getElementById("data").textContent);
const colours = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", "#b8860b"];

function element(name, text, parent, className) {
  const made = document.createElement(name);
  if (text !== null && text !== undefined) made.textContent = String(text);
  if (className) made.className = className;
  if (parent) parent.append(made);
  return made;
}

const collator = new Intl.Collator(undefined, { numeric: true });  // one for all: localeCompare makes one for each pair

function compare(a, b) {
  const [x, y] = [a ?? "", b ?? ""];
  if (x === "" || y === "") return x === y ? 0 : x === "" ? 1 : -1;
  if (typeof x === "number" && typeof y === "number") return x - y;
  return collator.compare(String(x), String(y));
}

function significant(value) {
  return typeof value === "number" ? Number(value.toPrecision(4)).toString() : value ?? "";
}

function plainTable(id, heads, rows) {
  const section = document.getElementById(id);
  if (!rows.length) return;
  section.hidden = false;
  const table = section.querySelector("table");
  const head = element("tr", null, element("thead", null, table));
  heads.forEach((name, k) => {
    const number = rows.every((row) => row[k] === null || typeof row[k] === "number");
    element("th", name, head, number ? "number" : "").scope = "col";
  });
  const body = element("tbody", null, table);
  for (const row of rows) {
    const line = element("tr", null, body);
    for (const cell of row) element("td", significant(cell), line, typeof cell === "number" ? "number" : "");
  }
}

function state() {
  const share = data.jobs ? data.done / data.jobs : 1;
  document.querySelector(".bar span").style.width = `${100 * share}%`;
  document.querySelector(".bar").setAttribute("aria-valuenow", String(Math.round(100 * share)));
  const parts = Object.entries(data.status).sort().map(([name, count]) => `${count} ${name}`);
  const tail = data.running ? "; the campaign is running" : "";
  document.getElementById("counts").textContent = `${data.done} of ${data.jobs} jobs: ${parts.join(", ") || "none yet"}${tail}`;
  for (const text of [...data.notes, ...data.events]) element("li", text, document.getElementById("events"));
}

function fleet() {
  const { devices, effects, answered, counts } = data.fleet;
  if (!devices || !devices.length || !effects.length) return;
  document.getElementById("fleet").hidden = false;
  const table = document.querySelector("#fleet table");
  const head = element("tr", null, element("thead", null, table));
  for (const name of [data.device, "jobs", ...effects]) element("th", name, head).scope = "col";
  const body = element("tbody", null, table);
  devices.forEach((device, k) => {
    const line = element("tr", null, body);
    element("th", device, line).scope = "row";
    element("td", answered[k], line, "number");
    for (const count of counts[k]) {
      const cell = element("td", count || "", line, "heat");
      cell.style.setProperty("--share", String(0.75 * count / answered[k]));
    }
  });
}

function jobs() {
  const wrap = document.querySelector(".rows");
  const body = wrap.querySelector("tbody");
  const head = element("tr", null, wrap.querySelector("thead"));
  const searched = data.rows.map((row) => row.join(" ").toLowerCase());
  let order = data.rows.map((_, k) => k), shown = order, sorted = -1, down = false, height = 33;
  const heads = data.heads.map((name, column) => {
    const cell = element("th", null, head);
    cell.scope = "col";
    element("button", name, cell).addEventListener("click", () => {
      down = sorted === column && !down;
      sorted = column;
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      cell.setAttribute("aria-sort", down ? "descending" : "ascending");
      order.sort((a, b) => (down ? -1 : 1) * compare(data.rows[a][column], data.rows[b][column]) || a - b);
      filter();
    });
    return cell;
  });
  const input = document.querySelector("#jobs input");

  function filter() {
    const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    shown = order.filter((k) => words.every((word) => searched[k].includes(word)));
    document.getElementById("shown").textContent = `${shown.length} of ${data.rows.length}`;
    wrap.scrollTop = 0;
    draw();
  }

  function pad(rows) {
    const cell = element("td", null, element("tr", null, body), "pad");
    cell.colSpan = data.heads.length;
    cell.style.height = `${rows * height}px`;
  }

  function draw() {
    const first = Math.max(0, Math.floor(wrap.scrollTop / height) - 10);
    const last = Math.min(shown.length, first + Math.ceil((wrap.clientHeight || 600) / height) + 30);
    body.replaceChildren();
    if (first > 0) pad(first);
    for (const k of shown.slice(first, last)) {
      const row = data.rows[k], line = element("tr", null, body);
      data.heads.forEach((name, c) => {
        const kind = typeof row[c] === "number" ? "number" : name === "status" ? `status-${row[c]}` : "";
        const report = c === 0 && row[data.heads.length];  // the name of a job leads to its report
        const cell = element("td", report ? null : significant(row[c]), line, kind);
        if (report) element("a", row[c], cell).href = encodeURI(report);
        cell.title = typeof row[c] === "string" ? row[c] : "";
      });
    }
    if (last < shown.length) pad(shown.length - last);
    const one = body.querySelector("tr:not(:first-child)");
    if (one && one.offsetHeight && !one.querySelector(".pad")) height = one.offsetHeight;
  }

  let due = false;
  wrap.addEventListener("scroll", () => {
    if (due) return;
    due = true;
    requestAnimationFrame(() => { due = false; draw(); });
  });
  input.addEventListener("input", filter);
  filter();
}

function history() {
  if (!data.history.length) return;
  const section = document.getElementById("history"), choice = section.querySelector("select");
  section.hidden = false;
  data.history.forEach((one, k) => { element("option", one.parameter, choice).value = String(k); });
  choice.addEventListener("change", () => draw(data.history[Number(choice.value)]));
  draw(data.history[0]);

  function svg(name, attributes, parent, text) {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
    if (text !== undefined) made.textContent = text;
    parent.append(made);
    return made;
  }

  function draw(one) {
    const box = section.querySelector(".chart");
    box.replaceChildren();
    const points = [...one.points].sort((a, b) => compare(a[0], b[0]) || compare(a[1], b[1]));
    const dates = [...new Set(points.map((p) => p[0]))], devices = [...new Set(points.map((p) => p[1]))].sort();
    const ends = points.flatMap((p) => [p[2], p[3] ?? p[2], p[4] ?? p[2]]);
    let low = Math.min(...ends), high = Math.max(...ends);
    if (high === low) { low -= 1; high += 1; }
    const W = 900, H = 340, left = 80, bottom = 60, top = 30;
    const drawn = svg("svg", { viewBox: `0 0 ${W} ${H}`, role: "img", "aria-label": `${one.parameter} over ${data.date}` }, box);
    const x = (date, device) => left + (W - left - 20) * (dates.indexOf(date) + 0.5 + 0.6 * ((devices.indexOf(device) + 0.5) / devices.length - 0.5)) / dates.length;
    const y = (value) => top + (H - top - bottom) * (1 - (value - low) / (high - low));
    for (let k = 0; k <= 4; k += 1) {
      const value = low + (high - low) * k / 4;
      svg("line", { x1: left, x2: W - 20, y1: y(value), y2: y(value), class: "axis" }, drawn);
      svg("text", { x: left - 8, y: y(value) + 4, "text-anchor": "end" }, drawn, Number(value.toPrecision(3)).toString());
    }
    svg("text", { x: left, y: 16 }, drawn, `${one.parameter} [${one.unit}]`);
    const step = Math.ceil(dates.length / 12);
    dates.forEach((date, k) => { if (k % step === 0) svg("text", { x: left + (W - left - 20) * (k + 0.5) / dates.length, y: H - bottom + 20, "text-anchor": "middle" }, drawn, date); });
    devices.slice(0, 12).forEach((device, k) => svg("text", { x: left + 70 * k, y: H - 10, style: `fill:${colours[k % colours.length]}` }, drawn, device));
    for (const [date, device, value, from, to, job] of points) {
      const colour = colours[devices.indexOf(device) % colours.length], at = x(date, device);
      if (from !== null && to !== null) svg("line", { x1: at, x2: at, y1: y(from), y2: y(to), stroke: colour, "stroke-width": 2 }, drawn);
      svg("title", {}, svg("circle", { cx: at, cy: y(value), r: 4, fill: colour }, drawn), `${job}: ${value} [${from}, ${to}] ${one.unit}`);
    }
  }
}

state();
fleet();
plainTable("pooled", ["parameter", "unit", "devices", "mean", "low", "high", "spread", "stand out"],
  data.pooled.map((p) => [p.parameter, p.unit, p.devices, p.mean, p.low, p.high, p.spread,
    p.outliers.map((o) => `${o.device} (${significant(o.value)}, p = ${significant(o.p)})`).join("; ")]));
history();
jobs();
plainTable("unreadable", ["job", "recording", "reason"], data.unreadable.map((one) => [one.job, one.path, one.reason]));
