// What goes on, and what went wrong, in words.

import { button, fill, h } from "../dom.js";

export function say(text) {
  const place = document.getElementById("status");
  if (place.textContent !== text) place.textContent = text;
}

export function problem(error, close = true) {
  const place = document.getElementById("problem");
  fill(place, !error ? [] : h("div", { class: "finding refused" },
    h("p", {}, error.where ? `${error.where}: ` : "", error.what || String(error.message || error)),
    error.remedy && h("p", { class: "remedy" }, error.remedy),
    close && button("close", () => problem(null)),
  ));
}

// Shows why something was refused, and otherwise nothing.
export async function doing(promise) {
  try {
    const done = await promise;
    return done;
  } catch (error) {
    problem(error);
    return null;
  }
}
