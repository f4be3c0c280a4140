/** Where to turn and why: candidates on the rim, and the interferers that pose as one. Drawn around (0, 0). */

import { nothing, svg } from "../templates.js";
import { degrees, known, number, plural } from "../formatting.js";
import { lookOf } from "./colours.js";
import { cosine, line, point, round } from "./geometry.js";
import { plain } from "./phrases.js";
import { RIM } from "./scope-ring.js";

/** The candidate that counts now: the current one, else the next one to try. */
export function leading(plan) {
  const { candidates = [], current = null } = plan ?? {};
  return (
    candidates.find((each) => each.candidate === current) ?? candidates.find((each) => each.state === "planned") ?? null
  );
}

/** A candidate for a reader. */
export function candidateWords(each) {
  const gain = known(each.gain) ? `, ${number(each.gain, 1)} dB predicted` : "";
  const posing = each.aliased.length > 1 ? `; sources ${each.aliased.join(", ")} have the same delay` : "";
  const what = `${degrees(each.heading)} isolates source ${each.source}`;
  return `candidate ${each.candidate}: ${what}${gain}${posing} (${plain(each.state)})`;
}

/** A tick at both ends of every candidate's axis; the leading one is long. */
export function candidates(plan) {
  const first = leading(plan);
  return svg`<g class="candidates" aria-hidden="true">${(plan?.candidates ?? []).map((each) => {
    const long = each === first ? 16 : 8;
    const path = [0, 180].map((end) =>
      line([point(each.heading + end, RIM - long), point(each.heading + end, RIM + 5)]),
    );
    return svg`<path class="candidate ${each.state}${each === first ? " leading" : ""}" data-candidate=${each.candidate}
      d=${path.join("")}><title>${candidateWords(each)}</title></path>`;
  })}</g>`;
}

/** Where a source stands seen from above: inside of the rim when it is high or low. */
const standsAt = (source) => RIM * cosine(source.elevation ?? 0);

/** Its foot on an axis: how far along it lies, which is its time difference in units of d / v. */
const footOf = (source, heading) => standsAt(source) * cosine(source.azimuth - heading);

/** From a source straight to the axis. */
function plumb(source, heading, kind) {
  const foot = point(heading, footOf(source, heading));
  return svg`<path class="plumb ${kind} ${lookOf(source.source)}" data-source=${source.source}
    d=${line([point(source.azimuth, standsAt(source)), foot])}></path>`;
}

/** The sources that pose as one at the leading heading. */
function alikeOf(plan, sources) {
  const first = leading(plan);
  const alike = first ? sources.filter((each) => first.aliased.includes(each.source)) : [];
  return alike.length > 1 ? alike : [];
}

/** Who poses as one, and where. */
export function posingWords(plan, sources) {
  const alike = alikeOf(plan, sources).map((each) => each.source);
  if (!alike.length) return nothing;
  const who =
    alike.length > 4 ? plural(alike.length, "source") : `${alike.slice(0, -1).join(", ")} and ${alike.at(-1)}`;
  return `${who} have the same delay at ${degrees(leading(plan).heading)}`;
}

/** Interferers that pose as one: at the leading heading their plumb lines meet the axis at one point, or nearly. */
export function posing(plan, sources) {
  const alike = alikeOf(plan, sources);
  if (!alike.length) return nothing;
  const { heading } = leading(plan);
  return svg`<g class="posing" aria-hidden="true">
    <path class="line" d=${line([point(heading, RIM), point(heading + 180, RIM)])}></path>
    ${alike.map((each) => plumb(each, heading, "alike"))}${alike.map((each) => foot(each, heading))}</g>`;
}

function foot(source, heading) {
  const [x, y] = point(heading, footOf(source, heading));
  return svg`<circle class="foot" r="6" cx=${x} cy=${y}></circle>`;
}

/** The time difference of the selected source: its foot on the axis of now. */
export function difference(source, heading) {
  if (!source || !known(heading)) return nothing;
  const [x, y] = point(heading, footOf(source, heading));
  return svg`<g class="difference" aria-hidden="true">${plumb(source, heading, "now")}
    <circle class="foot ${lookOf(source.source)}" r="4.5" cx=${x} cy=${y}></circle></g>`;
}

/** Its time difference in words; in microseconds when d / v is known from the densities. */
export function differenceWords(source, heading, densities) {
  const share = round(footOf(source, heading) / RIM);
  const unit = densities?.[0]?.last_us;
  return known(unit) ? `ITD ${number(share * unit)} µs` : `ITD ${number(share, 2)} d/v`;
}
