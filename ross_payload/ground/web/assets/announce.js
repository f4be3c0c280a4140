/** What a screen reader hears without asking: changes only, never a value that moves all the time. */

import { saying } from "./parts/listen.js";
import { silentFor } from "./telemetry-age.js";
import { stopFate } from "./stop.js";
import { degrees, fate, state } from "./formatting.js";

let before = {};

/** Say aloud what has changed since the last drawing. */
export function announce(page) {
  const now = sayings(page);
  const news = Object.entries(now).filter(([key, words]) => words !== before[key]);
  const first = !Object.keys(before).length;
  before = now;
  if (first) return;
  say(
    "alarm",
    news.filter(([key]) => key === "alarm"),
  );
  say(
    "announcer",
    news.filter(([key]) => key !== "alarm"),
  );
}

function say(id, news) {
  const words = news
    .map(([, text]) => text)
    .filter(Boolean)
    .join(". ");
  if (words) document.getElementById(id).textContent = words;
}

function sayings(page) {
  const { store, socket, ui } = page;
  const doing = (store.payload?.sections.orders ?? []).at(-1);
  const refusal = store.refusals[0];
  return {
    alarm: stopFate(page).words,
    socket: socket.up ? "Connected to the ground process" : "No connection to the ground process",
    silent: page.over || (silentFor(page) === null ? (store.payload ? "Receiving telemetry" : "") : "No telemetry"),
    control: store.control.yours ? "You have control" : store.control.name ? `${store.control.name} has control` : "",
    state: store.payload ? state(store.payload.sections.standing?.state) : "",
    order: doing ? `${doing.words}: ${fate(doing.state)} ${doing.reason ?? ""}` : "",
    chosen: ui.chosen ? `Turn to ${degrees(ui.chosen.heading)}: confirm or cancel` : "",
    listening: store.payload ? saying(page.listening) : "",
    refused: refusal ? `Not sent: ${refusal.reason}` : "",
  };
}
