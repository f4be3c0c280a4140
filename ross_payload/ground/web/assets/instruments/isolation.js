/** How far every heading of the axis sets each source apart from its nearest neighbour, over half a turn. */

import { guard, html, nothing, svg } from "../templates.js";
import { known, number, plural } from "../formatting.js";
import { chart, curve, empty, scale, ticksOf } from "./chart.js";
import { lookOf, mark } from "./colours.js";
import { beyond, round, wrap } from "./geometry.js";
import { axisWords } from "./phrases.js";
import { candidateWords, leading } from "./scope-plan.js";

const HALF = 180;
const X = {
  from: 0,
  to: HALF,
  ticks: [0, 60, 120, 180],
  format: (at) => `${at}°`,
  title: "axis heading (opposite headings are the same axis)",
};
const MOST_TOLD = 4; // sources in the readout

/**
 * @param {object} state
 * @param {object} state.sections
 * @param {number|null} [state.cursor] heading that is asked about; without it the present one is told
 * @param {(heading: number|null) => void} [state.onCursor]
 */
export function isolation({ sections, cursor = null, onCursor = null }) {
  const curves = sections.isolation ?? [];
  if (!curves.length) return empty("No isolation curves yet. The payload sends them when it plans an alignment.");
  const heading = sections.pointing?.heading ?? null;
  const asked = cursor ?? heading;
  return html`<div class="instrument isolation">
    ${guard(whatCounts(sections, cursor), () => drawing(sections, curves, cursor))}
    ${onCursor ? slider(asked, onCursor) : nothing}
    <p class="readout">${known(asked) ? readout(curves, asked) : nothing}</p></div>`;
}

const whatCounts = ({ isolation: curves, plan, pointing = {} }, cursor) => [
  curves,
  plan,
  pointing.limits?.join(),
  round(pointing.heading),
  cursor,
];

/** A curve's isolation [µs] at a heading. */
function isolationAt(curve_, heading) {
  const { first, last, isolation: shares, maximum_us: maximum } = curve_;
  const place = (wrapHalf((heading - first) * Math.sign(last - first)) / Math.abs(last - first)) * (shares.length - 1);
  const [low, part] = [Math.floor(place), place % 1];
  const next = shares[low + 1] ?? shares[0]; // half a turn later it starts again
  return maximum * (shares[Math.min(low, shares.length - 1)] * (1 - part) + next * part);
}

const wrapHalf = (angle) => ((angle % HALF) + HALF) % HALF;

function drawing(sections, curves, cursor) {
  const top = Math.max(...curves.map((each) => each.maximum_us * Math.max(...each.isolation)), 1);
  const y = { from: 0, to: top * 1.12, ticks: ticksOf(0, top, 3), format: (us) => number(us) };
  const first = leading(sections.plan);
  return chart({
    kind: "curves",
    label: `isolation in microseconds of ${plural(curves.length, "source")} over half a turn`,
    height: "11em",
    x: X,
    y,
    lines: [
      never(sections.pointing?.limits),
      ...curves.map((each) => line(each, y, first)),
      upright(sections.pointing?.heading, "now"),
      upright(cursor, "asked"),
    ],
    marks: [
      ...curves.map((each) => summit(each, y)),
      ...(sections.plan?.candidates ?? []).map((each) => flag(each, each === first)),
    ],
  });
}

/** Points of a curve as [heading in half a turn, µs], by heading. */
function pointsOf({ first, last, isolation: shares, maximum_us: maximum }) {
  const points = shares.map((share, index) => [
    wrapHalf(first + ((last - first) * index) / (shares.length - 1)),
    share * maximum,
  ]);
  return points.sort((a, b) => a[0] - b[0]);
}

function line(each, y, first) {
  const [along, up] = [scale(X), scale(y)];
  const path = curve(pointsOf(each).map(([at, us]) => [along(at), round(100 - up(us))]));
  const look = `${lookOf(each.source)}${first?.source === each.source ? " leading" : ""}`;
  return svg`<path class="curve ${look}" data-source=${each.source} d=${path}></path>`;
}

/** The source's mark on the top of its curve. */
function summit(each, y) {
  const [at, us] = pointsOf(each).reduce((best, next) => (next[1] > best[1] ? next : best));
  return svg`<svg class="at" x="${scale(X)(at)}%" y="${round(100 - scale(y)(us))}%">${mark(each.source, [0, 0])}</svg>`;
}

function upright(heading, kind) {
  return known(heading)
    ? svg`<path class="upright ${kind}" d="M${scale(X)(wrapHalf(heading))} 0V100"></path>`
    : nothing;
}

function flag(candidate, first) {
  const left = scale(X)(wrapHalf(candidate.heading));
  const look = `${candidate.state}${first ? " leading" : ""}`;
  return svg`<svg class="at" x="${left}%" y="0"><path class="flag ${look}" d="M-6 0H6L0 10Z">
    <title>${candidateWords(candidate)}</title></path></svg>`;
}

/** Headings that no turn reaches, as bands. */
function never(limits) {
  return beyond(limits, true)
    .slice(0, 1)
    .map(([from, to]) => {
      const [start, wide] = [wrapHalf(from), wrap(to - from)];
      const parts = [
        [start, Math.min(wide, HALF - start)],
        [0, Math.max(start + wide - HALF, 0)],
      ];
      return parts.map(
        ([at, length]) => svg`<rect class="never" x=${scale(X)(at)} width=${scale(X)(length)} height="100"></rect>`,
      );
    });
}

function slider(asked, onCursor) {
  return html`<label class="asking"><span>At heading</span><input type="range" min="0" max="179" step="1"
    .value=${String(Math.round(wrapHalf(asked ?? 0)) % HALF)} aria-valuetext=${axisWords(asked)}
    @input=${(event) => onCursor(Number(event.target.value))} @blur=${() => onCursor(null)}></label>`;
}

/** Who is set apart best at a heading, in words. */
function readout(curves, heading) {
  const all = curves.map((each) => [each.source, isolationAt(each, heading)]).sort((a, b) => b[1] - a[1]);
  const told = all.slice(0, MOST_TOLD).map(([source, us]) => `source ${source} ${number(us)} µs`);
  return `${axisWords(heading)}: ${told.join(", ")}${all.length > MOST_TOLD ? ", others less" : ""}`;
}
