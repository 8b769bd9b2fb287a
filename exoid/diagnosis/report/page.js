"use strict";
// Click on a head sorts a table of some length: numbers by value, text by alphabet; a second click turns the order round.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0];
  if (body.rows.length < 3) continue;
  table.classList.add("sorts");
  Array.from(table.tHead.rows[0].cells).forEach((cell, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...cell.childNodes);
    cell.append(button);
    button.addEventListener("click", () => {
      const down = cell.getAttribute("aria-sort") === "ascending";
      for (const other of cell.parentNode.cells) other.removeAttribute("aria-sort");
      cell.setAttribute("aria-sort", down ? "descending" : "ascending");
      const key = (row) => {
        const entry = row.cells[column];
        if ("value" in entry.dataset) return entry.dataset.value === "" ? Infinity : Number(entry.dataset.value);
        return entry.textContent.trim().toLowerCase();
      };
      const order = (a, b) => {
        const x = key(a), y = key(b);
        const sign = typeof x === "number" && typeof y === "number" ? x - y : String(x).localeCompare(String(y));
        return (Number.isNaN(sign) ? 0 : sign) * (down ? -1 : 1);
      };
      body.append(...Array.from(body.rows).sort(order));
    });
  });
}
// A section that is folded opens where a link points at it, and all of them open on paper, but for an appendix that is shut.
const unfold = (sections) => sections.forEach((section) => {
  const around = section?.closest("details.appendix");
  if (around) around.open = true;
  section?.querySelectorAll("details").forEach((d) => { d.open = true; });
});
const follow = () => unfold([document.getElementById(decodeURIComponent(location.hash.slice(1)))]);
addEventListener("hashchange", follow);
addEventListener("beforeprint", () => unfold([...document.querySelectorAll("main > section, .appendix[open]")]));
for (const link of document.querySelectorAll("nav a")) link.addEventListener("click", () => setTimeout(follow));
follow();
// Click on a figure shows it large; Escape or another click closes it.
const zoom = document.getElementById("zoom");
for (const button of document.querySelectorAll("button.zoom")) {
  button.addEventListener("click", () => {
    const small = button.querySelector("img");
    const large = zoom.querySelector("img");
    large.src = small.src;
    large.alt = small.alt;
    zoom.showModal();
  });
}
zoom.addEventListener("click", () => zoom.close());
