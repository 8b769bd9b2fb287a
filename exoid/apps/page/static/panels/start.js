// The first screen: drop files or a saved session, pick them, or begin with the demo.

import { ask, tell, upload, uploadSession } from "../api.js";
import { button, fill, h } from "../dom.js";
import { view } from "../store.js";
import { doing, say } from "./status.js";

const HELD_OUT = /^(verify|validation|valid|test|held|hold)/i;

const endsIn = (file, ends) => ends.some((end) => file.name.toLowerCase().endsWith(end));
const isModel = (file) => endsIn(file, view.state.model_suffixes); // or what exoid map kept

// What it is about first, then recordings in the order of their names. Of three or more at once the last is held out, if
// none is yet and no name says so. Of a folder, what is no recording is passed over, and said.
export async function take(files, inFolder = false) {
  const known = (file) => !inFolder || isModel(file) || endsIn(file, view.state.suffixes);
  const seen = [...files].filter((file) => !file.name.startsWith("."));
  const list = seen.filter(known).sort((a, b) => isModel(b) - isModel(a) || a.name.localeCompare(b.name, undefined, { numeric: true }));
  const others = seen.filter((file) => !known(file)).map((file) => file.name);
  const held = view.state.files.some((one) => one.role === "verify") || list.some((file) => HELD_OUT.test(file.name));
  const first = view.state.files.length === 0; // before the first of these is there
  const taken = [];
  for (const file of list) {
    say(`sending ${file.name}`);
    const answer = await upload(file, HELD_OUT.test(file.name) ? "verify" : "fit", inFolder);
    if (answer.id) taken.push(answer.id);
  }
  if (!held && first) await tell("hold_out_last", { files: taken });
  if (others.length) await tell("left_out", { names: others });
  if (inFolder && !taken.length) throw new Error("the folder holds no recordings");
}

// Of a folder that exoid saved, all files of the session; of any other, the recordings in it.
async function takeTree(tree) {
  const saved = tree.find(({ path }) => path.split("/").at(-1) === "session.json");
  if (!saved) return take(tree.map(({ file }) => file), true);
  const root = saved.path.slice(0, -"session.json".length);
  const drop = Date.now() % 1e9;
  for (const { path, file } of tree.filter((one) => one.path.startsWith(root))) {
    say(`sending ${file.name}`);
    await uploadSession(drop, path.slice(root.length), file);
  }
  return tell("reopen", { drop });
}

export function picker(text, testid) {
  const input = h("input", { type: "file", multiple: true, id: testid, "data-testid": testid, class: "file" });
  input.addEventListener("change", () => doing(take(input.files).then(() => (input.value = ""))));
  return h("label", { class: "pick", for: testid }, text, input);
}

function pickFolder() {
  const input = h("input", { type: "file", webkitdirectory: true });
  input.addEventListener("change", () => doing(takeTree([...input.files].map((file) => ({ path: file.webkitRelativePath, file })))));
  input.click();
}

// Every file under what was dropped, with its path.
async function filesOf(entries, before = "") {
  const out = [];
  for (const entry of entries) {
    const path = before + entry.name;
    if (entry.isFile) out.push({ path, file: await new Promise((good, bad) => entry.file(good, bad)) });
    else out.push(...(await filesOf(await children(entry), `${path}/`)));
  }
  return out;
}

// A reader hands out a part of a folder at a time, and nothing when there is no more.
async function children(folder) {
  const reader = folder.createReader(), out = [];
  for (;;) {
    const part = await new Promise((good, bad) => reader.readEntries(good, bad));
    if (!part.length) return out;
    out.push(...part);
  }
}

export function drawStart() {
  const place = document.getElementById("start");
  const folder = h("input", { id: "session-folder", type: "text", "data-testid": "session-folder", placeholder: "exoid-session" });
  const reopen = (event) => {
    event.preventDefault();
    doing(tell("reopen", { folder: folder.value.trim() || folder.placeholder }));
  };
  fill(place,
    h("h1", { id: "start-title" }, "Which physical effect is your model missing?"),
    h("p", { class: "lead" }, "Compare a model with measured torques, see where it fails, learn what is missing, add it, and watch the error fall on motion the model has never seen."),
    h("div", { class: "drop", "data-testid": "drop" },
      h("p", { class: "big" }, "Drop recordings here"),
      h("p", { class: "faint" }, "tables with time, angles and torques: CSV, JSON, MAT, HDF5, Parquet, NPZ, spreadsheets, ROS bags. They stay on this machine."),
      h("div", { class: "or" }, button("Open your recordings", pickFolder, { "data-testid": "pick-folder", class: "primary", title: "choose their folder" }), picker("or single files …", "pick-files")),
    ),
    h("p", { class: "or" }, "or ", button("Begin with the demo", () => doing(tell("demo")), { "data-testid": "demo" }),
      " four recordings of a leg with something hidden in it"),
    h("div", { id: "recent" }),
    h("form", { class: "or", onsubmit: reopen, "aria-label": "a saved session" },
      "or go on with a saved session: drop its folder, ", button("choose it …", pickFolder, { "data-testid": "pick-session" }), h("label", { for: "session-folder" }, "or name it ", folder),
      h("button", { type: "submit", "data-testid": "open-session" }, "Open")),
  );
  doing(drawRecent());
}

// Sessions that were opened or saved last on this machine.
async function drawRecent() {
  const { folders } = await ask("/api/recent");
  const place = document.getElementById("recent");
  if (!place || !folders.length) return;
  const open = (folder) => button([h("strong", {}, folder.split(/[\\/]/).at(-1)), " ", h("span", { class: "faint" }, folder)], () => doing(tell("reopen", { folder })), { class: "recent" });
  fill(place, h("h2", {}, "Recent sessions"), h("ul", { class: "recent-list", "data-testid": "recent" }, folders.map((folder) => h("li", {}, open(folder)))),
    button("Forget them", () => doing(tell("forget").then(() => place.replaceChildren())), { "data-testid": "forget" }));
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
    const entries = [...event.dataTransfer.items].map((item) => item.webkitGetAsEntry && item.webkitGetAsEntry()).filter(Boolean);
    if (entries.some((entry) => entry.isDirectory)) doing(filesOf(entries).then(takeTree));
    else if (event.dataTransfer.files.length) doing(take(event.dataTransfer.files));
  });
}
