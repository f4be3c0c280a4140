/** Which view the address names: `#/`, `#/payload/1-191`, `#/map`, `#/flights`. */

const BYTE = "([1-9]|[1-9]\\d|1\\d\\d|2[0-4]\\d|25[0-5])";

/** Pattern of a payload's id: MAVLink ids of its system and its component. */
export const ID = `${BYTE}-${BYTE}`;

/** @returns {{view: string, id: ?string}} the fleet for an address that names nothing */
export function routeOf(hash) {
  const [, view = "", id = ""] = hash.split("/");
  if (view === "payload" && new RegExp(`^${ID}$`).test(id)) return { view, id };
  return view === "map" || view === "flights" ? { view, id: null } : { view: "fleet", id: null };
}

const TITLES = { fleet: "Payloads", map: "Map", flights: "Flights" };

/** What a window on this view is called. */
export const titleOf = ({ view, id }) => (id ? `Payload ${id}` : TITLES[view]);

export const payloadAddress = (id) => `#/payload/${id}`;
