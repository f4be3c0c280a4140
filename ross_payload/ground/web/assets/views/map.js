/** Where payloads are and where their bearings cross: a grid in metres, over the map that the user gave, if any. */

import { fitting, metres, scaleOf, zoomed } from "../geography.js";
import { html, nothing } from "../templates.js";
import { drawing } from "../parts/map-drawing.js";
import { degrees, known, number } from "../formatting.js";
import { table } from "../parts/tables.js";

const STEP = 60; // [px] that an arrow key moves
const ZOOM = 1.4;
const APART = 20; // [m] between payloads of which no position is known

export function mapView(page) {
  const scene = sceneOf(page.store);
  const look = page.ui.map ?? lookAt(scene, page.ui.mapSize);
  return html`<h1 tabindex="-1">Map</h1>
    ${
      scene.placed
        ? nothing
        : html`<p class="opening">
            No payload position is known yet. It comes from an autopilot on the link, or can be entered below.
          </p>`
    }
    ${frame(page, scene, look)}
    ${scene.tiles?.attribution ? html`<p class="soft caption">Map: ${scene.tiles.attribution}</p>` : nothing}
    ${scene.placed ? found(scene) : nothing} ${places(page, scene)}`;
}

/** All places, or the map that was given where there are none. */
function lookAt({ points, placed, tiles }, size) {
  const look = fitting(points, size);
  return placed || !tiles ? look : { ...look, scale: scaleOf(tiles.maxzoom, tiles.center) };
}

/** Everything in metres about the first place, else about the middle of the map; ghosts last. */
function sceneOf({ fleet, tiles }) {
  const places = Object.entries(fleet?.places ?? {}).filter(([, { lat, lon }]) => known(lat) && known(lon));
  const placed = places.length > 0;
  const origin = placed ? places[0][1] : (tiles?.center ?? null);
  const stands = placed
    ? places.map(([id, place]) => ({ id, place, at: metres(origin, place), ...payloadOf(fleet, id) }))
    : (fleet?.payloads ?? []).map(({ id }, index, all) => assumed(fleet, id, index - (all.length - 1) / 2));
  const crossed = placed ? (fleet.fixes ?? []).map((fix) => ({ ...fix, at: metres(origin, fix) })) : [];
  const fixes = crossed.toSorted((one, other) => one.ghost - other.ghost);
  const points = [...stands, ...fixes.filter((fix) => !fix.ghost)].map(({ at }) => at);
  return { origin, placed, stands, fixes, points, tiles };
}

/** A payload of which no position is known: in the middle, side by side with others. */
const assumed = (fleet, id, place) => ({ id, at: [place * APART, 0], ...payloadOf(fleet, id), assumed: true });

function payloadOf(fleet, id) {
  const payload = fleet.payloads.find((each) => each.id === id) ?? {};
  return {
    heading: payload.heading ?? null,
    earth: payload.earth ?? false,
    bearings: (fleet.bearings ?? []).filter((each) => each.id === id),
  };
}

function frame(page, scene, look) {
  const size = page.ui.mapSize;
  const move = (to) => page.change({ map: to });
  const button = (label, sign, to) =>
    html`<button type="button" aria-label=${label} title=${label} @click=${() => move(to)}>${sign}</button>`;
  return html`<div class="map-frame">
    <div
      class="map"
      tabindex="0"
      role="group"
      aria-label="Map: arrows move it, plus and minus zoom, 0 shows all"
      @keydown=${(event) => keyed(event, look, size, move)}
      @wheel=${(event) => wheeled(event, look, size, move)}
      @pointermove=${(event) => dragged(event, look, move)}
      @pointerdown=${(event) => grabbed(event)}
    >
      ${drawing(scene, look, size)}
    </div>
    <div class="map-buttons">
      ${button("Zoom in", "+", zoomed(look, size, ZOOM))}${button("Zoom out", "−", zoomed(look, size, 1 / ZOOM))}
      ${button("Show everything", "⤢", null)}
    </div>
  </div>`;
}

