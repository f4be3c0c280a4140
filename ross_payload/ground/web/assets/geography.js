/** From degrees on the globe to metres on a plane, and from metres to the screen. Pure functions. */

const RADIUS = 6371008.8; // [m] of the globe
const RADIAN = Math.PI / 180;
const STEPS = [1, 2, 5];

/** @typedef {{lat: number, lon: number}} Place [deg] */
/** @typedef {{x: number, y: number, scale: number}} Look  the middle [m east, m north], and pixels per metre */

/** Metres east and north of an origin; good for some kilometres. @param {Place} origin @param {Place} place */
export function metres(origin, place) {
  const east = wrapped(place.lon - origin.lon) * RADIAN * RADIUS * Math.cos(origin.lat * RADIAN);
  return [east, (place.lat - origin.lat) * RADIAN * RADIUS];
}

const wrapped = (degrees) => ((((degrees + 180) % 360) + 360) % 360) - 180;

/** A point of the plane on a screen of this size. */
export const onScreen = ({ x, y, scale }, [width, height], [east, north]) => [
  round(width / 2 + (east - x) * scale),
  round(height / 2 - (north - y) * scale),
];

/** The look that shows all points, with room around; alone, a point gets 100 m. @returns {Look} */
export function fitting(points, [width, height]) {
  if (!points.length) return { x: 0, y: 0, scale: Math.min(width, height) / 100 };
  const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
  const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const scale = 0.7 * Math.min(width / Math.max(right - left, 50), height / Math.max(high - low, 50));
  return { x: (left + right) / 2, y: (low + high) / 2, scale };
}

/** The largest of 1, 2, 5 times a power of ten that is no more than a number. */
export function roundStep(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return power * STEPS.findLast((each) => each * power <= most * (1 + 1e-9));
}

/** Where the lines of a grid of this step are, between two edges. */
export function gridLines(least, most, step) {
  const first = Math.ceil(least / step);
  return Array.from({ length: Math.max(0, Math.floor(most / step) - first + 1) }, (_, index) => (first + index) * step);
}

/** A 2x2 covariance as an ellipse of one sigma: half axes [m], turn of the first one clockwise on the screen [deg]. */
export function ellipse([[a, b], [, c]]) {
  const mean = (a + c) / 2;
  const apart = Math.hypot((a - c) / 2, b);
  const turn = (Math.atan2(2 * b, a - c) / 2 / Math.PI) * 180;
  return { major: Math.sqrt(Math.max(mean + apart, 0)), minor: Math.sqrt(Math.max(mean - apart, 0)), turn: -turn };
}

/** The point at so many metres and degrees clockwise from north. */
export const ahead = ([east, north], azimuth, distance) => [
  east + distance * Math.sin(azimuth * RADIAN),
  north + distance * Math.cos(azimuth * RADIAN),
];

/** Zoom by a factor about a point of the screen, so that it stays where it is. @returns {Look} */
export function zoomed(look, [width, height], factor, [px, py] = [width / 2, height / 2]) {
  const scale = Math.min(Math.max(look.scale * factor, 1e-3), 1e3);
  const [dx, dy] = [px - width / 2, height / 2 - py];
  return { x: look.x + dx / look.scale - dx / scale, y: look.y + dy / look.scale - dy / scale, scale };
}

/** The width of the globe's square in pixels of tiles at zoom 0, and how far one reaches at the equator [m]. */
const TILE = 256; // [px]
const AROUND = 2 * Math.PI * RADIUS; // [m]
const MOST_TILES = 120; // on a screen: beyond, larger ones are taken

/** The scale [px/m] at which tiles of a zoom level are as large as they were drawn. */
export const scaleOf = (zoom, { lat }) => (TILE * 2 ** zoom) / (AROUND * Math.cos(lat * RADIAN));

/** Column and row of a place among the tiles of a zoom level, with fractions; rows count from the north. */
function tileAt({ lat, lon }, zoom) {
  const north = Math.asinh(Math.tan(Math.min(Math.max(lat, -85), 85) * RADIAN));
  return [((lon + 180) / 360) * 2 ** zoom, ((1 - north / Math.PI) / 2) * 2 ** zoom];
}

/** The north-western corner of a tile. @returns {Place} */
const cornerOf = (column, row, zoom) => ({
  lat: Math.atan(Math.sinh(Math.PI * (1 - (2 * row) / 2 ** zoom))) / RADIAN,
  lon: (column / 2 ** zoom) * 360 - 180,
});

/** The place at so many metres east and north of an origin. @returns {Place} */
const placeAt = (origin, [east, north]) => ({
  lat: origin.lat + north / RADIUS / RADIAN,
  lon: origin.lon + east / (RADIUS * Math.cos(origin.lat * RADIAN)) / RADIAN,
});

/**
 * The tiles that cover a screen, and where they are on it.
 * @param {{minzoom: number, maxzoom: number}} levels  @param {Place} origin  @param {Look} look
 * @returns {{name: string, x: number, y: number, width: number, height: number}[]} `name` as in `/tiles/NAME`
 */
export function tilesOn({ minzoom, maxzoom }, origin, look, size) {
  const [half, tall] = [size[0] / 2 / look.scale, size[1] / 2 / look.scale];
  const corners = [placeAt(origin, [look.x - half, look.y + tall]), placeAt(origin, [look.x + half, look.y - tall])];
  const wanted = Math.round(Math.log2(look.scale / scaleOf(0, origin)));
  let zoom = Math.min(Math.max(wanted, minzoom), maxzoom);
  let span = spanOf(corners, zoom);
  while (span.columns * span.rows > MOST_TILES && zoom > minzoom) span = spanOf(corners, (zoom -= 1));
  if (span.columns * span.rows > MOST_TILES) return []; // too far away for the smallest map there is
  return Array.from({ length: span.columns * span.rows }, (_, index) => {
    const [column, row] = [span.left + (index % span.columns), span.top + Math.floor(index / span.columns)];
    const [x, y] = onScreen(look, size, metres(origin, cornerOf(column, row, zoom)));
    const [right, bottom] = onScreen(look, size, metres(origin, cornerOf(column + 1, row + 1, zoom)));
    return { name: `${zoom}/${column}/${row}`, x, y, width: round(right - x), height: round(bottom - y) };
  });
}

function spanOf([first, last], zoom) {
  const most = 2 ** zoom - 1;
  const [left, top] = tileAt(first, zoom).map((each) => Math.max(Math.floor(each), 0));
  const [right, bottom] = tileAt(last, zoom).map((each) => Math.min(Math.floor(each), most));
  return { left, top, columns: Math.max(right - left + 1, 0), rows: Math.max(bottom - top + 1, 0) };
}

const round = (value) => Math.round(value * 10) / 10;
