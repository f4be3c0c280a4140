/** One payload: the scope is the main thing; all else explains it or acts. Also drawn for recordings, without hands. */

import { lastHeard, silentFor } from "../heard.js";
import { html, nothing } from "../lit.js";
import { densities } from "../instruments/densities.js";
import { isolation } from "../instruments/isolation.js";
import { scope } from "../instruments/scope.js";
import { strip } from "../instruments/strip.js";
import { events } from "../parts/events.js";
import { hands } from "../parts/hands.js";
import { health } from "../parts/health.js";
import { missionFacts } from "../parts/mission.js";
import { orders } from "../parts/orders.js";
import { parameters } from "../parts/parameters.js";
import { candidates, sources } from "../parts/sources.js";
import { ago, frame, state } from "../words.js";

/** The watched payload, live. */
export function payloadView(page) {
  const { id } = page.route;
  const told = page.store.payload;
  return html`<div class="payload-title">
      <h1 tabindex="-1">Payload ${id}</h1>
      ${told ? glance(page, told) : nothing}
    </div>
    ${told ? html`${remarks(told.sections)}${everything(page, told)}` : waiting(page, id)}`;
}

function glance(page, { id, sections: { standing = {} } }) {
  const last = lastHeard(page, id);
  return html`<p class="state">${state(standing.state)}</p>
    <p class="soft">
      last heard
      ${ago(last === null ? null : page.now() - last)}${standing.version ? ` · version ${standing.version}` : ""}
    </p>`;
}

function everything(page, told) {
  const stale = silentFor(page) !== null || !page.socket.up;
  const now = page.now();
  return html`<div class="payload-grid ${stale ? "stale" : ""}">
    ${picture(page, told, now, true)}
    <div class="beside">
      <div class="column">${missionFacts(told.sections)}${hands(page, told)}${orders(page, told)}</div>
      ${said(page, told, now, true)}
    </div>
    ${curves(page, told, now)}${condition(told, now)}${parameters(page, told)}
  </div>`;
}

/** A payload of a recording at one moment. */
export function recordedView(page, told) {
  return html`<div class="payload-grid recorded">
    ${picture(page, told, told.now, false)}
    <div class="beside">
      <div class="column">${missionFacts(told.sections)}</div>
      ${said(page, told, told.now, false)}
    </div>
    ${curves(page, told, told.now)}${condition(told, told.now)}
  </div>`;
}

function waiting(page, id) {
  const heard = (page.store.fleet?.payloads ?? []).map((each) => each.id);
  if (heard.includes(id)) return html`<p class="opening">Its picture comes.</p>`;
  return html`<p class="opening">Nothing was heard of ${id} yet. ${page.store.fleet?.advice ?? ""}</p>
    <p><a href="#/">All payloads that are heard</a></p>`;
}

const sentence = (words) => `${words.charAt(0).toUpperCase()}${words.slice(1)}.`;

/** What is odd, in words. */
function remarks({ standing = {}, sources: list = [] }) {
  const announced = list[0]?.announced ?? 0;
  const words = [
    standing.mirrors_only &&
      "Only mirrored values come through this link: no picture, and no sources. " +
        "An autopilot in between drops our messages; set the payload’s link to TUNNEL.",
    standing.boots > 1 && `It has started again (${standing.boots} starts were heard); what it knew before is gone.`,
    announced > list.length && announced > 32 && `${announced} sources announced, ${list.length} shown.`,
    ...(standing.flaws ?? []).map(sentence),
  ].filter(Boolean);
  return words.length
    ? html`<ul class="remarks" aria-label="Remarks">
        ${words.map((each) => html`<li>${each}</li>`)}
      </ul>`
    : nothing;
}

function picture(page, told, now, mayOrder) {
  const { sections } = told;
  const { ui } = page;
  const parts = {
    sections,
    now,
    selected: ui.selected,
    hovered: ui.hovered,
    drag: mayOrder ? ui.drag : null,
    mayOrder: mayOrder && page.store.mayOrder,
    onSelect: (source) => page.change({ selected: ui.selected === source ? null : source }),
    onHover: (source) => page.change({ hovered: source }),
    onDrag: (heading) => page.change({ drag: heading }),
    onTurn: (heading) => {
      page.change({ drag: null });
      page.order(told.id, { kind: "turn", heading: Math.round(heading) % 360 });
    },
  };
  return html`<section class="hero" aria-label="What it hears">
    <h2 class="unseen">What it hears, and where it points</h2>
    ${scope(parts)}
    <p class="soft caption">Degrees ${frame(sections.pointing?.earth)}.</p>
  </section>`;
}

const card = (name, content) =>
  html`<section class="card">
    <h2>${name}</h2>
    ${content}
  </section>`;

function said(page, told, now, mayOrder) {
  const { sections } = told;
  return html`<div class="column">
    ${sections.standing?.mirrors_only ? nothing : card("Sources", sources(page, told, mayOrder))}
    ${card("Events", events(sections, now))}
  </div>`;
}

/** What the mission measured, as curves. */
function curves(page, told, now) {
  const { sections } = told;
  const moved = { cursor: page.ui.cursor, onCursor: (heading) => page.change({ cursor: heading }) };
  return html`<div class="below">
    ${card("Mission over time", strip({ sections, now }))}
    ${
      sections.standing?.mirrors_only
        ? nothing
        : html`<div class="pair">
            ${card("Densities", densities({ sections, now }))}
            ${card("Isolation", html`${isolation({ sections, now, ...moved })}${candidates(sections)}`)}
          </div>`
    }
  </div>`;
}

const condition = (told, now) =>
  html`<section class="wide">
    <h2>Health</h2>
    ${health(told, now)}
  </section>`;
