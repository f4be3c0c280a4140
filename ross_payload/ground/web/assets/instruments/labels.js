/** Labels on an ellipse around the compass, moved apart so that none covers another; their order stays. */

import { cosine, sine } from "./geometry.js";

const ROUNDS = 12; // how far apart two must be depends on where they are: try again
const RADIAN = Math.PI / 180;

/**
 * @param {{angle: number, width: number, height: number}[]} labels
 * @param {{x: number, y: number}} radii of the ellipse
 * @returns {number[]} angles, as near to the wanted ones as the others leave room
 */
export function spread(labels, radii) {
  const order = inOrder(labels);
  const boxes = order.map(({ index }) => labels[index]);
  const wanted = order.map(({ angle }) => angle);
  let angles = wanted;
  let gaps = boxes.slice(1).map(() => 0);
  for (let round = 0; round < ROUNDS; round++) {
    gaps = gaps.map((gap, place) => (gap + apart(angles, boxes, place, radii)) / (round ? 2 : 1));
    angles = pushed(wanted, gaps);
  }
  const placed = [];
  order.forEach(({ index }, place) => (placed[index] = angles[place]));
  return placed;
}

/** Labels along the circle, from the end of its emptiest part; angles go on beyond 360. */
function inOrder(labels) {
  const sorted = labels.map(({ angle }, index) => ({ angle, index })).sort((a, b) => a.angle - b.angle);
  const gapBefore = (place) => sorted[place].angle - (sorted[place - 1]?.angle ?? sorted.at(-1).angle - 360);
  const start = sorted.reduce((best, _, place) => (gapBefore(place) > gapBefore(best) ? place : best), 0);
  return [...sorted.slice(start), ...sorted.slice(0, start).map((each) => ({ ...each, angle: each.angle + 360 }))];
}

/** How far apart a label and the next one must be, in degrees, around where they are. */
function apart(angles, boxes, place, radii) {
  const middle = (angles[place] + angles[place + 1]) / 2;
  const [one, other] = [boxes[place], boxes[place + 1]];
  const across = (one.width + other.width) / 2 / (radii.x * Math.abs(cosine(middle)) + 1e-6);
  const down = (one.height + other.height) / 2 / (radii.y * Math.abs(sine(middle)) + 1e-6);
  return Math.min(across, down, 1) / RADIAN;
}

/** The nearest places (least squares) that keep the gaps: those that would meet move as one block. */
function pushed(wanted, gaps) {
  const offsets = wanted.map((_, place) => gaps.slice(0, place).reduce((sum, gap) => sum + gap, 0));
  const blocks = [];
  wanted.forEach((angle, place) => {
    blocks.push({ mean: angle - offsets[place], size: 1 });
    while (blocks.length > 1 && blocks.at(-2).mean > blocks.at(-1).mean)
      blocks.push(joined(blocks.pop(), blocks.pop()));
  });
  return blocks.flatMap(({ mean, size }) => Array(size).fill(mean)).map((mean, place) => mean + offsets[place]);
}

function joined(one, other) {
  const size = one.size + other.size;
  return { mean: (one.mean * one.size + other.mean * other.size) / size, size };
}
