/** The map itself, as SVG in pixels: letters keep their size however far it is zoomed. */

import { ahead, ellipse, gridLines, onScreen, roundStep, tilesOn } from "../geography.js";
import { lookOf } from "../instruments/colours.js";
import { nothing, repeat, svg } from "../templates.js";
import { known, plural } from "../formatting.js";

const GRID = 90; // [px] between lines, at most
const RAY = 3000; // [px] that a bearing reaches
const FIRST_SIZE = 1.5; // [px] that an ellipse has at least

/** @param {{stands: object[], fixes: object[], tiles: ?object}} scene  @param {import("../geography.js").Look} look */
export function drawing(scene, look, size) {
  const [width, height] = size;
  const to = (point) => onScreen(look, size, point);
  const step = roundStep(GRID / look.scale);
  return svg`<svg viewBox="0 0 ${width} ${height}" role="img" aria-label=${words(scene)}>
    ${scene.tiles && scene.origin ? backdrop(scene, look, size) : nothing}
    <g class="grid ${scene.tiles ? "over" : ""}">${grid(look, size, step, to)}</g>
    ${scene.stands.map((stand) => rays(stand, look, to))}
    ${scene.fixes.map((fix, index) => crossing(fix, index, look, to))}
    ${scene.stands.map((stand) => payload(stand, to))}
    ${scale(step, look, height)}${north(width)}
  </svg>`;
}

function words({ stands, fixes }) {
  const placed = stands.filter((stand) => !stand.assumed);
  if (!placed.length) return "No payload position is known: payloads are drawn at assumed positions";
  return `${plural(placed.length, "payload")}, bearings cross at ${fixes.filter((fix) => !fix.ghost).length} places`;
}

/** The map that the user gave: images under all else. */
function backdrop({ tiles, origin }, look, size) {
  const shown = tilesOn(tiles, origin, look, size);
  return svg`<g class="tiles">${repeat(
    shown,
    ({ name }) => name,
    ({ name, x, y, width, height }) =>
      svg`<image href="/tiles/${name}" x=${x} y=${y} width=${width} height=${height} preserveAspectRatio="none"></image>`,
  )}</g>`;
}

function grid({ x, y, scale: zoom }, [width, height], step, to) {
  const [half, tall] = [width / 2 / zoom, height / 2 / zoom];
  const across = gridLines(x - half, x + half, step).map((east) => to([east, y])[0]);
  const up = gridLines(y - tall, y + tall, step).map((north) => to([x, north])[1]);
  return svg`${across.map((px) => svg`<line x1=${px} x2=${px} y1="0" y2=${height}></line>`)}
    ${up.map((py) => svg`<line x1="0" x2=${width} y1=${py} y2=${py}></line>`)}`;
}

/** Every bearing with one sigma to either side; a source that may be in front or behind has two. */
const rays = ({ at, bearings }, look, to) => bearings.map((each) => ray(at, each, RAY / look.scale, to));

function ray(at, { source, azimuth, sigma }, far, to) {
  const wide = Math.min(Math.max(sigma, 0.2), 60);
  const corners = [at, ahead(at, azimuth - wide, far), ahead(at, azimuth + wide, far)].map((each) =>
    to(each).join(" "),
  );
  const [[x1, y1], [x2, y2]] = [to(at), to(ahead(at, azimuth, far))];
  return svg`<g class="ray ${lookOf(source)}"><path d="M${corners.join("L")}Z"></path>
    <line x1=${x1} y1=${y1} x2=${x2} y2=${y2}></line></g>`;
}

function crossing({ at, covariance, ghost }, index, look, to) {
  const [x, y] = to(at);
  const { major, minor, turn } = ellipse(covariance);
  const [rx, ry] = [major, minor].map((each) => Math.max(each * look.scale, FIRST_SIZE));
  return svg`<g class="crossing ${ghost ? "ghost" : ""}" transform="translate(${x} ${y})">
    <ellipse rx=${rx} ry=${ry} transform="rotate(${turn})"></ellipse><circle r="3"></circle>
    ${ghost ? nothing : svg`<text x="10" y="-8">${index + 1}</text>`}</g>`;
}

function payload({ id, at, heading, earth, place, assumed }, to) {
  const [x, y] = to(at);
  const zero = earth ? 0 : place?.heading;
  const axis = known(heading) && known(zero) ? heading + zero : null;
  return svg`<g class="stand ${assumed ? "assumed" : ""}" transform="translate(${x} ${y})">
    ${axis === null ? nothing : svg`<line class="axis" y1="-22" y2="22" transform="rotate(${axis})"></line>`}
    <circle r="8"></circle><text y="26">${id}</text>
    ${assumed ? svg`<text class="remark" y="44">assumed</text>` : nothing}</g>`;
}

function scale(step, look, height) {
  const long = step * look.scale;
  const label = step >= 1000 ? `${step / 1000} km` : `${step} m`;
  return svg`<g class="scale" transform="translate(16 ${height - 18})">
    <path d="M0 -6V0H${long}V-6"></path><text x=${long + 8} y="2">${label}</text></g>`;
}

const north = (width) => svg`<g class="north" transform="translate(${width - 28} 40)">
  <path d="M0 -22L7 4L0 -2L-7 4Z"></path><text y="20">N</text></g>`;
