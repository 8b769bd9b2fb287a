// The machine in its posture at one instant, drawn from its joints; the load on each joint as the width of its ring.

import { fill, svg } from "../dom.js";
import { view } from "../store.js";

export function drawPosture(place, motion, k) {
  if (!place) return;
  const { joints } = view.state;
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

function words(motion, k) {
  return view.state.joints.map((joint, j) => `${joint.name} at ${motion.arrays.angle[j][k].toFixed(2)} ${joint.kind === "revolute" ? "rad" : "m"}`).join(", ");
}
