/** Which view the address names: `#/`, `#/payload/1-191`, `#/map`, `#/flights`. */

/** @returns {{view: string, id: ?string}} the fleet for an address that names nothing */
export function routeOf(hash) {
  const [, view = "", id = ""] = hash.split("/");
  if (view === "payload" && /^\d{1,3}-\d{1,3}$/.test(id)) return { view, id };
  return view === "map" || view === "flights" ? { view, id: null } : { view: "fleet", id: null };
}

const TITLES = { fleet: "Payloads", map: "Map", flights: "Flights" };

/** What a window on this view is called. */
export const titleOf = ({ view, id }) => (id ? `Payload ${id}` : TITLES[view]);

export const payloadAddress = (id) => `#/payload/${id}`;
