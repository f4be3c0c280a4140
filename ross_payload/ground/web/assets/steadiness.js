/** Whether what turns a payload has just moved by itself: then a press was meant for what stood there before. */

const WHAT = ".hero, .commands, .choice";
const LEAST = 8; // [px] by which a press can miss
const SETTLED = 500; // [ms] after which a hand has seen that it moved
const TURNS = new Set(["explore", "listen", "turn", "park", "home", "enrol"]);

let size = ""; // of the window: who turns a phone or opens its keyboard sees what that moves
let places = new Map(); // of what turns a payload, in the page [px], by their elements
let moved = -Infinity; // when they last moved, `performance.now()` [ms]

/** Look where everything is, after every drawing. */
export function noteMoves() {
  const now = new Map([...document.querySelectorAll(WHAT)].map((each) => [each, topOf(each)]));
  const sizeNow = `${innerWidth} ${innerHeight}`;
  const away = [...now].some(([each, top]) => Math.abs(top - (places.get(each) ?? top)) >= LEAST);
  if (away && sizeNow === size) moved = performance.now();
  [places, size] = [now, sizeNow];
}

/** Whether an order would turn a payload, and was pressed so soon that it may be meant for something else. */
export const isHasty = ({ kind }) => TURNS.has(kind) && performance.now() - moved < SETTLED;

const topOf = (element) => element.getBoundingClientRect().top + scrollY;
