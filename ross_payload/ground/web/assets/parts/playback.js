/** The time of one recorded flight: play, move, marks, speed. */

import { html, nothing, svg } from "../templates.js";
import { clock, utc } from "../formatting.js";
import { tracks } from "./flight-tracks.js";

const SPEEDS = [1, 2, 4, 8, 16, 64];
const SETTLED = 600; // [ms] within which the answer to a move of the slider comes while the flight plays
const PATIENCE = 10_000; // [ms] for that answer while the flight stands: a busy computer takes its time
const SAME = 0.05; // [s] between a move and its answer
const STEP = 5; // [s] of the arrow keys

/** The payload of a slot as it was told last; null: none yet. */
export const payloadOf = (page, slot) => page.store.slots[slot]?.payload ?? null;

/** A flight's name and date, and its own controls; `shared`: none of its own, two flights are moved together. */
export function playbackOf(page, slot, shared, seek) {
  const { flight } = page.store.slots[slot];
  const at = momentOf(page, slot);
  return html`<div class="playback card">
    <div class="playback-title">
      <h2>${flight.name}</h2>
      <button type="button" class="quiet" @click=${() => page.closeSlot(slot)}>
        Close<span class="unseen"> ${flight.name}</span>
      </button>
    </div>
    <p class="soft">${when(flight, at)}</p>
    ${(flight.notes ?? []).map((note) => html`<p class="note">${note}</p>`)}
    ${shared ? who(page, slot) : own(page, slot, at, seek)} ${tracks(page, slot)} ${marks(flight, seek)}
  </div>`;
}

function own(page, slot, at, seek) {
  const { flight } = page.store.slots[slot];
  const say = (message) => page.send({ type: "flight", slot, ...message });
  const play = () => say({ play: !flight.playing });
  return html`<div class="playback-row">
      ${playButton(flight.playing, play)}${speedSwitch(flight.speed, (speed) => say({ speed }))}${who(page, slot)}
      <span class="moment">${clock(at)} of ${clock(flight.duration)}</span>
    </div>
    ${slider({ ...flight, at, seek, play })}`;
}

export const playButton = (playing, play) =>
  html`<button type="button" class="main play" @click=${play}>${playing ? "Pause" : "Play"}</button>`;

export function speedSwitch(speed, choose) {
  return html`<label
    >Speed
    <select aria-label="Speed" @change=${(event) => choose(Number(event.target.value))}>
      ${SPEEDS.map((each) => html`<option value=${each} .selected=${each === speed}>${each} ×</option>`)}
    </select></label
  >`;
}

/** When it was; a simulation has a time of its own, and no date. */
export function date({ start, simulated }, at = 0) {
  if (start !== null) return utc(start + at);
  return simulated ? "Simulated" : "Date unknown";
}

const when = (flight, at) =>
  flight.start === null ? `${date(flight)}: time counts from the start of the log.` : date(flight, at);

function who(page, slot) {
  const { flight } = page.store.slots[slot];
  if (flight.payloads.length < 2) return nothing;
  const watched = payloadOf(page, slot)?.id ?? flight.payloads[0];
  const watch = (event) => page.send({ type: "flight", slot, watch: event.target.value });
  return html`<label class="who"
    >Payload
    <select aria-label="Payload" @change=${watch}>
      ${flight.payloads.map((each) => html`<option value=${each} .selected=${each === watched}>${each}</option>`)}
    </select></label
  >`;
}

/** Space plays and pauses, the arrows move by seconds. */
export function slider({ name, at, duration, marks: ticks, seek, play }) {
  const long = Math.max(duration, 0.1);
  return html`<div class="slider" @keydown=${(event) => keyed(event, at, seek, play)}>
    <input
      type="range"
      min="0"
      max=${long}
      step="0.1"
      .value=${String(at)}
      aria-label="Time of ${name}"
      aria-valuetext="${clock(at)} of ${clock(duration)}"
      @input=${(event) => seek(event.target.valueAsNumber)}
    />
    <svg class="flight-ticks" viewBox="0 0 1000 8" preserveAspectRatio="none" aria-hidden="true">
      ${ticks.map((each) => tick((1000 * each.at) / long))}
    </svg>
  </div>`;
}

const tick = (x) => svg`<line x1=${x} x2=${x} y1="0" y2="8"></line>`;

function marks(flight, seek) {
  if (!flight.marks.length) return nothing;
  return html`<details>
    <summary>Events of the flight (${flight.marks.length})</summary>
    <ol class="marks">
      ${flight.marks.map(
        (each) =>
          html`<li>
            <button type="button" class="quiet" @click=${() => seek(each.at)}>${clock(each.at)} ${each.words}</button>
          </li>`,
      )}
    </ol>
  </details>`;
}

const isAwaited = (moved, { name, playing }) =>
  moved?.name === name && performance.now() - moved.since < (playing ? SETTLED : PATIENCE);

/** Where a flight is now [s]: as the slider was moved, as it was told, and on from there while it plays. */
export function momentOf(page, slot) {
  const { flight, got } = page.store.slots[slot];
  const moved = page.ui.seeks[slot];
  if (isAwaited(moved, flight)) return moved.at;
  const on = flight.playing ? ((performance.now() - got) / 1000) * flight.speed : 0;
  return Math.min(flight.at + on, flight.duration);
}

/** Forget a move of the slider once a flight that stands is told to be there. */
export function answered(page, slot) {
  const flight = page.store.slots[slot]?.flight;
  const moved = page.ui.seeks[slot];
  if (flight && moved && !flight.playing && Math.abs(flight.at - moved.at) < SAME)
    page.ui = { ...page.ui, seeks: { ...page.ui.seeks, [slot]: null } };
}

/** Move a flight to a time [s] within it; return that. */
export function seekTo(page, slot, to) {
  const { flight } = page.store.slots[slot];
  const at = Math.min(Math.max(to, 0), flight.duration);
  page.change({ seeks: { ...page.ui.seeks, [slot]: { name: flight.name, at, since: performance.now() } } });
  page.send({ type: "flight", slot, seek: at });
  return at;
}

function keyed(event, at, seek, play) {
  const moves = { ArrowLeft: at - STEP, ArrowDown: at - STEP, ArrowRight: at + STEP, ArrowUp: at + STEP };
  if (event.key === " ") play();
  else if (event.key in moves) seek(moves[event.key]);
  else return;
  event.preventDefault();
}
