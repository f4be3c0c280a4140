/** What the instruments say. What is not known is an en dash that says so. */

import { html, svg } from "../templates.js";
import { DASH, degrees, known, number, plural } from "../formatting.js";

/** Both directions of an axis. */
export const axisWords = (angle) => (known(angle) ? `${degrees(angle)} / ${degrees(angle + 180)}` : DASH);

/** A direction for a screen reader. */
const spoken = (angle) => `${degrees(angle).replace("°", "")} degrees`;

/** A text in HTML; an unknown one explains itself. */
export const told = (text) => (text === DASH ? html`<span title="unknown">${DASH}</span>` : text);

/** A text in SVG; an unknown one explains itself. */
export const drawn = (text) => (text === DASH ? svg`<tspan>${DASH}<title>unknown</title></tspan>` : text);

/** A word of the protocol, for people. @param {string|null} word */
export const plain = (word) => (word ? word.replaceAll("_", " ") : DASH);

/** A source, in words for a screen reader. */
export function sourceWords(source) {
  const doubt = known(source.mirror)
    ? `or ${spoken(source.mirror)}: front or back unknown`
    : "front or back unknown";
  return [
    `source ${source.source}`,
    spoken(source.azimuth),
    known(source.sigma) && `plus or minus ${number(source.sigma)}`,
    !source.resolved && doubt,
    known(source.confidence) && `confidence ${number(source.confidence * 100)} percent`,
    source.target && "target",
  ]
    .filter(Boolean)
    .join(", ");
}

/** The sources, briefly: changes only with their number and the target. */
export function sceneWords(mission, sources) {
  const k = mission.k ?? sources.length;
  const target = sources.find((source) => source.target);
  if (!k) return mission.k === 0 ? "no sources" : "no sources yet";
  return `${plural(k, "source")}, ${target ? `target: source ${target.source}` : "no target yet"}`;
}

/** An axis for a screen reader: where it is dragged, and whether it gets there. */
export function dragWords(heading, held, far) {
  return `${spoken(heading)}${held ? ", press Enter to turn, Escape to cancel" : ""}${far ? ", out of range" : ""}`;
}
