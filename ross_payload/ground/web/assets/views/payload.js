/** One payload: the scope is the main thing; all else explains it or acts. Also drawn for recordings, without controls. */

import { isLive, lastHeard } from "../telemetry-age.js";
import { html, nothing } from "../templates.js";
import { densities } from "../instruments/densities.js";
import { isolation } from "../instruments/isolation.js";
import { scope } from "../instruments/scope.js";
import { strip } from "../instruments/mission-chart.js";
import { events } from "../parts/events.js";
import { choose, confirmation } from "../parts/chosen-heading.js";
import { commands } from "../parts/commands.js";
import { enrolment } from "../parts/enrolment.js";
import { health } from "../parts/health.js";
import { listenPanel } from "../parts/listen.js";
import { missionFacts } from "../parts/mission.js";
import { commandStatus } from "../parts/command-status.js";
import { parameters } from "../parts/parameters.js";
import { candidates, sources } from "../parts/sources.js";
import { roomy } from "../parts/tables.js";
import { ago, capital, duration, frame, known, state } from "../formatting.js";

const LONGEST = `Last state: ${state("run")}`; // of what a payload does
const MOST = ["last telemetry 59 min ago", "running for 23 h 59 min"];

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

function glance(page, { id, sections: { standing = {}, mission = {} } }) {
  const last = lastHeard(page, id);
  const words = [
    `last telemetry ${ago(last === null ? null : page.now() - last)}`,
    known(mission.time) && isLive(page) ? `running for ${duration(mission.time)}` : "",
    standing.version ? `version ${standing.version}` : "",
  ];
  const before = isLive(page) ? nothing : html`<span class="soft">Last state: </span>`;
  const most = [...MOST, words[2]].filter(Boolean).join(" · ");
  return html`<p class="now">${roomy(html`${before}<span class="state">${state(standing.state)}</span>`, LONGEST)}</p>
    <p class="soft">${roomy(words.filter(Boolean).join(" · "), most)}</p>`;
}

function everything(page, told) {
  const stale = !isLive(page) || !page.socket.up;
  const now = page.now();
  return html`<div class="payload-grid ${stale ? "stale" : ""}">
    ${picture(page, told, now, true)}
    <div class="beside">
      <div class="column">${missionFacts(told.sections)}${commands(page, told)}${commandStatus(page, told)}</div>
      ${said(page, told, now, true)}
    </div>
    ${curves(page, told, now)}${condition(told, now, stale)}${parameters(page, told)}
  </div>
  ${enrolment(page, told)}`;
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
  if (heard.includes(id)) return html`<p class="opening">Loading…</p>`;
  return html`<p class="opening">No telemetry from ${id} yet. ${page.store.fleet?.advice ?? ""}</p>
    <p><a href="#/">All payloads</a></p>`;
}

const sentence = (words) => `${capital(words)}.`;

/** What is odd, in words. */
function remarks({ standing = {}, sources: list = [] }) {
  const announced = list[0]?.announced ?? 0;
  const words = [
    standing.mirrors_only &&
      "This link carries only the summary values, so the polar view and the sources are missing. " +
        "An autopilot in between drops ROSS_ messages: set the payload’s link to TUNNEL.",
    standing.boots > 1 && `The payload restarted (${standing.boots} starts seen); its earlier results are gone.`,
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
    drag: mayOrder ? (ui.drag ?? ui.chosen?.heading ?? null) : null,
    mayOrder: mayOrder && page.store.mayOrder,
    onSelect: (source) => page.change({ selected: ui.selected === source ? null : source }),
    onHover: (source) => page.change({ hovered: source }),
    onDrag: (heading) => page.change({ drag: heading, chosen: null }),
    onChoose: (heading) => choose(page, told, heading),
    onTurn: (heading) => {
      page.change({ drag: null, chosen: null });
      page.order(told.id, { kind: "turn", heading: Math.round(heading) % 360 });
    },
  };
  return html`<section class="hero" aria-label="Polar view">
    <h2 class="unseen">Polar view: sources and axis</h2>
    ${scope(parts)} ${mayOrder ? confirmation(page, told) : nothing}
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
    ${mayOrder ? listenPanel(page, told) : nothing} ${card("Events", events(sections, now))}
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
            ${card("ITD densities", densities({ sections, now }))}
            ${card("Isolation", html`${isolation({ sections, now, ...moved })}${candidates(sections)}`)}
          </div>`
    }
  </div>`;
}

const condition = (told, now, silent = false) =>
  html`<section class="wide">
    <h2>Health</h2>
    ${health(told, now, silent)}
  </section>`;
