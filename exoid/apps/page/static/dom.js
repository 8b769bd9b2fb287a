// Elements of the page. Text only ever becomes a text node: names of files and effects are never markup.

export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  set(element, attributes);
  element.append(...shown(children));
  return element;
}

export function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) element.removeAttribute(name);
    else if (name.startsWith("on")) answer(element, name.slice(2), value);
    else if (name === "value" || name === "disabled" || name === "checked" || name === "hidden") element[name] = value;
    else element.setAttribute(name, value === true ? "" : value);
  }
  return element;
}

const answers = new WeakMap();

// Calls `action` on events of a type, one action per type: `refill` gives an element that stays its new one.
function answer(element, type, action) {
  if (!answers.has(element)) answers.set(element, {});
  const known = answers.get(element);
  if (!(type in known)) element.addEventListener(type, (event) => known[type](event));
  known[type] = action;
}

export function svg(tag, attributes = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

const shown = (children) => children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false);

// Puts `children` into `parent`, but keeps the keyboard focus on the control with the same data-testid or id.
export function fill(parent, ...children) {
  const focused = parent.contains(document.activeElement) ? document.activeElement : null;
  const key = focused && (focused.dataset.testid || focused.id);
  parent.replaceChildren(...shown(children));
  if (key) {
    const again = [...parent.querySelectorAll("[data-testid],[id]")].find((e) => (e.dataset.testid || e.id) === key);
    if (again) again.focus({ preventScroll: true });
  }
}

// Makes what is in `parent` look like `children`, and keeps every element that still fits: a control that is drawn again
// while it is pressed keeps the click, and the focus. Not for elements that their maker holds on to.
export function refill(parent, ...children) {
  const wanted = shown(children).map((child) => (child instanceof Node ? child : document.createTextNode(child)));
  const old = [...parent.childNodes];
  const named = new Map(old.filter(keyOf).map((node) => [keyOf(node), node]));
  wanted.forEach((node, place) => {
    const here = parent.childNodes[place];
    const now = keyOf(node) ? named.get(keyOf(node)) : here && !keyOf(here) ? here : null;
    const fits = now && now.nodeType === node.nodeType && now.nodeName === node.nodeName;
    if (fits) become(now, node);
    const kept = fits ? now : node;
    if (kept !== here) parent.insertBefore(kept, here || null);
  });
  while (parent.childNodes.length > wanted.length) parent.lastChild.remove();
}

const keyOf = (node) => (node.nodeType === Node.ELEMENT_NODE && (node.dataset.testid || node.id)) || "";

function become(now, node) {
  if (now.nodeType !== Node.ELEMENT_NODE) {
    if (now.data !== node.data) now.data = node.data;
    return;
  }
  // Whether details are open is the reader's, and style may only be set as a property (content security policy).
  const own = (name) => name === "open" || name === "style";
  for (const { name } of [...now.attributes]) if (!own(name) && !node.hasAttribute(name)) now.removeAttribute(name);
  for (const { name, value } of node.attributes) if (!own(name) && now.getAttribute(name) !== value) now.setAttribute(name, value);
  if (now.style.cssText !== node.style.cssText) now.style.cssText = node.style.cssText;
  for (const [type, action] of Object.entries(answers.get(node) || {})) answer(now, type, action);
  refill(now, [...node.childNodes]);
  for (const name of ["checked", "value"]) if (name in node && node.type !== "file" && now[name] !== node[name]) now[name] = node[name];
}

export function button(text, action, attributes = {}) {
  return h("button", { type: "button", onclick: action, ...attributes }, text);
}
