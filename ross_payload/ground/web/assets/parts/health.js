/** How every part is. Red only where something must be done, and then the words say what. */

import { levels } from "../instruments/level-meters.js";
import { html, nothing } from "../templates.js";
import { DASH, ago, capital, duration, known, level, number, plural, share, size } from "../formatting.js";
import { fact } from "./tables.js";

/** `silent`: no telemetry comes, so that nothing is known of how it is now. */
export function health(told, now, silent = false) {
  const parts = told.sections.health;
  if (!parts) return html`<p class="soft">No data yet.</p>`;
  const show = (name, part, facts, picture) => card(name, part, facts, picture, silent);
  return html`<div class="health">
    ${show("Microphones", parts.microphones, microphones(parts.microphones), heard(parts.microphones))}
    ${show("Actuator", parts.actuator, actuator(parts.actuator, now))}
    ${show("Telemetry received here", parts.reception, reception(parts.reception, rates(told.counts)))}
    ${parts.links.map((each) => show(linkName(each, parts.links), each, link(each)))}
    ${show("Computer", parts.processor, processor(parts.processor))}
    ${show("Recorder", parts.recording, recording(parts.recording))}
    ${show("Live listening", parts.listening, [])}
  </div>`;
}

function card(name, part, facts, picture, silent) {
  const shown = silent ? "unknown" : part.level;
  const last = silent && part.level !== "unknown" ? `Last report: ${level(part.level)}. ` : "";
  return html`<section class="card part ${shown}">
    <h3>${name} <span class="tag ${shown}">${level(shown)}</span></h3>
    <p>${last}${capital(part.words)}</p>
    ${picture ?? nothing}
    <dl>
      ${facts.filter(Boolean).map(fact)}
    </dl>
  </section>`;
}

const heard = (microphones) => (microphones.level_db ? levels(microphones) : nothing);

function microphones({ level_db: level, lost, reopened, waiting, rate }) {
  if (!level) return [];
  return [
    ["Lost", known(lost) ? plural(lost, "sample") : DASH],
    reopened ? ["Reopened", plural(reopened, "time")] : null,
    waiting > 0.5 ? ["Audio backlog", duration(waiting)] : null,
    rate ? ["Sample rate", number(rate / 1000, 1, " kHz")] : null,
  ];
}

function actuator({ at, error, open_loop: openLoop }, now) {
  if (error === undefined) return [];
  return [
    ["Reported", ago(known(at) && known(now) ? now - at : null)],
    ["Distance to goal", number(error, 1, "°")],
    ["Angle", openLoop ? "computed from steps, not measured" : "measured"],
  ];
}

function reception({ lost, malformed }, { frames, bytes, loss }) {
  return [
    ["Rate", number(frames, 0, " messages/s")],
    ["Bandwidth", known(bytes) ? `${size(bytes)}/s` : DASH],
    ["Lost recently", known(lost) ? share(loss) : "unknown"],
    ["Lost in total", known(lost) ? plural(lost, "message") : "unknown"],
    malformed ? ["Malformed", plural(malformed, "message")] : null,
  ];
}

/** Rates over the counts of the last seconds; unknown until there are two. */
export function rates(counts) {
  const [first, last] = [counts[0], counts.at(-1)];
  const span = first && last ? last.now - first.now : 0;
  if (span < 0.5) return { frames: null, bytes: null, loss: null };
  const [frames, lost] = [last.frames - first.frames, Math.max(last.lost - first.lost, 0)]; // some came late
  return {
    frames: frames / span,
    bytes: (last.bytes - first.bytes) / span,
    loss: known(last.lost) && frames + lost ? lost / (frames + lost) : null,
  };
}

const MEDIA = { udpin: "UDP", udpout: "UDP", tcp: "TCP", tcpin: "TCP", serial: "Serial" };
const medium = ({ url }) => MEDIA[url.split(":")[0]] ?? "MAVLink";
const kindOf = (each) => `${medium(each)} link to the ${each.autopilot ? "autopilot" : "ground"}`;

/** A link by its medium and where it leads, numbered where several have one name; its address is a detail. */
export function linkName(each, all) {
  const alike = all.filter((other) => kindOf(other) === kindOf(each));
  return alike.length > 1 ? `${kindOf(each)}, ${alike.indexOf(each) + 1}` : kindOf(each);
}

function link({ url, sent, dropped, received, lost, bad, refused, reconnects }) {
  return [
    ["Address", url],
    ["Sent / dropped", `${sent} / ${dropped}`],
    ["Received / lost", `${received} / ${known(lost) ? lost : "unknown"}`],
    bad || refused ? ["Bad / rejected", `${bad} / ${refused}`] : null,
    reconnects ? ["Reconnected", plural(reconnects, "time")] : null,
  ];
}

function processor({ loads, memory, temperature, uptime }) {
  return [
    loads?.length ? ["Busiest core", share(Math.max(...loads))] : null,
    known(memory) ? ["Memory", share(memory)] : null,
    known(temperature) ? ["Temperature", number(temperature, 0, " °C")] : null,
    known(uptime) ? ["Computer up for", duration(uptime)] : null,
  ];
}

function recording({ on, duration: long, free }) {
  return [on ? ["Recorded", duration(long)] : null, known(free) ? ["Free space", size(free)] : null];
}
