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
const CLICK = 4; // [px] that a pointer must move to drag
const SWIPE = 250; // [ms] within which a finger that begins to move up or down scrolls the page
const STEEP = Math.tan(Math.PI / 3); // down for one across, from which on that is up or down

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
export function ends({ heading, drag, mayOrder, onDrag, onTurn, onChoose }) {
  if (!known(heading) || !mayOrder) return nothing;
  const hand = listeners({ heading, drag, onDrag, onTurn, onChoose });
  const shown = known(drag) ? drag : heading;
  return svg`<g class=${known(drag) ? "ends held" : "ends"} aria-hidden="true"
    @pointerdown=${hand.down} @pointermove=${hand.move} @pointerup=${hand.up} @pointercancel=${hand.away}
    @touchmove=${hand.touch}>${[0, 180].map((end) => endOf(shown, end))}</g>`;
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
 * drags either end. `onDrag` hears where it is (null: let go), `onTurn` what was ordered, `onChoose` what a finger has
 * chosen and is to be confirmed.
 */
export function handle({ heading, drag, limits, mayOrder, onDrag, onTurn, onChoose }) {
  if (!known(heading)) return nothing;
  const shown = known(drag) ? drag : heading;
  const hand = mayOrder ? listeners({ heading, drag, onDrag, onTurn, onChoose }) : idle;
  const words = dragWords(shown, known(drag), isBeyond(shown, limits));
  return svg`<g class=${known(drag) ? "handle held" : "handle"} role="slider" tabindex=${mayOrder ? 0 : -1}
    aria-label="heading of the axis" aria-valuemin="0" aria-valuemax="359"
    aria-valuenow=${Math.round(wrap(shown)) % 360} aria-valuetext=${words} aria-disabled=${mayOrder ? "false" : "true"}
    @keydown=${hand.key}
    @pointerdown=${hand.down} @pointermove=${hand.move} @pointerup=${hand.up} @pointercancel=${hand.away}
    @touchmove=${hand.touch}>
    <title>axis ${axisWords(shown)}</title>${grip(shown, 0)}${grip(shown, 180)}</g>`;
}

function grip(heading, end) {
  const [x, y] = point(heading + end, GRIP);
  return svg`<g class="grip" data-end=${end} transform="translate(${x} ${y})"><circle class="reach" r="19"></circle>
    <circle class="knob" r="8.5"></circle></g>`;
}

const ignore = () => {};
const idle = { key: ignore, down: ignore, move: ignore, up: ignore, away: ignore, touch: ignore };

/**
 * What the hand does. The pointer that holds the handle, and by which end, is kept on the element itself. What a mouse
 * drags is ordered; a finger may have meant to scroll: of what it drags is asked.
 */
function listeners({ heading, drag, onDrag, onTurn, onChoose }) {
  const drop = (event) => (release(event.currentTarget), onDrag(null));
  const up = (event) => {
    const goal = goalOf(event);
    const made = moved(event);
    drop(event);
    if (!made || Math.abs(turn(heading, goal)) < STILL) return;
    if (event.pointerType === "mouse") onTurn(goal);
    else onChoose(goal);
  };
  const move = (event) => {
    if (!event.buttons) drop(event); // its release may be lost
    else if (moved(event)) onDrag(goalOf(event));
  };
  return {
    down: take,
    move: (event) => holds(event) && move(event),
    up: (event) => holds(event) && up(event),
    away: (event) => holds(event) && drop(event),
    touch: (event) => touched(event) && event.preventDefault(), // touch-action does not work inside of an SVG
    key: (event) => pressed(event, { heading, drag, onDrag, onTurn }),
  };
}

/** The heading of microphone 2 when the end that is held points to the pointer. */
const goalOf = (event) => wrap(Math.round(seen(event) - Number(event.currentTarget.dataset.end)));
const holds = (event) => event.currentTarget.dataset.pointer === String(event.pointerId);
const taken = new WeakMap(); // by element: where and when the pointer took it, whether it drags, and around what

function take(event) {
  if (event.button || !event.isPrimary) return;
  const { currentTarget: hand } = event;
  hand.dataset.pointer = event.pointerId;
  hand.dataset.end = event.target.closest("[data-end]")?.dataset.end ?? 0;
  const [centre, scroll] = [centreOf(hand), [scrollX, scrollY]];
  const from = { x: event.clientX, y: event.clientY, at: event.timeStamp, drags: false };
  taken.set(hand, { ...from, centre, drawn: centre, scroll });
  hand.setPointerCapture(event.pointerId);
}

/** Whether the pointer drags: not before it has moved, and not while a finger scrolls the page. */
function moved({ currentTarget: hand, clientX, clientY, timeStamp, pointerType }) {
  const from = taken.get(hand);
  const [across, down] = [Math.abs(clientX - from.x), Math.abs(clientY - from.y)];
  if (from.drags || Math.hypot(across, down) < CLICK) return from.drags;
  if (pointerType !== "mouse" && down > STEEP * across && timeStamp - from.at < SWIPE) release(hand);
  else from.drags = true;
  return from.drags;
}

/** Whether a finger drags; pointer events come before those of touch. A second one has to do with the whole page. */
function touched({ currentTarget: hand, touches, cancelable }) {
  if (touches.length > 1) release(hand);
  return cancelable && hand.dataset.pointer !== undefined && taken.get(hand).drags; // else the page scrolls already
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

/** The angle at which the pointer is seen from where the centre of the drawing is to the hand that drags. */
function seen({ currentTarget: hand, clientX, clientY }) {
  const from = taken.get(hand);
  follow(from, centreOf(hand));
  return angleOf(clientX - from.centre[0], clientY - from.centre[1]);
}

/** Go along with a page that is scrolled, not with one that jumps: the angle would jump, and no hand has moved. */
function follow(from, drawn) {
  const scroll = [scrollX, scrollY];
  const gone = scroll.map((each, axis_) => from.scroll[axis_] - each);
  const isScrolled = gone.every((each, axis_) => Math.abs(drawn[axis_] - from.drawn[axis_] - each) < 1);
  if (isScrolled) from.centre = from.centre.map((each, axis_) => each + gone[axis_]);
  Object.assign(from, { drawn, scroll });
}

/** Where the centre of the drawing is in the window [px]. */
function centreOf(hand) {
  const { e, f } = hand.getScreenCTM();
  return [e, f];
}
