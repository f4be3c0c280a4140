/** Two recorded flights at the same time after their starts: one Play, one slider, and how they differ. */

import { html, nothing } from "../templates.js";
import { DASH, clock, decibels, degrees, duration, known, number, state } from "../formatting.js";
import { momentOf, payloadOf, playButton, seekTo, slider, speedSwitch } from "./playback.js";

const SLOTS = ["a", "b"];

/** How far the later of both is [s], and when the longer one ends [s]. */
function timesOf(page) {
  const flights = SLOTS.map((slot) => page.store.slots[slot].flight);
  return {
    at: Math.max(...SLOTS.map((slot) => momentOf(page, slot))),
    duration: Math.max(...flights.map((flight) => flight.duration)),
    playing: flights.some((flight) => flight.playing),
    speed: flights[0].speed,
    marks: flights.flatMap((flight) => flight.marks),
  };
}

export function comparison(page) {
  const times = timesOf(page);
  const seek = (at) => seekBoth(page, at);
  const play = () => playBoth(page, times);
  const speed = (value) => SLOTS.forEach((slot) => page.send({ type: "flight", slot, speed: value }));
  return html`<section class="playback card comparison" aria-label="Comparison">
    <h2>Comparison</h2>
    <div class="playback-row">
      ${playButton(times.playing, play)}${speedSwitch(times.speed, speed)}
      <span class="moment">${clock(times.at)} of ${clock(times.duration)}</span>
    </div>
    ${slider({ ...times, name: "both flights", seek, play })}
    ${differences(page, times.at)}
  </section>`;
}

/** Both go on from the same time; a shorter flight that is over stays at its end. */
function playBoth(page, { at, duration: end, playing }) {
  const from = at >= end ? 0 : at;
  for (const slot of SLOTS) {
    if (playing) page.send({ type: "flight", slot, play: false });
    else if (seekTo(page, slot, from) < page.store.slots[slot].flight.duration)
      page.send({ type: "flight", slot, play: true });
  }
}

export const seekBoth = (page, at) => SLOTS.forEach((slot) => seekTo(page, slot, at));

/** Bring a flight that was opened beside another one to the same time and speed. */
export function joined(page, slot, before) {
  const other = SLOTS.find((each) => each !== slot);
  const there = page.store.slots[other]?.flight;
  const { flight } = page.store.slots[slot];
  if (!there || before.slots[slot]?.flight?.name === flight.name) return;
  if (there.playing) page.send({ type: "flight", slot: other, play: false });
  page.send({ type: "flight", slot, speed: there.speed });
  seekBoth(page, momentOf(page, other));
}

/** What is compared: name, value, how a value is shown, and how a difference is. @type {[string, Function, Function, Function][]} */
const ROWS = [
  ["State", ({ standing }) => standing?.state, (value) => state(value), same],
  ["Elapsed", ({ mission }) => mission?.elapsed, duration, less(1, " s")],
  ["Orientation", ({ mission }) => mission?.rotation, number, less(0, "")],
  ["Sources (K)", ({ mission }) => mission?.k, number, less(0, "")],
  ["Target", ({ mission }) => mission?.target, (value) => (known(value) ? `Source ${value}` : DASH), same],
  ["Target azimuth", ({ sources }) => sources?.find((each) => each.target)?.azimuth, degrees, apart],
  ["Axis heading", ({ pointing }) => pointing?.heading, degrees, apart],
  ["Voice score", ({ mission }) => mission?.score, (value) => number(value, 2), less(2, "")],
  ["SI-SDR, estimated", ({ mission }) => mission?.si_sdr, decibels, less(1, " dB")],
  ["Predicted gain", ({ mission }) => mission?.gain, decibels, less(1, " dB")],
];

const signed = (value, digits, unit) => `${value > 0 ? "+" : ""}${number(value, digits, unit)}`;

function less(digits, unit) {
  return (one, other) => (known(one) && known(other) ? signed(other - one, digits, unit) : DASH);
}

/** Between two directions, the short way round. */
function apart(one, other) {
  if (!known(one) || !known(other)) return DASH;
  return signed(((((other - one + 180) % 360) + 360) % 360) - 180, 0, "°");
}

function same(one, other) {
  if (one == null && other == null) return DASH;
  return one === other ? "same" : "different";
}

function differences(page, at) {
  const told = SLOTS.map((slot) => payloadOf(page, slot)?.sections ?? {});
  const names = SLOTS.map((slot) => page.store.slots[slot].flight.name);
  const over = SLOTS.map((slot) => page.store.slots[slot].flight.duration < at);
  const heads = names.map((name, index) => html`${name}${over[index] ? html` <span class="soft">(ended)</span>` : nothing}`);
  return html`<div class="scroll" tabindex="0" role="region" aria-label="Table of differences">
    <table class="stack differences">
      <caption class="unseen">
        Both flights ${clock(at)} after their starts
      </caption>
      <thead>
        <tr>
          <th scope="col">Quantity</th>
          ${heads.map((head) => html`<th scope="col">${head}</th>`)}
          <th scope="col">Difference (second − first)</th>
        </tr>
      </thead>
      <tbody>
        ${ROWS.map((each) => row(each, told, names))}
      </tbody>
    </table>
  </div>`;
}

function row([name, valueOf, show, differ], told, names) {
  const values = told.map(valueOf);
  return html`<tr>
    <th scope="row">${name}</th>
    ${values.map((value, index) => html`<td data-name=${names[index]}>${show(value)}</td>`)}
    <td data-name="Difference"><strong>${differ(...values)}</strong></td>
  </tr>`;
}
