// The machine in its posture at one instant, drawn from its joints, in a plane or seen from aside and above in space; the
// load on each joint as the width of its ring.

import { fill, svg } from "../dom.js";
import { view } from "../store.js";

export function drawPosture(place, motion, k) {
  if (!place) return;
  const { joints } = view.state;
  if (joints.some((joint) => joint.space)) {
    fill(place, inSpace(joints, motion, k));
    return;
  }
  const ends = [], turned = [];
  let reach = 0;
  joints.forEach((joint, j) => {
    const from = joint.parent === null ? [0, 0] : ends[joint.parent];
    const before = joint.parent === null ? 0 : turned[joint.parent];
    const q = motion.arrays.angle[j][k];
    const angle = joint.kind === "revolute" ? before + q : before;
    const length = joint.kind === "revolute" ? joint.length : joint.length + q;
    turned.push(angle);
    ends.push([from[0] + length * Math.sin(angle), from[1] + length * Math.cos(angle)]);
    reach += Math.abs(joint.length) * (joint.parent === null || joint.parent === j - 1 ? 1 : 0);
  });
  const size = Math.max(reach, 0.1) * 1.15;
  const picture = svg("svg", { viewBox: `${-size} ${-size * 0.35} ${2 * size} ${size * 1.6}`, class: "leg", role: "img", "aria-label": words(motion, k) });
  picture.append(svg("line", { x1: -0.2 * size, x2: 0.2 * size, y1: 0, y2: 0, class: "ground" }));
  joints.forEach((joint, j) => {
    const from = joint.parent === null ? [0, 0] : ends[joint.parent];
    picture.append(svg("line", { x1: from[0], y1: from[1], x2: ends[j][0], y2: ends[j][1], class: `link joint-${j}`, "stroke-width": size * 0.045 }));
  });
  joints.forEach((joint, j) => {
    const from = joint.parent === null ? [0, 0] : ends[joint.parent];
    picture.append(svg("circle", { cx: from[0], cy: from[1], r: size * 0.045, class: `hinge joint-${j}`, "stroke-width": size * 0.02 }));
  });
  fill(place, picture);
}

const TIP = 0.12; // of the reach: what is drawn beyond a last joint, along its axis
const [AROUND, ABOVE] = [0.6, 0.35]; // rad, of who looks at it

function inSpace(joints, motion, k) {
  const frames = [];
  let reach = 0.05;
  joints.forEach((joint, j) => {
    const above = joint.parent === null ? { turned: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], place: [0, 0, 0] } : frames[joint.parent];
    const q = motion.arrays.angle[j][k], { turned, place, axis } = joint.space;
    const own = product(above.turned, turned);
    const slid = joint.kind === "revolute" ? place : plus(place, times(turned, axis.map((a) => a * q)));
    frames.push({ place: plus(above.place, times(above.turned, slid)), turned: joint.kind === "revolute" ? product(own, about(axis, q)) : own, axis: times(own, axis) });
    reach += Math.hypot(...place);
  });
  const size = reach * 1.25, seen = frames.map((frame) => projected(frame.place)), base = projected([0, 0, 0]);
  const picture = svg("svg", { viewBox: `${-size} ${-size} ${2 * size} ${1.6 * size}`, class: "leg", role: "img", "aria-label": words(motion, k) });
  picture.append(svg("line", { x1: -0.2 * size, x2: 0.2 * size, y1: 0, y2: 0, class: "ground" }));
  joints.forEach((joint, j) => {
    const from = joint.parent === null ? base : seen[joint.parent];
    const parts = [[from, seen[j]]];
    if (!joints.some((other) => other.parent === j)) parts.push([seen[j], projected(plus(frames[j].place, frames[j].axis.map((a) => a * TIP * reach)))]);
    parts.forEach(([a, b]) => picture.append(svg("line", { x1: a[0], y1: a[1], x2: b[0], y2: b[1], class: `link joint-${j}`, "stroke-width": size * 0.045 })));
  });
  joints.forEach((_, j) => picture.append(svg("circle", { cx: seen[j][0], cy: seen[j][1], r: size * 0.045, class: `hinge joint-${j}`, "stroke-width": size * 0.02 })));
  return picture;
}

function projected([x, y, z]) {
  const right = Math.cos(AROUND) * y - Math.sin(AROUND) * x, towards = Math.cos(AROUND) * x + Math.sin(AROUND) * y;
  return [right, Math.sin(ABOVE) * towards - Math.cos(ABOVE) * z];
}

function about([x, y, z], q) {
  const [s, c] = [Math.sin(q), Math.cos(q)], d = 1 - c;
  return [[c + d * x * x, d * x * y - s * z, d * x * z + s * y], [d * x * y + s * z, c + d * y * y, d * y * z - s * x], [d * x * z - s * y, d * y * z + s * x, c + d * z * z]];
}

const plus = (a, b) => a.map((value, i) => value + b[i]);
const times = (rows, a) => rows.map((row) => row[0] * a[0] + row[1] * a[1] + row[2] * a[2]);
const product = (a, b) => a.map((row) => [0, 1, 2].map((j) => row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]));

function words(motion, k) {
  return view.state.joints.map((joint, j) => `${joint.name} at ${motion.arrays.angle[j][k].toFixed(2)} ${joint.kind === "revolute" ? "rad" : "m"}`).join(", ");
}
