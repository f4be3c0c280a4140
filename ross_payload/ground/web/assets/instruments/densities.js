/** What every orientation heard: one ridge of time differences per rotation, and where the sources would put theirs. */

import { guard, html, svg } from "../templates.js";
import { degrees, known, number, plural } from "../formatting.js";
import { chart, curve, empty, scale, ticksOf } from "./chart.js";
import { lookOf, mark } from "./colours.js";
import { cosine, round } from "./geometry.js";

const OVERLAP = 1.5; // a ridge may be so many rows high
const MOST_NAMED = 16; // rows that are named
const MOST_MARKED = 12; // sources that are marked on every row

/** @param {{sections: object}} state */
export function densities({ sections }) {
  const rows = sections.densities ?? [];
  const sources = sections.sources ?? [];
  if (!rows.length) return empty("No ITD densities yet. The payload sends one for each orientation during an exploration.");
  return html`<div class="instrument densities">${guard([rows, sources], () => ridges(rows, sources))}</div>`;
}

/** The time difference [µs] that a source at an azimuth gives at a heading; `unit` is d / v. */
export const expected = (unit, azimuth, heading, elevation) =>
  unit * cosine(elevation ?? 0) * cosine(azimuth - heading);

function ridges(rows, sources) {
  const { x, y } = axesOf(rows);
  const range = `from ${number(x.from)} to ${number(x.to)} microseconds`;
  return chart({
    kind: "ridges",
    label: `densities of ${plural(rows.length, "orientation")}, ${range}`,
    height: `${Math.min(Math.max(rows.length * 1.9, 6), 36)}em`,
    x,
    y,
    lines: rows.map((row, index) => ridge(row, index, x, y)),
    marks: sources.map((source) => path(source, rows, x, y, sources.length)),
  });
}

/** Time differences along, orientations downward; the first one has room for its ridge. */
function axesOf(rows) {
  const [from, to] = [rows[0].first_us, rows[0].last_us];
  const title = "time difference of arrival [µs], > 0 when microphone 2 leads";
  const every = Math.ceil(rows.length / MOST_NAMED);
  const named = rows.map((_, index) => -index).filter((row) => row % every === 0);
  return {
    x: { from, to, ticks: ticksOf(from, to), format: (us) => number(us), title },
    y: { from: 0.6 - rows.length, to: OVERLAP + 0.1, ticks: named, format: (row) => degrees(rows[-row].heading) },
  };
}

function ridge({ density, first_us: first, last_us: last }, index, x, y) {
  const along = scale(x);
  const up = scale(y);
  const place = (share, at) => [
    along(first + ((last - first) * at) / (density.length - 1)),
    round(100 - up(share * OVERLAP - index)),
  ];
  const base = round(100 - up(-index));
  const line = curve(density.map(place));
  return svg`<path class="ridge" d="${line}L${along(last)} ${base}L${along(first)} ${base}Z"></path>
    <path class="crest" d=${line}></path>`;
}

/** Where a source is expected, row by row; its mirror dashed while front and back are not told apart. */
function path(source, rows, x, y, count) {
  const [along, up] = [scale(x), scale(y)];
  const at = (azimuth) =>
    rows.map((row, index) => [
      along(expected(row.last_us, azimuth, row.heading, source.elevation)),
      round(100 - up(-index)),
    ]);
  const places = at(source.azimuth);
  const other = !source.resolved && known(source.mirror) ? curve(at(source.mirror)) : "";
  const marked = count > MOST_MARKED ? places.slice(0, 1) : places;
  return svg`<g class="path ${lookOf(source.source)}" data-source=${source.source}>
    <svg viewBox="0 0 100 100" preserveAspectRatio="none" width="100%" height="100%"><path d=${curve(places)}></path>
      <path class="mirror" d=${other}></path></svg>
    ${marked.map((place) => markAt(source, place))}</g>`;
}

const markAt = ({ source }, [left, top]) => svg`<svg class="at" x="${left}%" y="${top}%">${mark(source, [0, 0])}</svg>`;
