/** The bar on top: where one is, who holds control, the theme, and the stop. */

import { groundSilentFor, isLive } from "../telemetry-age.js";
import { html, nothing } from "../templates.js";
import { stopFate, stopTargets } from "../stop.js";
import { THEMES, keepTheme } from "../theme.js";
import { plural } from "../formatting.js";
import { roomy } from "./tables.js";

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
  const [level, words] = standingOf(page);
  return roomy(html`<span class="tag ${level}">${words}</span>`, "No connection");
}

/** Whether what is shown is of now, in a word. */
function standingOf(page) {
  if (groundSilentFor(page) !== null) return ["watch", "No connection"];
  if (page.store.mode === "flight") return ["good", "Recordings"];
  if (page.over) return ["unknown", "Ended"];
  return isLive(page) ? ["good", "Live"] : ["watch", "No telemetry"];
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
    <span class="unseen">Theme</span>
    <select title="Theme" @change=${choose}>
      ${THEMES.map((each) => html`<option value=${each} ?selected=${page.ui.theme === each}>${each}</option>`)}
    </select></label
  >`;
}

function control(page) {
  const { control: held, mayOrder } = page.store;
  if (!mayOrder) return html`<p class="control">Recordings do not accept commands.</p>`;
  if (page.over) return html`<p class="control">${page.over}</p>`;
  const who = held.yours ? "You" : held.holder ? (held.name ?? held.holder) : "No browser";
  const has = held.yours ? "have control" : "has control";
  const take = () => page.send({ type: "control", take: !held.yours });
  return html`<p class="control">
    <span class="who" title=${`${who} ${has}`}><span>${who}</span> <span>${has}</span></span>
    <button type="button" class="quiet" ?disabled=${!page.socket.up} @click=${take}>
      ${roomy(held.yours ? "Release control" : "Take control", "Release control")}
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
  const over = Boolean(page.over);
  return html`<div class="stop-place">
    <button
      type="button"
      class="stop-button"
      aria-label=${over ? "Stop: nothing is running" : targets.length ? label : "Stop"}
      aria-disabled=${over}
      aria-keyshortcuts="Escape Escape"
      title=${over ? "Nothing is running" : "Stop: press Escape twice, or hold it"}
      @click=${() => page.stop(stopTargets(page))}
    >
      STOP <small>${over ? "nothing running" : targets.length ? whom : ""}</small>
    </button>
    ${fate.words ? html`<p class="stop-fate ${fate.level}">${fate.words}</p>` : nothing}
  </div>`;
}
