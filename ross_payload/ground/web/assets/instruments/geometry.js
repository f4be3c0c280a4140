/** Where things lie on a compass: degrees clockwise from straight up, y grows downward. Pure functions. */

const RADIAN = Math.PI / 180;

/** @typedef {[number, number]} Point */

/** Wrap an angle into [0, 360). @param {number} angle @returns {number} */
export const wrap = (angle) => ((angle % 360) + 360) % 360;

/** How far it is from one angle to another, clockwise positive, in (-180, 180]. */
export const turn = (from, to) => 180 - wrap(180 - (to - from));

/** The cosine of an angle in degrees. */
export const cosine = (angle) => Math.cos(angle * RADIAN);

/** The sine of an angle in degrees. */
export const sine = (angle) => Math.sin(angle * RADIAN);

/** The point at an angle and a distance from the centre. @returns {Point} */
export function point(angle, radius) {
  return [round(radius * sine(angle)), round(-radius * cosine(angle))];
}

/** The angle at which a point is seen from the centre. */
export const angleOf = (x, y) => wrap(Math.atan2(x, -y) / RADIAN);

/** Two decimals are enough for every screen. */
export const round = (number) => Math.round(number * 100) / 100;

/** The path of a slice of the disc. @param {number} angle its middle @param {number} half half of its width */
export function wedge(angle, half, radius) {
  if (half >= 180) return ring(radius);
  const [x1, y1] = point(angle - half, radius);
  const [x2, y2] = point(angle + half, radius);
  return `M0 0L${x1} ${y1}A${radius} ${radius} 0 ${half > 90 ? 1 : 0} 1 ${x2} ${y2}Z`;
}

/** The path of a band between two radii, clockwise from one angle to another. */
export function band(from, to, inner, outer) {
  const wide = wrap(to - from) > 180 ? 1 : 0;
  const [a, b, c, d] = [point(from, outer), point(to, outer), point(to, inner), point(from, inner)];
  return `M${a}A${outer} ${outer} 0 ${wide} 1 ${b}L${c}A${inner} ${inner} 0 ${wide} 0 ${d}Z`;
}

function ring(radius) {
  return `M0 ${-radius}A${radius} ${radius} 0 1 1 0 ${radius}A${radius} ${radius} 0 1 1 0 ${-radius}Z`;
}

/** A line through points. @param {Point[]} points */
export const line = (points) =>
  points.length ? `M${points.map(([x, y]) => `${round(x)} ${round(y)}`).join("L")}` : "";

/** Whether an angle lies between two others, clockwise. */
export const within = (angle, [from, to]) => wrap(angle - from) <= wrap(to - from);

/**
 * The parts of the circle that lie outside of some limits, as [from, to], clockwise.
 * `both`: only where neither an angle nor its opposite is inside, so that no axis gets there.
 */
export function beyond(limits, both) {
  if (!limits) return [];
  const [from, to] = limits;
  if (!both) return [[to, from]];
  const free = 180 - wrap(to - from);
  return free <= 0
    ? []
    : [
        [to, to + free],
        [to + 180, to + 180 + free],
      ];
}
