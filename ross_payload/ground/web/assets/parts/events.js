/** What the payload said, newest first. */

import { html, repeat } from "../templates.js";
import { ago, isTrouble, severity } from "../formatting.js";

const PREFIX = /^RoSS: /;

export function events(sections, now) {
  const list = sections.events ?? [];
  const newest = list.map((each, index) => ({ ...each, key: `${each.at} ${index}` })).reverse();
  const lines = repeat(
    newest,
    (each) => each.key,
    (each) => line(each, now),
  );
  return html`<div class="events" role="log" aria-label="Events, newest first" tabindex="0">
    ${
      newest.length
        ? html`<ol>
            ${lines}
          </ol>`
        : html`<p class="soft">No events yet.</p>`
    }
  </div>`;
}

function line({ at, severity: code, text }, now) {
  return html`<li class=${isTrouble(code) ? "trouble" : ""}>
    <span class="when" aria-hidden="true">${ago(now - at)}</span>
    <span>${isTrouble(code) ? html`<strong>${severity(code)}: </strong>` : ""}${text.replace(PREFIX, "")}</span>
  </li>`;
}
