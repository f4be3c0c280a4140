/** Every payload that is heard, and the links they are heard on. */

import { html, nothing } from "../templates.js";
import { byId } from "../parts/by-id.js";
import { fact, table } from "../parts/tables.js";
import { payloadAddress } from "../route.js";
import { DASH, ago, degrees, duration, known, level, number, plural, share, size, state } from "../formatting.js";

const OLD = 2; // [s]

export function fleetView(page) {
  const { fleet, mode } = page.store;
  const list = fleet?.payloads ?? [];
  return html`<h1 tabindex="-1">Payloads</h1>
    ${
      list.length
        ? html`<p class="opening">${plural(list.length, "payload")} found.</p>
            <ul class="fleet">
              ${list.map((each) => card(page, each))}
            </ul>`
        : nobody(fleet, mode)
    }
    ${byId(page)} ${fleet?.links?.length ? links(page, fleet.links) : nothing}`;
}

function nobody(fleet, mode) {
  if (mode === "flight")
    return html`<p class="opening">No link is open. <a href="#/flights">Open a recorded flight</a></p>`;
  return html`<p class="opening">No payload found.</p>
    <p>${fleet?.advice || "Waiting for telemetry."}</p>`;
}

function card(page, each) {
  const age = page.now() - each.last;
  const old = age > OLD;
  const health = old ? "unknown" : each.health_level;
  const facts = [
    ["Sources (K)", number(each.k)],
    ["Target", known(each.target) ? `Source ${each.target}` : DASH],
    [
      "Heading",
      html`${degrees(each.heading)}<span class="soft"> ${each.earth ? "from north" : "from the nose"}</span>`,
    ],
    ["Last telemetry", ago(age)],
  ];
  return html`<li class="card part ${health} ${old ? "stale" : ""}">
    <h2><a href=${payloadAddress(each.id)}>Payload ${each.id}</a></h2>
    <p class="state">
      ${old ? html`<span class="soft">Last state:</span>` : nothing} ${state(each.state)}
      <span class="tag ${health}">Health: ${level(health)}</span>
    </p>
    ${each.twin ? html`<p class="bad">${twins(each.id)}</p>` : nothing}
    ${old ? html`<p><strong>${page.over || `No telemetry for ${duration(age)}.`}</strong></p>` : nothing}
    <dl class="facts">
      ${facts.map(fact)}
    </dl>
    ${each.actuator ? html`<p class="soft">Actuator: ${each.actuator}</p>` : nothing}
  </li>`;
}

const twins = (id) =>
  `Two payloads use the id ${id}: give one of them a different system_id, or a different component_id on the same vehicle.`;

function links(page, list) {
  return html`<section>
    <h2>Links of this ground station</h2>
    ${table(
      "Table of links",
      "stack broad",
      ["Link", "State", "Messages", "Bandwidth", "Lost", "Last message"],
      list.map(
        (each) =>
          html`<tr>
            <th scope="row"><code>${each.url}</code></th>
            <td data-name="State">${each.up ? "open" : each.error || "not open"}</td>
            <td data-name="Messages">${number(each.frames_s, 0, " /s")}</td>
            <td data-name="Bandwidth">${known(each.bytes_s) ? `${size(each.bytes_s)}/s` : DASH}</td>
            <td data-name="Lost">${known(each.loss) ? share(each.loss) : "unknown"}</td>
            <td data-name="Last message">${known(each.last) ? ago(page.now() - each.last) : "never"}</td>
          </tr>`,
      ),
    )}
  </section>`;
}
