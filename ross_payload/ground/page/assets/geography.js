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

const round = (value) => Math.round(value * 10) / 10;
