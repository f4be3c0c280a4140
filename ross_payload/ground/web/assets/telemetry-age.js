/** Since when nothing was heard of a payload. */

const SILENT = 2; // [s]

/** When a payload was last heard, on the ground process's clock [s]; null: never. */
export function lastHeard(page, id) {
  const there = (page.store.fleet?.payloads ?? []).find((each) => each.id === id);
  const told = page.store.payload?.id === id ? page.store.payload.sections.standing?.last : null;
  const times = [there?.last, told].filter((each) => typeof each === "number");
  return times.length ? Math.max(...times) : null;
}

/** Seconds without telemetry of the payload on the screen, once they are too many; else null. */
export function silentFor(page) {
  if (page.route.view !== "payload") return null;
  const last = lastHeard(page, page.route.id);
  const now = page.now();
  return last === null || now === null || now - last <= SILENT ? null : now - last;
}

/** Whether telemetry comes now: of the payload on the screen, elsewhere of any. */
export function isLive(page) {
  if (page.over) return false;
  const { view, id } = page.route;
  const ids = view === "payload" ? [id] : (page.store.fleet?.payloads ?? []).map((each) => each.id);
  const now = page.now();
  return now !== null && ids.map((each) => lastHeard(page, each)).some((last) => last !== null && now - last <= SILENT);
}

/** Seconds without the ground process, once they are too many or the socket is closed; else null. */
export function groundSilentFor(page) {
  const silence = page.silence();
  if (page.socket.up && (silence === null || silence <= SILENT)) return null;
  return silence ?? (performance.now() - page.socket.since) / 1000;
}
