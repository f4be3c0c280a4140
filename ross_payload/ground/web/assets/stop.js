/** Whom a stop is for, and what became of it. */

import { isOver } from "./formatting.js";

const SHOWN = 8; // [s] that an answer stays beside the button
export const SAID_AGAIN = 30_000; // [ms] after which a stop is no longer repeated when the link is back
const NAMED = 4; // of payloads that have not stopped, by name
const UNTOLD = ["", "fault"]; // states of a payload that may stand still, or not

/** The payload on the screen, else all of them. @returns {string[]} */
export function stopTargets(page) {
  if (page.route.view === "payload") return [page.route.id];
  return (page.store.fleet?.payloads ?? []).map((each) => each.id);
}

/** @returns {{words: string, level: string}} what became of the latest stop; empty words: none lately */
export function stopFate(page) {
  const { stop } = page.ui;
  if (!stop) return NONE;
  if (page.store.fleet?.over) return lately(stop.at) ? { words: OVER, level: "watch" } : NONE;
  if (stop.waiting) return { words: "No connection: will be sent on reconnection", level: "act" };
  if (!stop.ids.length) return lately(stop.at) ? { words: "No payload to stop: no telemetry received", level: "act" } : NONE;
  if (stop.confirmed) return rests(page, stop.ids) || lately(stop.confirmed) ? STOPPED : NONE;
  const fates = stop.ids.map((id) => fateOf(page, id, stop));
  if (fates.every((each) => each === "stopped")) return STOPPED;
  const bad = fates.filter((each) => each !== "stopped" && each !== "sent");
  if (!bad.length) return { words: "Stop sent", level: "watch" };
  const more = bad.length > NAMED ? `; and ${bad.length - NAMED} more` : "";
  const otherwise = bad.length > 1 ? "stop them by other means" : "stop it by other means";
  return { words: `${bad.slice(0, NAMED).join("; ")}${more}: ${otherwise}`, level: "act" };
}

/** Whether a stop is being sent to a payload, which has not acknowledged it. */
export const isStopping = (page, id) => (page.store.fleet?.stopping ?? []).includes(id);

/**
 * The latest stop, with the time at which all whom it was for were stopped, once they were; null once one of them has
 * been armed again since. A stop that is still being sent is not over: telemetry may have been on its way for long.
 */
export function followed(page) {
  const { stop } = page.ui;
  if (!stop) return stop;
  if (!stop.confirmed) return stopFate(page) === STOPPED ? { ...stop, confirmed: performance.now() } : stop;
  if (rests(page, stop.ids)) return stop.rested ? stop : { ...stop, rested: true };
  if (!stop.rested) return stop;
  return stop.ids.some((id) => isStopping(page, id)) ? { ...stop, confirmed: null, rested: false } : null;
}

/**
 * The latest stop, with those whom it has stopped so far: a payload that is armed again is not stopped once more, and
 * is stopped no more, whoever armed it, while the stop of another one goes on.
 */
export function noted(page) {
  const { stop } = page.ui;
  if (!stop || stop.confirmed) return stop;
  const moves = (stop.resting ?? []).filter((id) => !["stopped", ...UNTOLD].includes(rowOf(page, id)?.state ?? ""));
  const armed = moves.filter((id) => !isStopping(page, id));
  const left = armed.reduce(rearmed, stop);
  if (!left) return left;
  const known = left.stopped.filter((id) => !moves.includes(id));
  const stopped = left.ids.filter((id) => known.includes(id) || fateOf(page, id, left) === "stopped");
  const resting = stopped.filter((id) => !moves.includes(id) && (left.resting?.includes(id) || rests(page, [id])));
  return { ...left, stopped, resting };
}

/**
 * Whom the latest stop has not stopped so far, while it is said again, and since when: a stop of others takes nothing
 * of it back.
 */
export function unstopped(stop, others) {
  if (!stop || stop.confirmed) return {};
  const ids = stop.ids.filter((id) => !stop.stopped.includes(id) && !others.includes(id));
  const since = ids.map((id) => [id, givenAt(stop, id)]);
  return Object.fromEntries(since.filter(([, { at }]) => stop.waiting || performance.now() - at < SAID_AGAIN));
}

/**
 * The latest stop, when the link is lost: one of which the ground process has not told may never have reached it, and
 * is sent when the link is back, as one that was pressed without it.
 */
export function doubted(page) {
  const { stop } = page.ui;
  if (!stop || stop.confirmed || page.store.fleet?.over) return stop;
  const doubtful = Object.entries(unstopped(stop, [])).some(([id, { now }]) => !toldStop(page, id, now));
  return doubtful ? { ...stop, waiting: true } : stop;
}

/** A stop, if any, after a payload was armed again: it is stopped no more, and is not stopped once more. */
export function rearmed(stop, id) {
  if (!stop?.ids.includes(id)) return stop;
  const ids = stop.ids.filter((each) => each !== id);
  return stop.confirmed || !ids.length ? null : { ...stop, ids };
}

const OVER = "The simulation has ended: there is nothing to stop";
const NONE = { words: "", level: "" };
const STOPPED = { words: "Stopped", level: "good" };
const lately = (at) => performance.now() - at < SHOWN * 1000;
const rowOf = (page, id) => (page.store.fleet?.payloads ?? []).find((each) => each.id === id);
const rests = (page, ids) => ids.every((id) => rowOf(page, id)?.state === "stopped");

/** When a payload was to be stopped: on the clock of the browser [ms], and on that of the ground process [s]. */
const givenAt = (stop, id) => stop.earlier?.[id] ?? { at: stop.at, now: stop.now };

const watchedOrders = (page, id) => (page.store.payload?.id === id ? page.store.payload.sections.orders : null);

/** The latest stop of a payload, given at a time [s] or later, of which the ground process has told. */
const toldStop = (page, id, since) =>
  latestStop(watchedOrders(page, id) ?? (page.store.fleet?.stops ?? []).filter((each) => each.id === id), since);

function fateOf(page, id, stop) {
  const { at, now } = givenAt(stop, id);
  const watched = watchedOrders(page, id);
  const doing = toldStop(page, id, now);
  if (doing?.state === "done" || doing?.state === "acknowledged") return "stopped";
  const row = rowOf(page, id);
  if (row?.state === "stopped" && !((row.state_at ?? row.last) < now)) return "stopped"; // what was told before the stop tells nothing
  const still = isStopping(page, id) ? ", still being sent" : "";
  if (watched && doing && isOver(doing.state)) return (doing.state !== "no_answer" && doing.reason) || `No answer${still}`;
  if (lately(at)) return "sent";
  const untold = row && UNTOLD.includes(row.state ?? "");
  if (untold && !(doing && isOver(doing.state))) return "sent";
  return `${untold ? `No answer from ${id}` : row ? `${id} has not stopped` : `No telemetry from ${id}`}${still}`;
}

/** The latest stop of these orders, if any, that was given at a time [s] or later. */
export function latestStop(orders, since) {
  const stops = (orders ?? []).filter((each) => each.words === "stop" && each.since >= (since ?? 0) - 1);
  return stops.at(-1) ?? null;
}