function keyed(event, look, size, move) {
  const by = STEP / look.scale;
  const looks = {
    ArrowLeft: { ...look, x: look.x - by },
    ArrowRight: { ...look, x: look.x + by },
    ArrowUp: { ...look, y: look.y + by },
    ArrowDown: { ...look, y: look.y - by },
    "+": zoomed(look, size, ZOOM),
    "=": zoomed(look, size, ZOOM),
    "-": zoomed(look, size, 1 / ZOOM),
    0: null,
  };
  if (!(event.key in looks) || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  move(looks[event.key]);
}

function wheeled(event, look, size, move) {
  event.preventDefault();
  const box = event.currentTarget.getBoundingClientRect();
  move(zoomed(look, size, event.deltaY < 0 ? 1.15 : 1 / 1.15, [event.clientX - box.left, event.clientY - box.top]));
}

const grabbed = (event) => event.currentTarget.setPointerCapture(event.pointerId);

function dragged(event, look, move) {
  if (!event.buttons || !event.isPrimary) return;
  move({ ...look, x: look.x - event.movementX / look.scale, y: look.y + event.movementY / look.scale });
}

/** The crossings as a table, for those who do not see the map. */
function found({ fixes }) {
  if (!fixes.length)
    return html`<p class="soft">
      No crossing bearings. They need two payloads with known positions and headings that hear the same source.
    </p>`;
  return html`<section class="card">
    <h2>Crossing bearings</h2>
    ${table(
      "Table of crossings",
      "crossings stack",
      ["Crossing", "Position", "Uncertainty", "Heard by"],
      fixes.map(
        (fix, index) =>
          html`<tr>
            <th scope="row">${nameOf(fix, index)}</th>
            <td data-name="Position">${number(fix.lat, 6, "°")}, ${number(fix.lon, 6, "°")}</td>
            <td data-name="Uncertainty">${number(spreadOf(fix), 1, " m")}</td>
            <td data-name="Heard by">${fix.payloads.map((id, each) => `${id} source ${fix.sources[each]}`).join(", ")}</td>
          </tr>`,
      ),
    )}
  </section>`;
}

const nameOf = (fix, index) => `${index + 1}${fix.ghost ? " (probably a ghost)" : ""}`;
const spreadOf = ({ covariance: [[a], [, c]] }) => Math.sqrt(a + c);

function places(page, { stands }) {
  const payloads = page.store.fleet?.payloads ?? [];
  if (!payloads.length) return html`<p class="soft">No payload found.</p>`;
  return html`<section class="card">
    <h2>Payload positions</h2>
    <ul class="places">
      ${payloads.map(({ id }) => position(id, stands.find((stand) => stand.id === id)?.place))}
    </ul>
    ${placeForm(page, payloads)}
  </section>`;
}

function position(id, place) {
  if (!place) return html`<li><strong>${id}</strong> <span class="soft">position unknown</span></li>`;
  return html`<li>
    <strong>${id}</strong>
    ${number(place.lat, 6, "°")},
    ${number(place.lon, 6, "°")}${known(place.heading) ? html`, heading ${degrees(place.heading)}` : nothing}
    <span class="soft">${place.from === "typed" ? "entered by hand" : "from the autopilot"}</span>
  </li>`;
}

function placeForm(page, payloads) {
  const field = (name, words, least, most, required) =>
    html`<label
      >${words}
      <input name=${name} type="number" min=${least} max=${most} step="any" inputmode="decimal" ?required=${required}
    /></label>`;
  return html`<form class="place-form" @submit=${(event) => placed(page, event)}>
    <label
      >Payload
      <select name="id" aria-label="Payload">
        ${payloads.map((each) => html`<option>${each.id}</option>`)}
      </select></label
    >
    ${field("lat", "Latitude, degrees north", -90, 90, true)}${field("lon", "Longitude, degrees east", -180, 180, true)}
    ${field("heading", "Heading of the payload's nose, degrees from north (optional)", -360, 360, false)}
    <button type="submit" ?disabled=${!page.socket.up}>Set position</button>
  </form>`;
}

function placed(page, event) {
  event.preventDefault();
  const { id, lat, lon, heading } = event.target.elements;
  const angle = Number.isNaN(heading.valueAsNumber) ? null : heading.valueAsNumber;
  page.send({ type: "place", id: id.value, lat: lat.valueAsNumber, lon: lon.valueAsNumber, heading: angle });
}
