/** What does not hear: the compass, the vehicle, and where the axis cannot go. Drawn around (0, 0). */

import { nothing, svg } from "../templates.js";
import { known } from "../formatting.js";
import { band, beyond, line, point } from "./geometry.js";

export const RIM = 150; // radius of the compass
const EVERY = 10; // degrees between two ticks
const NAMED = 30; // degrees between two that are named
const CARDINAL = { 0: "N", 90: "E", 180: "S", 270: "W" };

/** The compass: north or the payload's nose is up. @param {boolean} earth */
export function compass(earth) {
  const ticks = Array.from({ length: 360 / EVERY }, (_, index) => index * EVERY);
  const path = ticks
    .map((angle) => line([point(angle, angle % NAMED ? RIM - 5 : RIM - 9), point(angle, RIM)]))
    .join("");
  const rings = [RIM / 3, (2 * RIM) / 3].map((radius) => svg`<circle class="grid" r=${radius}></circle>`);
  return svg`<g class="compass" aria-hidden="true">
    <circle class="rim" r=${RIM}></circle>${rings}<path class="ticks" d=${path}></path>
    ${ticks.filter((angle) => angle % NAMED === 0).map((angle) => label(angle, earth))}</g>`;
}

function label(angle, earth) {
  const [x, y] = point(angle, RIM - 21);
  const cardinal = earth ? CARDINAL[angle] : undefined;
  const kind = cardinal || angle === 0 ? "degree main" : "degree";
  return svg`<text class=${kind} x=${x} y=${y}>${cardinal ?? angle}</text>`;
}

/** The vehicle from above, its nose where the mount points; in the mount's frame that is up. */
export function vehicle({ earth, mount_yaw: yaw }) {
  const nose = earth ? yaw : 0;
  if (!known(nose)) return nothing;
  return svg`<g class="vehicle" aria-hidden="true" transform="rotate(${nose})">
    <path d="M0 -46L15 -28V34H-15V-28Z"></path><path class="nose" d="M0 -46L10 -34H-10Z"></path>
    <title>the vehicle from above</title></g>`;
}

/**
 * Limits of travel: hatched where microphone 2 cannot point, filled where no turn brings the axis at all, because the
 * opposite heading is out of reach as well.
 */
export function limits({ limits: ends }) {
  const out = beyond(ends, false).map((arc) => svg`<path class="beyond" d=${band(...arc, RIM - 2, RIM + 7)}></path>`);
  const never = beyond(ends, true).map((arc) => svg`<path class="never" d=${band(...arc, RIM * 0.5, RIM - 2)}></path>`);
  return svg`<g class="limits" aria-hidden="true">${never}${out}${(ends ?? []).map(stop)}</g>`;
}

const stop = (angle) => svg`<path class="stop" d=${line([point(angle, RIM - 10), point(angle, RIM + 10)])}></path>`;

/** Hatching for the limits, once per drawing. */
export const hatching = (id) => svg`<pattern id=${id} width="5" height="5" patternUnits="userSpaceOnUse"
  patternTransform="rotate(45)"><path class="hatch" d="M0 0V5"></path></pattern>`;
