/** The axis through both microphones, where it turns to, and the hand that drags it. Drawn around (0, 0). */

import { nothing, svg } from "../templates.js";
import { known } from "../formatting.js";
import { angleOf, line, point, turn, within, wrap } from "./geometry.js";
import { axisWords, dragWords } from "./phrases.js";
import { RIM } from "./scope-ring.js";

const MICROPHONE = 19; // distance of each microphone from the centre
const GRIP = 0.64 * RIM; // where the knobs are: on the rim they would lie on sources
const END = 22; // radius of an end of the axis that the pointer can take
const STEP = 1; // degrees per arrow key; with shift ten
const STILL = 1; // degrees that a drag must make to be an order

/** The axis both ways: nothing at either end tells front from back. */
export function axis(heading) {
  if (!known(heading)) return nothing;
  return svg`<path class="axis" aria-hidden="true" d=${line([point(heading, RIM), point(heading + 180, RIM)])}></path>`;
}

/** Both microphones on the axis; it points from the first to the second. */
export function microphones(heading) {
  if (!known(heading)) return nothing;
  return svg`<g class="microphones" aria-hidden="true">${microphone(1, heading + 180)}${microphone(2, heading)}</g>`;
}

function microphone(number, angle) {
  const [x, y] = point(angle, MICROPHONE);
  return svg`<g class="microphone" transform="translate(${x} ${y})"><circle r="11"></circle>
    <text>${number}</text></g>`;
}

/** Both ends of the axis, for the pointer alone: they lie under the sources, which are drawn later. */
export function ends({ heading, drag, mayOrder, onDrag, onTurn }) {
  if (!known(heading) || !mayOrder) return nothing;
  const hand = listeners({ heading, drag, onDrag, onTurn });
  const shown = known(drag) ? drag : heading;
  return svg`<g class=${known(drag) ? "ends held" : "ends"} aria-hidden="true"
    @pointerdown=${hand.down} @pointermove=${hand.move} @pointerup=${hand.up} @pointercancel=${hand.away}
    @touchstart=${hand.touch}>${[0, 180].map((end) => endOf(shown, end))}</g>`;
}

function endOf(heading, end) {
  const [x, y] = point(heading + end, RIM);
  return svg`<circle class="reach" data-end=${end} r=${END} cx=${x} cy=${y}></circle>`;
}

/** An axis that is not there yet: where it turns to, or where it is dragged. */
export function ghost(heading, kind) {
  if (!known(heading)) return nothing;
  return svg`<g class="ghost ${kind}" aria-hidden="true">
    <path d=${line([point(heading, RIM), point(heading + 180, RIM)])}></path>
    <path class="head" transform="rotate(${heading}) translate(0 ${-RIM})" d="M0 0L6 12H-6Z"></path></g>`;
}

/** Whether a heading is out of reach. */
export const isBeyond = (heading, limits) => Boolean(limits) && !within(heading, limits);

/**
 * The handle: a slider. Arrows turn it by one degree, with shift by ten, Enter orders, Escape gives up; the pointer
 * drags either end. `onDrag` hears where it is (null: let go), `onTurn` what was ordered.
 */
export function handle({ heading, drag, limits, mayOrder, onDrag, onTurn }) {
  if (!known(heading)) return nothing;
  const shown = known(drag) ? drag : heading;
  const hand = mayOrder ? listeners({ heading, drag, onDrag, onTurn }) : idle;
  const words = dragWords(shown, known(drag), isBeyond(shown, limits));
  return svg`<g class=${known(drag) ? "handle held" : "handle"} role="slider" tabindex=${mayOrder ? 0 : -1}
    aria-label="heading of the axis" aria-valuemin="0" aria-valuemax="359"
    aria-valuenow=${Math.round(wrap(shown)) % 360} aria-valuetext=${words} aria-disabled=${mayOrder ? "false" : "true"}
    @keydown=${hand.key}
    @pointerdown=${hand.down} @pointermove=${hand.move} @pointerup=${hand.up} @pointercancel=${hand.away}
    @touchstart=${hand.touch}>
    <title>axis ${axisWords(shown)}</title>${grip(shown, 0)}${grip(shown, 180)}</g>`;
}

function grip(heading, end) {
  const [x, y] = point(heading + end, GRIP);
  return svg`<g class="grip" data-end=${end} transform="translate(${x} ${y})"><circle class="reach" r="19"></circle>
    <circle class="knob" r="8.5"></circle></g>`;
}

const ignore = () => {};
const idle = { key: ignore, down: ignore, move: ignore, up: ignore, away: ignore, touch: ignore };

/** What the hand does. The pointer that holds the handle, and by which end, is kept on the element itself. */
function listeners({ heading, drag, onDrag, onTurn }) {
  const drop = (event) => (release(event.currentTarget), onDrag(null));
  const up = (event) => {
    const goal = goalOf(event);
    drop(event);
    if (Math.abs(turn(heading, goal)) >= STILL) onTurn(goal);
  };
  return {
    down: take,
    move: (event) => holds(event) && (event.buttons ? onDrag(goalOf(event)) : drop(event)), // its release may be lost
    up: (event) => holds(event) && up(event),
    away: drop,
    touch: (event) => event.preventDefault(), // else the page scrolls: touch-action does not work inside of an SVG
    key: (event) => pressed(event, { heading, drag, onDrag, onTurn }),
  };
}

/** The heading of microphone 2 when the end that is held points to the pointer. */
const goalOf = (event) => wrap(Math.round(seen(event) - Number(event.currentTarget.dataset.end)));
const holds = (event) => event.currentTarget.dataset.pointer === String(event.pointerId);

function take(event) {
  if (event.button) return;
  const { currentTarget: hand } = event;
  hand.dataset.pointer = event.pointerId;
  hand.dataset.end = event.target.closest("[data-end]")?.dataset.end ?? 0;
  hand.setPointerCapture(event.pointerId);
}

const release = (hand) => {
  delete hand.dataset.pointer;
};

/** Give up every drag: a pointer that still holds an end of the axis moves it no more. */
export const letGo = () => document.querySelectorAll(".scope [data-pointer]").forEach(release);

const ARROWS = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 };

function pressed(event, { heading, drag, onDrag, onTurn }) {
  const step = ARROWS[event.key];
  const held = known(drag);
  if (step) onDrag(wrap(Math.round(held ? drag : heading) + step * (event.shiftKey ? 10 * STEP : STEP)));
  else if (event.key === "Enter" && held) {
    onDrag(null);
    onTurn(drag);
  } else if (event.key === "Escape" && held) {
    release(event.currentTarget);
    onDrag(null);
  } else return;
  event.preventDefault(); // but let it through: a held Escape still stops
}

/** The angle at which the pointer is seen from the centre of the drawing. */
function seen(event) {
  const group = event.currentTarget;
  const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(group.getScreenCTM().inverse());
  return angleOf(x, y);
}
