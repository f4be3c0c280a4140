/** What is wrong with the way here: no ground process, no telemetry, no log any more, an order not passed on. */

import { groundSilentFor, silentFor } from "../heard.js";
import { html, nothing } from "../lit.js";
import { duration } from "../words.js";

const SHOWN = 10000; // [ms] that a refusal stays

export function banners(page) {
  const shown = [ground(page) ?? telemetry(page) ?? advice(page), refusal(page)].filter(Boolean);
  return shown.length ? html`<section class="banners" aria-label="Notices">${shown}</section>` : nothing;
}

function ground(page) {
  const silent = groundSilentFor(page);
  if (silent === null || (!page.socket.ever && silent < 1)) return null;
  return html`<p class="banner" id="no-ground">
    <strong>No link to the ground process for ${duration(silent)}.</strong> What you see is old. The page connects again
    by itself; if it does not, look whether <code>ross ground</code> still runs.
  </p>`;
}

function telemetry(page) {
  const silent = silentFor(page);
  if (silent === null) return null;
  return html`<p class="banner" id="no-telemetry">
    <strong>No telemetry for ${duration(silent)}.</strong> What you see of ${page.route.id} is old; orders may not reach
    it. The page goes on by itself when it is heard again.${again(page)}
  </p>`;
}

/** Where to go on when all that was to be seen has been seen. */
function again({ store: { payload, flights } }) {
  if (payload?.sections.standing?.state !== "done" || !flights?.length) return nothing;
  return html` Its mission is over: <a href="#/flights">play it again.</a>`;
}

/** What is wrong though payloads are heard: the log has ended, a key is missing. */
function advice({ store: { fleet } }) {
  if (!fleet?.payloads.length || !fleet.advice) return null;
  return html`<p class="banner" id="advice">${fleet.advice}</p>`;
}

function refusal(page) {
  const latest = page.store.refusals[0];
  if (!latest || performance.now() - latest.got > SHOWN) return null;
  return html`<p class="banner" id="refusal"><strong>Not done: ${latest.what}.</strong> ${latest.reason}</p>`;
}
