/**
 * Axes around a plot. Lines are drawn from 0 to 100 both ways and stretched to the container; marks and texts stand at
 * per cents and keep their size.
 */

import { html, svg } from "../templates.js";
import { round } from "./geometry.js";

/**
 * @typedef {object} Axis
 * @property {number} from
 * @property {number} to
 * @property {number[]} ticks
 * @property {(value: number) => string} format
 * @property {string} [title]
 */

/** From values to per cents of an axis. @param {{from: number, to: number}} axis */
export function scale({ from, to }) {
  const span = to - from || 1;
  return (value) => round((100 * (value - from)) / span);
}

const ROUND = [1, 2, 5, 10];
const MINUTES = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 1800, 3600, 7200, 21600];

/** Round numbers that divide a range into at most about `count` parts. */
export function ticksOf(from, to, count = 4) {
  const rough = (to - from || 1) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  return multiples(from, to, power * ROUND.find((each) => each * power >= rough * 0.999));
}

/** Round times [s] that divide a range into at most about `count` parts. */
export const timesOf = (from, to, count = 4) =>
  multiples(from, to, MINUTES.find((each) => each >= (to - from) / count) ?? to - from);

function multiples(from, to, step) {
  const first = Math.ceil(from / step - 1e-9);
  const last = Math.floor(to / step + 1e-9);
  return Array.from({ length: Math.max(last - first + 1, 0) }, (_, index) =>
    Number(((first + index) * step).toPrecision(12)),
  );
}

/**
 * @param {object} parts
 * @param {string} parts.kind class of the chart
 * @param {string} parts.label for those who cannot see it
 * @param {string} parts.height as in CSS
 * @param {Axis} parts.x
 * @param {Axis} parts.y upward
 * @param {unknown} parts.lines stretched, 0 to 100
 * @param {unknown} [parts.marks] at per cents
 */
export function chart({ kind, label, height, x, y, lines, marks = "" }) {
  const along = scale(x);
  const up = scale(y);
  const grid = [...x.ticks.map((at) => `M${along(at)} 0V100`), ...y.ticks.map((at) => `M0 ${100 - up(at)}H100`)];
  return html`<div class="chart ${kind}" role="img" aria-label=${label}>
    <svg class="side" height=${height}>${y.ticks.map(
      (at) => svg`<text x="100%" y="${100 - up(at)}%" dx="-6"
      dy=${shift(up(at))}>${y.format(at)}</text>`,
    )}</svg>
    <svg class="plot" height=${height}><svg viewBox="0 0 100 100" preserveAspectRatio="none" width="100%" height="100%">
      <path class="grid" d=${grid.join("")}></path>${lines}</svg>${marks}</svg>
    <svg class="foot" height="1.4em">${x.ticks.map(
      (at) => svg`<text class=${anchor(along(at))} x="${along(at)}%"
      y="1.05em">${x.format(at)}</text>`,
    )}</svg>
    ${x.title ? html`<p class="title">${x.title}</p>` : ""}</div>`;
}

/** Labels at the ends of an axis stay inside. */
const anchor = (share) => (share < 4 ? "first" : share > 96 ? "last" : "");
const shift = (share) => (share < 4 ? "0" : share > 96 ? "0.7em" : "0.35em");

/** A line through shares of the axes; holes (null) interrupt it. @param {([number, number]|null)[]} points */
export const curve = (points) =>
  points.map((each, index) => (each ? `${points[index - 1] ? "L" : "M"}${each[0]} ${each[1]}` : "")).join("");

/** What is said while there is nothing to draw. */
export const empty = (words) => html`<p class="instrument empty">${words}</p>`;
