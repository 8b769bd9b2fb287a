// Requests to the local server. A refusal becomes an Error that carries what, where and remedy.

const token = new URLSearchParams(location.search).get("token");
const page = crypto.randomUUID(); // which of several pages on one session this is
let seen = 0; // how many steps it has seen made
const headers = token ? { "X-Exoid-Token": token } : {};

export class Refused extends Error {
  constructor(problem) {
    super(problem.what);
    Object.assign(this, problem);
  }
}

async function answered(response) {
  if (response.ok && !(response.headers.get("content-type") || "").includes("json")) return response;
  if (response.ok) {
    const answer = await response.json();
    if (answer.refused) throw new Refused(answer.refused);
    return { json: () => answer };
  }
  let problem = { what: `the server answers with status ${response.status}`, where: "", remedy: "" };
  if ((response.headers.get("content-type") || "").includes("json")) problem = await response.json();
  else problem.what = (await response.text()).trim() || problem.what;
  throw new Refused(problem);
}

async function request(path, options = {}) {
  let response;
  try {
    response = await fetch(path, { ...options, headers: { ...headers, ...options.headers } });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Refused({ what: "exoid does not answer", where: "", remedy: "is exoid open still running in its terminal?" });
  }
  return answered(response);
}

export function url(path, query = {}) {
  return `${path}?${new URLSearchParams({ ...query, ...(token ? { token } : {}) })}`;
}

export async function ask(path, query, signal) {
  return (await request(url(path, query), { signal })).json();
}

export function saw(edits) {
  seen = edits;
}

export async function tell(action, message = {}, signal) {
  const body = JSON.stringify({ ...message, page, seen });
  const response = await request(`/api/${action}`, { method: "POST", body, signal, headers: { "Content-Type": "application/json" } });
  return response.json();
}

// {id} of a recording; nothing of a model, or of a file of a folder that is none.
export async function upload(file, role, inFolder) {
  const answer = await request(url("/api/file", { name: file.name, role, ...(inFolder && { folder: "" }) }), { method: "PUT", body: file });
  return answer.json();
}

export async function uploadSession(drop, name, file) {
  await request(url("/api/session", { drop, name }), { method: "PUT", body: file });
}

// Fetches what takes a moment to make, and hands it to the browser to keep.
export async function download(path, query, name) {
  const content = await (await request(url(path, query))).blob();
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

// {head, arrays}: every array is a list of Float32Array, one per joint.
export async function numbers(path, query, signal) {
  const buffer = await (await request(url(path, query), { signal })).arrayBuffer();
  const size = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  const arrays = {};
  for (const [name, { offset, shape }] of Object.entries(head.arrays)) {
    const [joints, count] = shape;
    arrays[name] = Array.from({ length: joints }, (_, j) => new Float32Array(buffer, 4 + size + 4 * (offset + j * count), count));
  }
  return { head, arrays };
}

// Calls `changed` whenever the workspace has a new version; a hidden tab holds no connection.
export function follow(changed, lost) {
  let source = null;
  const open = () => {
    if (source || document.hidden) return;
    source = new EventSource(url("/api/events"));
    source.onmessage = (event) => changed(Number(event.data));
    source.onerror = () => lost();
  };
  const close = () => {
    if (source) source.close();
    source = null;
  };
  document.addEventListener("visibilitychange", () => (document.hidden ? close() : open()));
  addEventListener("pagehide", close);
  addEventListener("pageshow", open);
  open();
}
