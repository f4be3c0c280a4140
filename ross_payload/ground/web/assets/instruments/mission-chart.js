/** The mission over time: states as bands, the number of sources as steps, the score against its criterion. */

import { guard, html, nothing, svg } from "../templates.js";
import { clock, known, number, state } from "../formatting.js";
import { chart, curve, empty, scale, ticksOf, timesOf } from "./chart.js";
import { round } from "./geometry.js";
import { plain, told } from "./phrases.js";

const GROUPS = {
  explore_turn: "explore",
  explore_listen: "explore",
  align_turn: "align",
  check: "align",
  lead_in: "noise",
  noise: "noise",
  run: "listen",
};
const LETTER = 1.6; // per cent of the width that a letter of a band's name takes on a phone, about
const SHORTEST = 10; // seconds that are shown at least

/** @param {{sections: object, now: number|null}} state */
export function strip({ sections, now }) {
  const history = sections.history ?? [];
  if (!history.length) return empty("No mission yet.");
  const end = Math.max(now ?? 0, history.at(-1).at);
  return html`<div class="instrument strip">${elapsed(sections.mission ?? {})}
    ${guard([history, Math.floor(end)], () => charts(history, end))}</div>`;
}

function charts(history, end) {
  const span = Math.max(end - history[0].at, SHORTEST);
  const x = { from: end - span, to: end, ticks: [] };
  return html`${states(history, x)}${steps(history, x)}${scores(history, x, timeAxis(x, span))}`;
}

/** Times count back from now. */
function timeAxis(x, span) {
  const ticks = timesOf(-span, 0, 3).map((ago) => x.to + ago);
  return { ...x, ticks, format: (at) => (x.to - at < 0.5 ? "now" : `−${clock(x.to - at)}`) };
}

/** Neighbouring moments of the same state, as [state, from, to]. */
function runs(history, end, nameOf = (name) => name) {
  const found = [];
  history.forEach((each, index) => {
    const until = history[index + 1]?.at ?? end;
    const name = nameOf(each.state);
    if (found.at(-1)?.[0] === name) found.at(-1)[2] = until;
    else found.push([name, each.at, until]);
  });
  return found;
}

const groupOf = (name) => GROUPS[name] ?? plain(name);

function states(history, x) {
  const along = scale(x);
  const bands = runs(history, x.to).map((run) => band(run, along));
  const named = runs(history, x.to, groupOf);
  return chart({
    kind: "states",
    label: `States: ${named
      .slice(-6)
      .map(([name]) => name)
      .join(", then ")}`,
    height: "1.7em",
    x,
    y: { from: 0, to: 1, ticks: [0.5], format: () => "state" },
    lines: bands,
    marks: named.map(([name, from, to]) => titled(name, along(from), along(to))),
  });
}

/** A state's time; never too short to be seen. */
function band([name, from, to], along) {
  const width = round(Math.max(along(to) - along(from), 0.15));
  return svg`<rect class="state ${name ?? "unknown"}" x=${along(from)} width=${width} height="100">
    <title>${state(name)}, ${clock(to - from)}</title></rect>`;
}

/** A band's name, where it has room. */
function titled(name, from, to) {
  if (to - from < name.length * LETTER) return nothing;
  return svg`<text class="name" x="${round((from + to) / 2)}%" y="50%" dy="0.35em">${name}</text>`;
}

function steps(history, x) {
  const most = Math.max(2, ...history.map((each) => each.k ?? 0));
  const y = { from: 0, to: most * 1.1, ticks: ticksOf(0, most, 2).filter(Number.isInteger), format: (k) => number(k) };
  return chart({
    kind: "steps",
    label: `number of sources over time, now ${number(history.at(-1).k)}`,
    height: "3.6em",
    x,
    y,
    lines: svg`<path class="k" d=${stair(history, "k", x, y)}></path>`,
    marks: title("K"),
  });
}

/** A number that holds until the next moment. */
function stair(history, key, x, y) {
  const [along, up] = [scale(x), scale(y)];
  return curve(
    history.flatMap((each, index) => {
      if (!known(each[key])) return [null];
      const level = round(100 - up(each[key]));
      return [
        [along(each.at), level],
        [along(history[index + 1]?.at ?? x.to), level],
      ];
    }),
  );
}

function scores(history, x, axis) {
  const all = history.flatMap((each) => [each.score, each.criterion]).filter(known);
  const [low, high] = [Math.min(0, ...all), Math.max(1, ...all)];
  const margin = (high - low) * 0.1;
  const y = {
    from: low - margin,
    to: high + margin,
    ticks: ticksOf(low, high, 3),
    format: (score) => number(score, high - low < 3 ? 1 : 0),
  };
  const last = history.at(-1);
  return chart({
    kind: "scores",
    label: `score over time, now ${number(last.score, 1)}, criterion ${number(last.criterion, 1)}`,
    height: "5em",
    x: axis,
    y,
    lines: svg`<path class="criterion" d=${stair(history, "criterion", x, y)}></path>
      <path class="score" d=${stair(history, "score", x, y)}></path>`,
    marks: title("score, criterion dashed"),
  });
}

const title = (words) => svg`<text class="title" x="4" y="1.1em">${words}</text>`;

/** Elapsed time against the expected one. */
function elapsed({ elapsed: time, expected }) {
  const share = known(time) && expected > 0 ? Math.min(time / expected, 1) : 0;
  const about = known(expected) ? `about ${clock(expected)}` : told(clock(null));
  return html`<div class="elapsed"><span>elapsed ${told(clock(time))}, expected ${about}</span>
    <svg viewBox="0 0 100 1" preserveAspectRatio="none" aria-hidden="true">
      <rect class="trough" width="100" height="1"></rect>
      <rect class="level" width=${round(100 * share)} height="1"></rect></svg></div>`;
}
