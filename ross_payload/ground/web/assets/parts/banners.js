/** What is wrong with the way here: no ground process, no telemetry, no log any more; and commands that came to nothing. */

import { groundSilentFor, silentFor } from "../telemetry-age.js";
import { html, nothing } from "../templates.js";
import { capital, duration } from "../formatting.js";
import { comparable } from "./flight-tracks.js";
import { isStopping } from "../stop.js";

const SHOWN = 10; // [s] that a refusal stays
const BAD = { refused: "Refused", failed: "Failed", no_answer: "No answer" };

/** They stay at the end of the window while the page scrolls: what was refused is seen wherever it was asked for. */
export function banners(page) {
  const state = ground(page) ?? ended(page) ?? telemetry(page) ?? advice(page);
  const shown = [state, failure(page), refusal(page)].filter(Boolean);
  return shown.length ? html`<section class="banners" aria-label="Notices" tabindex="0">${shown}</section>` : nothing;
}

function ground(page) {
  const silent = groundSilentFor(page);
  if (silent === null || (!page.socket.ever && silent < 1)) return null;
  return html`<p class="banner" id="no-ground">
    <strong>No connection to the ground process for ${duration(silent)}.</strong> What you see is out of date. The page
    reconnects by itself; if it does not, check that <code>ross ground</code> is still running.
  </p>`;
}

/** A simulation that is over: nothing here is live any more, and nothing is wrong. */
function ended(page) {
  if (!page.over) return null;
  return html`<p class="banner" id="ended">
    <strong>${page.over}</strong> This is the last state received.${again(page)}${page.route.view === "flights" ? nothing : hear(page)}
  </p>`;
}

function telemetry(page) {
  const silent = silentFor(page);
  if (silent === null) return null;
  return html`<p class="banner" id="no-telemetry">
    <strong>No telemetry for ${duration(silent)}.</strong> This is the last state received from ${page.route.id};
    commands may not reach it. The page updates as soon as telemetry returns.
  </p>`;
}

/** Where to go on when all that was to be seen has been seen. */
const again = ({ store: { flights } }) =>
  flights?.length ? html` <a href="#/flights">Replay the mission</a>` : nothing;

/** With one press: what the microphones heard, and then the target. */
function hear(page) {
  const flight = comparable(page);
  if (!flight) return nothing;
  const press = () => page.flightSound.openAndCompare(page, flight.name);
  return html` <button type="button" @click=${press}>Hear before and after</button>`;
}

/** What is wrong though telemetry arrives: the log has ended, a key is missing. */
function advice({ store: { fleet } }) {
  if (!fleet?.payloads.length || !fleet.advice) return null;
  return html`<p class="banner" id="advice">${fleet.advice}</p>`;
}

/** The latest command that the payload refused, did not finish, or did not answer. */
function failure(page) {
  const { orders = [], standing } = page.store.payload?.sections ?? {};
  const rests = standing?.state === "stopped"; // then nothing is wrong with a stop that was not answered
  const bad = orders.filter((each) => each.state in BAD && !(rests && each.words === "stop"));
  if (!bad.length) return null;
  const latest = bad.reduce((one, other) => (other.at >= one.at ? other : one));
  if (page.now() - latest.at > SHOWN) return null;
  return html`<p class="banner" id="failure">
    <strong>${BAD[latest.state]}: ${latest.words}.</strong> ${stillSent(page, latest)}${sentence(latest.reason)}
  </p>`;
}

const stillSent = (page, { words }) =>
  words === "stop" && isStopping(page, page.store.payload.id) ? "It is still being sent. " : "";
const sentence = (words) => (words ? `${capital(words)}.` : "");

function refusal(page) {
  const latest = page.store.refusals[0];
  if (!latest || performance.now() - latest.got > SHOWN * 1000) return null;
  return html`<p class="banner" id="refusal"><strong>Not sent: ${latest.what}.</strong> ${sentence(latest.reason)}</p>`;
}
