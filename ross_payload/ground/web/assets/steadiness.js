/** Whether what turns a payload has just moved by itself: then a press was meant for what stood there before. */

const WHAT = ".hero, .commands, .choice";
const LEAST = 8; // [px] by which a press can miss
const SETTLED = 500; // [ms] after which a hand has seen that it moved
const TURNS = new Set(["explore", "listen", "turn", "park", "home", "enrol"]);

let before = null; // how the page lay in the window as the latest drawing began
let moved = -Infinity; // when it last moved there by itself, `performance.now()` [ms]

/** Draw, and look what that moves. What the user moves, by scrolling for one, is not counted. */
export function watchingMoves(draw) {
  noteMoves();
  before = layout();
  draw();
  setTimeout(noteMoves); // once the browser has scrolled along with what has grown above, or shrunk below
}

function noteMoves() {
  if (!before) return;
  const now = layout();
  const cut = now.height < before.height && now.scroll + innerHeight > now.height - 1; // then the browser scrolls back
  const scrolled = cut ? 0 : now.scroll - before.scroll;
  const isAway = ([each, [top, bottom]]) => {
    const [topNow, bottomNow] = now.edges.get(each) ?? [top, bottom];
    const isSeen = (bottom > 0 && top < innerHeight) || (bottomNow > 0 && topNow < innerHeight);
    const by = topNow - top; // in the window, where it stays when the browser scrolls along; the rest is on the page
    return isSeen && Math.min(Math.abs(by), Math.abs(by + scrolled)) >= LEAST;
  };
  if ([...before.edges].some(isAway)) moved = performance.now();
  before = null;
}

/** Whether an order would turn a payload, and was pressed so soon that it may be meant for something else. */
export function isHasty({ kind }) {
  noteMoves();
  return TURNS.has(kind) && performance.now() - moved < SETTLED;
}

/** How tall the page is and how far it is scrolled, and what turns a payload in the window [px], by its elements. */
function layout() {
  const edges = [...document.querySelectorAll(WHAT)].map((each) => {
    const { top, bottom } = each.getBoundingClientRect();
    return [each, [top, bottom]];
  });
  return { height: document.documentElement.scrollHeight, scroll: scrollY, edges: new Map(edges) };
}
