// The effects that were added, as layers: on, off, away; and the user's own effect, typed.

import { tell } from "../api.js";
import { button, h, refill } from "../dom.js";
import { number } from "../format.js";
import { view } from "../store.js";
import { openOwnEffect } from "./own_effect.js";
import { doing } from "./status.js";

export function draw() {
  const { layers, failed, fitted } = view.state;
  refill(document.getElementById("layers"),
    h("h2", { id: "layers-title" }, "Effects in the model"),
    layers.length === 0 && h("p", { class: "faint" }, "None beyond rigid body, Coulomb and viscous friction. Point at a suspect to see the error with it, and add it."),
    h("ul", { class: "layers" }, layers.map(row)),
    failed && h("div", { class: "finding refused" }, h("p", {}, failed.what), h("p", { class: "remedy" }, failed.remedy)),
    !fitted && !failed && h("p", { class: "faint", role: "status" }, "being refined in the background; the curves are what the ranking foresees"),
    h("div", { class: "row" }, button("Your own effect …", () => openOwnEffect(), { "data-testid": "own-effect" })),
  );
}

function row(layer) {
  const box = h("input", { type: "checkbox", checked: layer.on, "aria-label": `${layer.name} is on`, "data-testid": `switch-${layer.name}`,
    onchange: () => doing(tell("switch", { effect: layer.name })) });
  return h("li", { "data-testid": `layer-${layer.name}`, class: layer.on ? "" : "off" },
    h("div", { class: "row wrap" }, h("label", {}, box, h("strong", { title: layer.name }, ` ${layer.title}`)), h("span", { class: "hidden" }, layer.name),
      button("remove", () => doing(tell("remove", { effect: layer.name })), { "aria-label": `remove ${layer.name}`, "data-testid": `remove-${layer.name}` })),
    h("p", { class: "faint" }, layer.numbers.map((one) => `${one.said}${one.low === null || one.low === one.high ? "" : ` (${number(one.low)} to ${number(one.high)})`}`).join(", ") || layer.explains),
  );
}
