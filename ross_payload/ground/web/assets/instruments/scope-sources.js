/** Sources around (0, 0): wedge, mirror, trail, mark and label; each a button. */

import { guard, nothing, svg } from "../templates.js";
import { degrees, known } from "../formatting.js";
import { lookOf, mark } from "./colours.js";
import { cosine, line, point, sine, turn, wedge } from "./geometry.js";
import { spread } from "./labels.js";
import { sourceWords } from "./phrases.js";
import { RIM } from "./scope-ring.js";

const LEAST = 2; // degrees: half of the narrowest wedge
const WIDEST = 90; // degrees: half of the widest one
const LABELS = { x: 178, y: 184 }; // the ellipse that labels stand on
const LONG = 12; // so many labels have room for an azimuth; more are numbers only
const MOST = 40; // labels at all: mirrors go without beyond
const RECENT = 30; // seconds of a trail that are seen
const FADES = 4; // steps in which a trail fades
const INWARD = 34; // how far inside of the rim the oldest point of a trail lies

/** @typedef {{source: number, azimuth: number, mirror: number|null, sigma: number, confidence: number}} Source */

/** Half of a wedge's width: one standard deviation, but never too thin to see. */
const halfOf = (source) => Math.min(Math.max(source.sigma, LEAST), WIDEST);

/** How far a wedge reaches: to the rim when it is certain. */
const reachOf = (source) => RIM * (0.45 + 0.55 * Math.min(Math.max(source.confidence ?? 0, 0), 1));

/** Whether it may be at the mirror as well. */
const isTwofold = (source) => !source.resolved && known(source.mirror);

/** Every source. `selected` and `hovered` are numbers of sources. */
export function sourcesOf({ sources, now, selected, hovered, onSelect, onHover }) {
  const first = sources.some((each) => each.source === selected) ? selected : sources[0]?.source;
  return svg`<g class="trails" aria-hidden="true">${sources.map((each) => trail(each, now))}</g>
    <g class="sources" role="toolbar" aria-label="sources">${sources.map((source) =>
      button(source, {
        chosen: source.source === selected,
        near: source.source === hovered,
        entry: source.source === first,
        onSelect,
        onHover,
      }),
    )}</g>
    <g class="labels" aria-hidden="true">${guard([sources], () => labels(sources))}</g>`;
}

function button(source, { chosen, near, entry, onSelect, onHover }) {
  const { source: index, azimuth } = source;
  const half = halfOf(source);
  const reach = reachOf(source);
  const state = `${chosen ? " chosen" : ""}${near ? " near" : ""}${source.final ? "" : " early"}`;
  return svg`<g class="source ${lookOf(index)}${state}" data-source=${index} role="button" tabindex=${entry ? 0 : -1}
    aria-pressed=${chosen ? "true" : "false"} aria-label=${sourceWords(source)}
    @click=${() => onSelect(index)} @keydown=${(event) => pressed(event, index, onSelect)}
    @pointerenter=${() => onHover(index)} @pointerleave=${() => onHover(null)}
    @focus=${() => onHover(index)} @blur=${() => onHover(null)}>
    ${isTwofold(source) ? mirrored(source, half, reach) : nothing}
    ${known(source.sigma) ? svg`<path class="wedge" d=${wedge(azimuth, half, reach)}></path>` : nothing}
    <path class="ray" d=${line([point(azimuth, 32), point(azimuth, RIM)])}></path>
    ${source.target ? ringAt(point(azimuth, RIM)) : nothing}${chosen ? aura(point(azimuth, RIM)) : nothing}
    ${mark(index, point(azimuth, RIM))}</g>`;
}

/** Where it may be instead: an outline only. */
function mirrored(source, half, reach) {
  const [x, y] = point(source.mirror, RIM);
  return svg`<path class="wedge mirrored" d=${wedge(source.mirror, half, reach)}></path>
    <circle class="mirrored" r="7" cx=${x} cy=${y}></circle>`;
}

const ringAt = ([x, y]) => svg`<circle class="target" r="13" cx=${x} cy=${y}></circle>`;
const aura = ([x, y]) => svg`<circle class="aura" r="17" cx=${x} cy=${y}></circle>`;

/** Enter and space choose; arrows go to the neighbours. */
function pressed(event, index, onSelect) {
  const { currentTarget: here, key } = event;
  if (key === "Enter" || key === " ") onSelect(index);
  else if (key === "ArrowRight" || key === "ArrowDown")
    (here.nextElementSibling ?? here.parentNode.firstElementChild).focus();
  else if (key === "ArrowLeft" || key === "ArrowUp")
    (here.previousElementSibling ?? here.parentNode.lastElementChild).focus();
  else return;
  event.preventDefault();
}

/** Where it was lately, from the rim inwards with age, fading. */
function trail({ source, azimuth, trail: points }, now) {
  if (!known(now)) return nothing;
  const recent = points.filter(([at]) => now - at < RECENT);
  if (recent.length < 2) return nothing;
  const places = [...recent.map(([at, angle]) => [(now - at) / RECENT, angle]), [0, azimuth]];
  return Array.from({ length: FADES }, (_, step) => {
    const part = places.filter(([age], index) => within(step, age) || within(step, places[index + 1]?.[0] ?? 1));
    return svg`<path class="trail f${step} ${lookOf(source)}" d=${line(part.map(placed))}></path>`;
  });
}

const within = (step, age) => Math.min(Math.floor(Math.max(age, 0) * FADES), FADES - 1) === step;
const placed = ([age, angle]) => point(angle, RIM - 9 - INWARD * Math.min(Math.max(age, 0), 1));

/** Numbers, and azimuths while there is room; none covers another. */
function labels(sources) {
  const wanted = [
    ...sources.map((source) => ({ source, angle: source.azimuth, mirror: false })),
    ...sources.filter(isTwofold).map((source) => ({ source, angle: source.mirror, mirror: true })),
  ].slice(0, Math.max(MOST, sources.length));
  const long = wanted.length <= LONG;
  const boxes = wanted.map(({ source, angle }) => ({ angle, ...sizeOf(source, long) }));
  if (!boxes.length) return nothing;
  const angles = spread(boxes, LABELS);
  return wanted.map((each, index) => label(each, angles[index], long));
}

const sizeOf = (source, long) =>
  long ? { width: 50, height: 40 } : { width: 10 + 13 * nameOf(source).length, height: 20 };
const nameOf = (source) => `${source.source}${source.resolved ? "" : "?"}`;

function label({ source, angle, mirror }, at, long) {
  const [x, y] = [LABELS.x * sine(at), -LABELS.y * cosine(at)].map((each) => each.toFixed(1));
  const away = Math.abs(turn(angle, at)) > 4;
  const lead = away ? svg`<path class="lead" d=${line([point(angle, RIM + 8), point(at, RIM + 14)])}></path>` : nothing;
  return svg`<g class="label ${lookOf(source.source)}${mirror ? " mirror" : ""}" data-source=${source.source}>${lead}
    <text x=${x} y=${y} dy=${long ? "-0.15em" : "0.35em"}>${nameOf(source)}</text>
    ${long ? svg`<text class="azimuth" x=${x} y=${y} dy="0.9em">${degrees(angle)}</text>` : nothing}</g>`;
}
