/** Whether what turns a payload has just moved by itself: then a press was meant for what stood there before. */

const WHAT = ".hero, .commands, .choice";
const LEAST = 8; // [px] by which a press can miss
const SETTLED = 500; // [ms] after which a hand has seen that it moved
const TURNS = new Set(["explore", "listen", "turn", "park", "home", "enrol"]);

let before = new Map(); // of what turns a payload, in the window [px], by their elements, as the latest drawing began
let moved = -Infinity; // when they last moved, `performance.now()` [ms]

/** Draw, and look what that moves. What the user moves, by scrolling for one, has moved before a drawing begins. */
export function watchingMoves(draw) {
  noteMoves();
  before = edges();
  draw();
  setTimeout(noteMoves); // once the browser has scrolled along with what has grown above, or shrunk below
}

function noteMoves() {
  const now = edges();
  const isAway = ([each, [top, bottom]]) => {
    const [topNow, bottomNow] = now.get(each) ?? [top, bottom];
    const isSeen = (bottom > 0 && top < innerHeight) || (bottomNow > 0 && topNow < innerHeight);
    return isSeen && Math.abs(topNow - top) >= LEAST;
  };
  if ([...before].some(isAway)) moved = performance.now();
  before = new Map();
}

/** Whether an order would turn a payload, and was pressed so soon that it may be meant for something else. */
export function isHasty({ kind }) {
  noteMoves();
  return TURNS.has(kind) && performance.now() - moved < SETTLED;
}

const edges = () =>
  new Map(
    [...document.querySelectorAll(WHAT)].map((each) => {
      const { top, bottom } = each.getBoundingClientRect();
      return [each, [top, bottom]];
    }),
  );
