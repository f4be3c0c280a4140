/**
 * Sources differ by colour, shape and number, never by colour alone. Eight colours and shapes; after eight the same
 * ones hollow, then with a dot, then hollow with a dot: 32 in all. The colours themselves are in instruments.css.
 */

import { html, svg } from "../templates.js";

const COLOURS = 8;
const PATTERNS = 4;

const SHAPES = [
  "M-7 0A7 7 0 1 1 7 0A7 7 0 1 1 -7 0Z", // circle
  "M-6.2 -6.2H6.2V6.2H-6.2Z", // square
  "M0 -8.2L7.6 5.8H-7.6Z", // triangle
  "M0 -8.8L8.8 0L0 8.8L-8.8 0Z", // diamond
  "M0 8.2L7.6 -5.8H-7.6Z", // triangle, point down
  "M-2.8 -8H2.8V-2.8H8V2.8H2.8V8H-2.8V2.8H-8V-2.8H-2.8Z", // cross
  "M0 -8.2L7.8 -2.5L4.8 6.6H-4.8L-7.8 -2.5Z", // pentagon
  "M0 -9L2.3 -3L8.6 -2.8L3.7 1.2L5.3 7.3L0 3.8L-5.3 7.3L-3.7 1.2L-8.6 -2.8L-2.3 -3Z", // star
];

/** The classes that colour a source. @param {number} index */
export const lookOf = (index) => `s${index % COLOURS} p${Math.floor(index / COLOURS) % PATTERNS}`;

/** The outline of a source's shape around (0, 0), about 16 units wide. @param {number} index */
const shapeOf = (index) => SHAPES[index % SHAPES.length];

/** A source's shape at a place in an SVG. */
export function mark(index, [x, y]) {
  const dotted = Math.floor(index / COLOURS) % PATTERNS > 1;
  return svg`<g class="mark ${lookOf(index)}" transform="translate(${x} ${y})">
    <path d=${shapeOf(index)}></path>${dotted ? svg`<circle class="dot" r="2.6"></circle>` : ""}</g>`;
}

/** A source's shape for tables and texts. */
export function glyph(index) {
  return html`<svg class="glyph" viewBox="-10 -10 20 20" aria-hidden="true">${mark(index, [0, 0])}</svg>`;
}
