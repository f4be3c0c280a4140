/** How every part is. Red only where something must be done, and then the words say what. */

import { levels } from "../instruments/gauge.js";
import { html, nothing } from "../lit.js";
import { DASH, ago, duration, known, level, number, share, size } from "../words.js";
import { fact } from "./facts.js";

export function health(told, now) {
  const parts = told.sections.health;
  if (!parts) return html`<p class="soft">Nothing is said of it yet.</p>`;
  return html`<div class="health">
    ${card("Microphones", parts.microphones, microphones(parts.microphones), heard(parts.microphones))}
    ${card("Actuator", parts.actuator, actuator(parts.actuator, now))}
    ${card("Link to here", parts.reception, reception(parts.reception, rates(told.counts)))}
    ${parts.links.map((each) => card(`Payload’s link ${each.url}`, each, link(each)))}
    ${card("Processor", parts.processor, processor(parts.processor))}
    ${card("Recorder", parts.recording, recording(parts.recording))}
  </div>`;
}

function card(name, part, facts, picture = nothing) {
  return html`<section class="card part ${part.level}">
    <h3>${name} <span class="tag ${part.level}">${level(part.level)}</span></h3>
    <p>${part.words}</p>
    ${picture}
    <dl>
      ${facts.filter(Boolean).map(fact)}
    </dl>
  </section>`;
}

const heard = (microphones) => (microphones.level_db ? levels(microphones) : nothing);

function microphones({ level_db: level, lost, reopened, waiting, rate }) {
  if (!level) return [];
  return [
    ["Lost", known(lost) ? `${lost} samples` : DASH],
    reopened ? ["Opened again", `${reopened} times`] : null,
    waiting > 0.5 ? ["Waits", duration(waiting)] : null,
    rate ? ["Rate", number(rate / 1000, 1, " kHz")] : null,
  ];
}

function actuator({ at, error, open_loop: openLoop }, now) {
  if (error === undefined) return [];
  return [
    ["Reported", ago(known(at) && known(now) ? now - at : null)],
    ["Off its goal", number(error, 1, "°")],
    ["Angle", openLoop ? "computed, not measured" : "measured"],
  ];
}

function reception({ lost, malformed }, { frames, bytes, loss }) {
  return [
    ["Rate", number(frames, 0, " messages/s")],
    ["Bandwidth", known(bytes) ? `${size(bytes)}/s` : DASH],
    ["Lost lately", known(lost) ? share(loss) : "unknown"],
    ["Lost in all", known(lost) ? `${lost} messages` : "unknown"],
    malformed ? ["Malformed", `${malformed} messages`] : null,
  ];
}

/** Rates over the counts of the last seconds; unknown until there are two. */
export function rates(counts) {
  const [first, last] = [counts[0], counts.at(-1)];
  const span = first && last ? last.now - first.now : 0;
  if (span < 0.5) return { frames: null, bytes: null, loss: null };
  const [frames, lost] = [last.frames - first.frames, last.lost - first.lost];
  return {
    frames: frames / span,
    bytes: (last.bytes - first.bytes) / span,
    loss: known(last.lost) && frames + lost ? lost / (frames + lost) : null,
  };
}

function link({ sent, dropped, received, lost, bad, refused, reconnects, autopilot }) {
  return [
    ["Sent, dropped", `${sent}, ${dropped}`],
    ["Received, lost", `${received}, ${known(lost) ? lost : "unknown"}`],
    bad || refused ? ["Bad, refused", `${bad}, ${refused}`] : null,
    reconnects ? ["Connected again", `${reconnects} times`] : null,
    autopilot ? ["Leads to", "the autopilot"] : null,
  ];
}

function processor({ loads, memory, temperature, uptime }) {
  return [
    loads?.length ? ["Busiest core", share(Math.max(...loads))] : null,
    known(memory) ? ["Memory", share(memory)] : null,
    known(temperature) ? ["Temperature", number(temperature, 0, " °C")] : null,
    known(uptime) ? ["Runs for", duration(uptime)] : null,
  ];
}

function recording({ on, duration: long, free }) {
  return [on ? ["Recorded", duration(long)] : null, known(free) ? ["Free", size(free)] : null];
}
