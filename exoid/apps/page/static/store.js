// What this tab looks at: the server's state, and its own view of it (cursor, range, selection, pointed suspect).

import { ask, numbers, saw } from "./api.js";

export const view = {
  state: null, recording: null, cursor: null, range: null, selection: null, pointed: null, preview: null, explained: null,
};

const listeners = new Map();

export function on(what, listener) {
  if (!listeners.has(what)) listeners.set(what, []);
  listeners.get(what).push(listener);
}

export function emit(what) {
  for (const listener of listeners.get(what) || []) listener();
}

// A change of the view: the listeners of each key that differs are called, once.
export function look(changes) {
  const changed = Object.keys(changes).filter((key) => view[key] !== changes[key]);
  Object.assign(view, changes);
  for (const key of changed) emit(key);
}

const motions = new Map();
const errors = new Map();
let opened = "";

// What stays while the same recordings are open: kept until they change.
export function forget(key) {
  if (key === opened) return;
  opened = key;
  motions.clear();
  errors.clear();
  look({ selection: null, preview: null, pointed: null, explained: null, cursor: null, range: null });
}

function kept(store, key, load) {
  if (!store.has(key)) {
    const promise = load().catch((error) => {
      store.delete(key);
      throw error;
    });
    store.set(key, promise);
  }
  return store.get(key);
}

export function motion(recording) {
  return kept(motions, recording, () => numbers("/api/motion", { recording }));
}

export function error(recording, key) {
  for (const old of errors.keys()) if (!old.endsWith(`|${key}`)) errors.delete(old);
  return kept(errors, `${recording}|${key}`, () => numbers("/api/error", { recording, key }));
}

export async function refresh() {
  const state = await ask("/api/state");
  saw(state.edits);
  look({ state });
}
