/** The time of one recorded flight: play, move, marks, speed. */

import { html, nothing, svg } from "../lit.js";
import { clock, utc } from "../words.js";

const SPEEDS = [1, 2, 4, 8, 16, 64];
const SETTLED = 600; // [ms] within which the answer to a move of the slider comes
const STEP = 5; // [s] of the arrow keys

/** The payload of a slot as it was told last; null: none yet. */
export const payloadOf = (page, slot) => page.store.slots[slot]?.payload ?? null;

export function playbackOf(page, slot) {
  const { flight } = page.store.slots[slot];
  const at = momentOf(page, slot);
  const say = (message) => page.send({ type: "flight", slot, ...message });
  return html`<div class="playback card" @keydown=${(event) => keyed(page, slot, event)}>
    <div class="playback-title">
      <h2>${flight.name}</h2>
      <button type="button" class="quiet" @click=${() => page.closeSlot(slot)}>
        Close<span class="unseen"> ${flight.name}</span>
      </button>
    </div>
    <p class="soft">${when(flight, at)}</p>
    ${(flight.notes ?? []).map((note) => html`<p class="note">${note}</p>`)}
    <div class="playback-row">
      <button type="button" class="main play" @click=${() => say({ play: !flight.playing })}>
        ${flight.playing ? "Pause" : "Play"}
      </button>
      <label
        >Speed
        <select aria-label="Speed" @change=${(event) => say({ speed: Number(event.target.value) })}>
          ${SPEEDS.map((each) => html`<option value=${each} ?selected=${each === flight.speed}>${each} ×</option>`)}
        </select></label
      >
      ${who(page, slot, say)}
      <span class="moment">${clock(at)} of ${clock(flight.duration)}</span>
    </div>
    ${slider(page, slot, at)}${marks(flight, say)}
  </div>`;
}

const when = ({ start }, at) => (start === null ? "The log does not know the time of day." : utc(start + at));

function who(page, slot, say) {
  const { flight } = page.store.slots[slot];
  if (flight.payloads.length < 2) return nothing;
  const watched = payloadOf(page, slot)?.id ?? flight.payloads[0];
  return html`<label
    >Payload
    <select aria-label="Payload" @change=${(event) => say({ watch: event.target.value })}>
      ${flight.payloads.map((each) => html`<option value=${each} ?selected=${each === watched}>${each}</option>`)}
    </select></label
  >`;
}

function slider(page, slot, at) {
  const { flight } = page.store.slots[slot];
  const long = Math.max(flight.duration, 0.1);
  return html`<div class="slider">
    <input
      type="range"
      min="0"
      max=${long}
      step="0.1"
      .value=${String(at)}
      aria-label="Time of ${flight.name}"
      aria-valuetext="${clock(at)} of ${clock(flight.duration)}"
      @input=${(event) => seek(page, slot, event.target.valueAsNumber)}
    />
    <svg class="flight-ticks" viewBox="0 0 1000 8" preserveAspectRatio="none" aria-hidden="true">
      ${flight.marks.map((each) => tick((1000 * each.at) / long))}
    </svg>
  </div>`;
}

const tick = (x) => svg`<line x1=${x} x2=${x} y1="0" y2="8"></line>`;

function marks(flight, say) {
  if (!flight.marks.length) return nothing;
  return html`<details>
    <summary>Events of the flight (${flight.marks.length})</summary>
    <ol class="marks">
      ${flight.marks.map(
        (each) =>
          html`<li>
            <button type="button" class="quiet" @click=${() => say({ seek: each.at })}>
              ${clock(each.at)} ${each.words}
            </button>
          </li>`,
      )}
    </ol>
  </details>`;
}

/** Where a flight is now [s]: as the slider was moved, as it was told, and on from there while it plays. */
function momentOf(page, slot) {
  const { flight, got } = page.store.slots[slot];
  const moved = page.ui.seeks[slot];
  if (moved && performance.now() - moved.since < SETTLED) return moved.at;
  const on = flight.playing ? ((performance.now() - got) / 1000) * flight.speed : 0;
  return Math.min(flight.at + on, flight.duration);
}

function seek(page, slot, to) {
  const { flight } = page.store.slots[slot];
  const at = Math.min(Math.max(to, 0), flight.duration);
  page.change({ seeks: { ...page.ui.seeks, [slot]: { at, since: performance.now() } } });
  page.send({ type: "flight", slot, seek: at });
}

/** Space plays and pauses, the arrows move by seconds, also from the slider. */
function keyed(page, slot, event) {
  const isRange = event.target.matches("input");
  if (!isRange) return;
  const at = momentOf(page, slot);
  const moves = { ArrowLeft: at - STEP, ArrowDown: at - STEP, ArrowRight: at + STEP, ArrowUp: at + STEP };
  if (event.key === " ") page.send({ type: "flight", slot, play: !page.store.slots[slot].flight.playing });
  else if (event.key in moves) seek(page, slot, moves[event.key]);
  else return;
  event.preventDefault();
}
