/** The bar on top: where one is, who holds control, the look, and the stop. */

import { groundSilentFor } from "../heard.js";
import { html, nothing } from "../lit.js";
import { stopFate, stopTargets } from "../stop.js";
import { THEMES, keepTheme } from "../theme.js";
import { plural } from "../words.js";

const PAGES = [
  ["fleet", "#/", "Payloads"],
  ["map", "#/map", "Map"],
  ["flights", "#/flights", "Flights"],
];

export function header(page) {
  return html`<header class="topbar">
    <div class="top-pages">
      <button type="button" class="skip" @click=${() => document.querySelector("main h1")?.focus()}>
        Skip to content
      </button>
      <nav aria-label="Pages">
        <ul>
          ${PAGES.map((each) => pageLink(page, each))}
        </ul>
      </nav>
      <div class="top-tools">
        ${themeSwitch(page)}
        <button
          type="button"
          class="quiet square"
          aria-expanded=${page.ui.help}
          aria-controls="help"
          aria-label="Help"
          @click=${() => page.change({ help: !page.ui.help })}
        >
          ?
        </button>
      </div>
    </div>
    <div class="top-live">
      <p class="brand"><strong>RoSS</strong> ${standing(page)}</p>
      ${control(page)} ${stop(page)}
    </div>
  </header>`;
}

function pageLink(page, [view, address, words]) {
  const here = page.route.view === view || (view === "fleet" && page.route.view === "payload");
  const current = page.route.view === view ? "page" : here ? "true" : nothing;
  return html`<li><a href=${address} aria-current=${current}>${words}</a></li>`;
}

function standing(page) {
  if (groundSilentFor(page) !== null) return html`<span class="tag watch">no link</span>`;
  return html`<span class="tag good">${page.store.mode === "flight" ? "recordings" : "live"}</span>`;
}

function themeSwitch(page) {
  const choose = (event) => {
    keepTheme(event.target.value);
    page.change({ theme: event.target.value });
  };
  return html`<label class="theme">
    <svg viewBox="-12 -12 24 24" aria-hidden="true">
      <circle r="8"></circle>
      <path d="M0 -8A8 8 0 0 1 0 8Z"></path>
    </svg>
    <span class="unseen">Look</span>
    <select title="Look" @change=${choose}>
      ${THEMES.map((each) => html`<option value=${each} ?selected=${page.ui.theme === each}>${each}</option>`)}
    </select></label
  >`;
}

function control(page) {
  const { control: held, mayOrder } = page.store;
  if (!mayOrder) return html`<p class="control">Recordings take no orders.</p>`;
  const who = held.yours
    ? "You have control"
    : held.holder
      ? `${held.name ?? held.holder} has control`
      : "Control is free";
  const take = () => page.send({ type: "control", take: !held.yours });
  return html`<p class="control">
    <span>${who}</span>
    <button type="button" class="quiet" ?disabled=${!page.socket.up} @click=${take}>
      ${held.yours ? "Leave" : "Take"}<span class="unseen"> control</span>
    </button>
  </p>`;
}

function stop(page) {
  const targets = stopTargets(page);
  const whom =
    page.route.view === "payload" ? page.route.id : targets.length === 1 ? targets[0] : `all ${targets.length}`;
  const label =
    page.route.view === "payload" || targets.length < 2
      ? `Stop ${whom}`
      : `Stop all ${plural(targets.length, "payload")}`;
  const fate = stopFate(page);
  return html`<div class="stop-place">
    <button
      type="button"
      class="stop-button"
      aria-label=${targets.length ? label : "Stop"}
      aria-keyshortcuts="Escape Escape"
      title="Stop: Escape twice, or held"
      @click=${() => page.stop(stopTargets(page))}
    >
      STOP <small>${targets.length ? whom : ""}</small>
    </button>
    ${fate.words ? html`<p class="stop-fate ${fate.level}">${fate.words}</p>` : nothing}
  </div>`;
}
