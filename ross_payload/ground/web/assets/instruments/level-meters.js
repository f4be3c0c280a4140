/** Levels of the microphones as bars. */

import { html, nothing, svg } from "../templates.js";
import { known, number } from "../formatting.js";
import { round } from "./geometry.js";
import { told } from "./phrases.js";

const QUIET = -72; // dB at the left end of a bar

/** How far a bar reaches [%]. @param {number} db re full scale */
const shareOf = (db) => round(Math.min(Math.max((100 * (db - QUIET)) / -QUIET, 0), 100));

/** Both microphones: level as a bar, peak as a line. @param {{level_db?: number[], peak_db?: number[]}} microphones */
export function levels({ level_db: level = [null, null], peak_db: peak = [null, null] }) {
  return html`<div class="instrument levels">${level.map((db, index) => bar(`microphone ${index + 1}`, db, peak[index]))}</div>`;
}

/** One level with its peak. @param {?number} level [dB re full scale] @param {?number} peak */
export const levelBar = (name, level, peak) =>
  html`<div class="instrument levels">${bar(name, level, peak)}</div>`;

function bar(name, level, peak) {
  const words = `${number(level, 0, " dB")}, peak ${number(peak, 0, " dB")}`;
  return html`<div class="bar" role="meter" aria-label=${name} aria-valuemin=${QUIET}
    aria-valuemax="0" aria-valuenow=${known(level) ? Math.round(level) : QUIET}
    aria-valuetext=${known(level) ? words : "unknown"}>
    <span>${name}</span><span class="value">${known(level) ? words : told(number(null))}</span>
    <svg viewBox="0 0 100 1" preserveAspectRatio="none" aria-hidden="true">
      <rect class="trough" width="100" height="1"></rect>
      ${known(level) ? svg`<rect class="level" width=${shareOf(level)} height="1"></rect>` : nothing}
      ${known(peak) ? svg`<path class="peak" d="M${shareOf(peak)} 0V1"></path>` : nothing}</svg></div>`;
}
