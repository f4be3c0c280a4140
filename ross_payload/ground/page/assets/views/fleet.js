/** Every payload that is heard, and the links they are heard on. */

import { html, nothing } from "../lit.js";
import { fact } from "../parts/facts.js";
import { payloadAddress } from "../route.js";
import { DASH, ago, degrees, known, level, number, plural, share, size, state } from "../words.js";

const OLD = 2; // [s]

export function fleetView(page) {
  const { fleet, mode } = page.store;
  const list = fleet?.payloads ?? [];
  return html`<h1 tabindex="-1">Payloads</h1>
    ${
      list.length
        ? html`<p class="opening">${plural(list.length, "payload")} heard.</p>
            <ul class="fleet">
              ${list.map((each) => card(page, each))}
            </ul>`
        : nobody(fleet, mode)
    }
    ${fleet?.links?.length ? links(page, fleet.links) : nothing}`;
}

function nobody(fleet, mode) {
  if (mode === "flight")
    return html`<p class="opening">No link is listened to. <a href="#/flights">Look at recorded flights.</a></p>`;
  return html`<p class="opening">No payload is heard.</p>
    <p>${fleet?.advice || "The page waits for the ground process."}</p>`;
}

function card(page, each) {
  const age = page.now() - each.last;
  const facts = [
    ["K", number(each.k)],
    ["Target", known(each.target) ? `source ${each.target}` : DASH],
    [
      "Heading",
      html`${degrees(each.heading)}<span class="soft"> ${each.earth ? "from north" : "from the mount’s zero"}</span>`,
    ],
    ["Heard", ago(age)],
  ];
  return html`<li class="card part ${each.health_level} ${age > OLD ? "stale" : ""}">
    <h2><a href=${payloadAddress(each.id)}>Payload ${each.id}</a></h2>
    <p class="state">
      ${state(each.state)} <span class="tag ${each.health_level}">health: ${level(each.health_level)}</span>
    </p>
    ${each.twin ? html`<p class="bad">${twins(each.id)}</p>` : nothing}
    ${age > OLD ? html`<p><strong>No telemetry for ${number(age, 0, " s")}.</strong></p>` : nothing}
    <dl class="facts">
      ${facts.map(fact)}
    </dl>
    ${each.actuator ? html`<p class="soft">Turns by ${each.actuator}</p>` : nothing}
  </li>`;
}

const twins = (id) =>
  `Two payloads speak as ${id}: give one another system_id, or on one vehicle another component_id.`;

function links(page, list) {
  return html`<section>
    <h2>Links of this computer</h2>
    <div class="scroll" tabindex="0" role="region" aria-label="Table of links">
      <table>
        <thead>
          <tr>
            <th scope="col">Link</th>
            <th scope="col">State</th>
            <th scope="col">Messages</th>
            <th scope="col">Bandwidth</th>
            <th scope="col">Lost</th>
            <th scope="col">Last heard</th>
          </tr>
        </thead>
        <tbody>
          ${list.map(
            (each) =>
              html`<tr>
                <th scope="row"><code>${each.url}</code></th>
                <td>${each.up ? "open" : each.error || "not open"}</td>
                <td>${number(each.frames_s, 0, " /s")}</td>
                <td>${known(each.bytes_s) ? `${size(each.bytes_s)}/s` : DASH}</td>
                <td>${known(each.loss) ? share(each.loss) : "unknown"}</td>
                <td>${known(each.last) ? ago(page.now() - each.last) : "never"}</td>
              </tr>`,
          )}
        </tbody>
      </table>
    </div>
  </section>`;
}
