// The first screen: drop files, pick them, or begin with the demo.

import { tell, upload } from "../api.js";
import { button, fill, h } from "../dom.js";
import { view } from "../store.js";
import { doing, say } from "./status.js";

const HELD_OUT = /^(verify|validation|valid|test|held|hold)/i;

// Files in the order of their names. Of three or more at once the last is held out, if none is yet and no name says so.
export async function take(files) {
  const list = [...files].sort((a, b) => a.name.localeCompare(b.name, undefined, { numeric: true }));
  const recordings = list.filter((file) => !file.name.endsWith(".toml"));
  const held = view.state.files.some((one) => one.role === "verify") || recordings.some((file) => HELD_OUT.test(file.name));
  for (const file of list) {
    const last = recordings.length > 2 && !held && file === recordings.at(-1) && view.state.files.length === 0;
    say(`sending ${file.name}`);
    await upload(file, HELD_OUT.test(file.name) || last ? "verify" : "fit");
  }
}

export function picker(text, testid) {
  const input = h("input", { type: "file", multiple: true, id: testid, "data-testid": testid, class: "file" });
  input.addEventListener("change", () => doing(take(input.files).then(() => (input.value = ""))));
  return h("label", { class: "pick", for: testid }, text, input);
}

export function drawStart() {
  const place = document.getElementById("start");
  fill(place,
    h("h1", { id: "start-title" }, "Which physical effect is your model missing?"),
    h("p", { class: "lead" }, "Compare a model with measured torques, see where it fails, learn what is missing, add it, and watch the error fall on motion the model has never seen."),
    h("div", { class: "drop", "data-testid": "drop" },
      h("p", { class: "big" }, "Drop recordings here"),
      h("p", { class: "faint" }, "tables with time, angles and torques: CSV, MAT, HDF5, Parquet, NPZ, spreadsheets, ROS bags. They stay on this machine."),
      picker("Choose files …", "pick-files"),
    ),
    h("p", { class: "or" }, "or ", button("Begin with the demo", () => doing(tell("demo")), { "data-testid": "demo", class: "primary" }),
      " four recordings of a leg with something hidden in it"),
  );
}

export function catchDrops() {
  const page = document.body;
  let depth = 0;
  const over = (on) => page.classList.toggle("dropping", on);
  page.addEventListener("dragenter", (event) => {
    event.preventDefault();
    depth += 1;
    over(true);
  });
  page.addEventListener("dragover", (event) => event.preventDefault());
  page.addEventListener("dragleave", () => {
    depth -= 1;
    if (depth <= 0) over(false);
  });
  page.addEventListener("drop", (event) => {
    event.preventDefault();
    depth = 0;
    over(false);
    if (event.dataTransfer.files.length) doing(take(event.dataTransfer.files));
  });
}
