/**
 * The live polar view: what the payload hears, around its axis. Up is north, or the payload's nose.
 * Two microphones have no front: the axis, the candidates and the limits are drawn both ways.
 */

import { guard, html, nothing, svg } from "../templates.js";
import { degrees, known, number, plural } from "../formatting.js";
import { axisWords, drawn, sceneWords } from "./phrases.js";
import { axis, ends, ghost, handle, isBeyond, microphones } from "./scope-axis.js";
import { candidates, difference, differenceWords, posing, posingWords } from "./scope-plan.js";
import { compass, hatching, limits, vehicle } from "./scope-ring.js";
import { sourcesOf } from "./scope-sources.js";

const OLD = 3; // seconds without a word after which all that is shown is old
const GONE = 30; // seconds after which it is as faded as it gets
const NO_FRAME = { earth: false, heading: null, goal: null, limits: null };

/**
 * @param {object} state
 * @param {object} state.sections of one payload, as in ross_payload/ground/model/view.py
 * @param {number|null} state.now seconds on the same clock as its times
 * @param {number|null} state.selected number of a source
 * @param {number|null} state.hovered number of a source
 * @param {number|null} state.drag heading to which the axis is dragged just now
 * @param {boolean} state.mayOrder
 * @param {(source: number) => void} state.onSelect
 * @param {(heading: number) => void} state.onTurn
 * @param {(heading: number) => void} state.onChoose a finger has dragged it there: ask before it turns
 * @param {(heading: number|null) => void} state.onDrag
 * @param {(source: number|null) => void} state.onHover may be called while drawing, when a source that has
 *   the focus goes: draw again later, not in the call
 */
export function scope(state) {
  const { sections, selected = null, drag = null } = state;
  const pointing = sections.pointing ?? NO_FRAME;
  const sources = sections.sources ?? [];
  const chosen = sources.find((each) => each.source === selected);
  const words = sceneWords(sections.mission ?? {}, sources);
  return html`<figure class="instrument scope">
    <svg viewBox="-200 -222 400 466" role="group" aria-label="polar view, ${frameWords(pointing)}">
      <defs>${hatching("scope-hatch")}</defs>
      ${guard([pointing.earth], () => compass(pointing.earth))}${vehicle(pointing)}${limits(pointing)}
      <g class=${ageOf(sections, state.now)}>
        ${posing(sections.plan, sources)}${candidates(sections.plan)}${axis(pointing.heading)}
        ${ghost(pointing.settled === false ? pointing.goal : null, "goal")}
        ${ends({ ...state, heading: pointing.heading, drag })}
        ${sourcesOf({ ...state, sources, selected })}${difference(chosen, pointing.heading)}
        ${microphones(pointing.heading)}
      </g>
      ${ghost(drag, dragKind(drag, pointing))}
      ${handle({ ...state, heading: pointing.heading, drag, limits: pointing.limits })}
      ${corners({ ...state, pointing, sources, chosen })}
    </svg>
    <p class="unseen" aria-live="polite">${words}</p>
  </figure>`;
}

const frameWords = ({ earth }) => (earth ? "north up" : "nose up");

const dragKind = (drag, pointing) => (isBeyond(drag, pointing.limits) ? "drag far" : "drag");

/** How old what is shown is: sources fade while nothing is heard. */
function ageOf(sections, now) {
  const age = now - sections.standing?.last;
  if (!(age > OLD)) return "scene";
  return age > GONE ? "scene gone" : "scene old";
}

/** Short texts in the corners. */
function corners({ sections, now, drag, pointing, sources, chosen }) {
  return svg`<g class="corners">
    <text x="-198" y="-207">${frameWords(pointing)}</text>
    <text class="end" x="198" y="-207">${turning(drag, pointing)}</text>
    <text x="-198" y="217">${doubts(sections, now, sources)}</text>
    <text class="end" x="198" y="217">${
      chosen && known(pointing.heading)
        ? differenceWords(chosen, pointing.heading, sections.densities)
        : marked(sources)
    }</text>
    <text x="-198" y="238">${posingWords(sections.plan, sources)}</text></g>`;
}

function turning(drag, { heading, goal, settled, limits: ends }) {
  if (known(drag)) return `${isBeyond(drag, ends) ? "out of range:" : "turn to"} ${degrees(drag)}`;
  if (known(goal) && settled === false) return `turning to ${degrees(goal)}`;
  return svg`axis ${drawn(axisWords(heading))}`;
}

/** What must be said of the sources before anything else. */
function doubts(sections, now, sources) {
  const age = now - sections.standing?.last;
  if (age > OLD) return `no telemetry for ${number(age)} s`;
  if (!sources.length) return missing(sections.mission?.k);
  return sources.every((each) => each.resolved) ? plural(sources.length, "source") : "? front or back unknown";
}

const missing = (k) =>
  k ? `${plural(k, "source")}, azimuths unknown` : k === 0 ? "no sources" : "no sources yet";

function marked(sources) {
  const target = sources.find((each) => each.target);
  return target ? `target ${target.source}` : nothing;
}
