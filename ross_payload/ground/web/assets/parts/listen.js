/** Live listening: silent until somebody asks; what is heard, how loud, and how it comes. */

import { levelBar } from "../instruments/level-meters.js";
import { DASH, capital, known, number, plural } from "../formatting.js";
import { html, nothing } from "../templates.js";
import { fact, roomy } from "./tables.js";

const PHASES = {
  off: "Silent. Nothing is streamed to this page.",
  connecting: "Connecting to the ground process.",
  waiting: "Waiting for sound from the payload.",
  playing: "Playing",
  ended: "The payload has ended the stream. Press Listen twice to ask again.",
  refused: "Not possible",
  fault: "Fault",
};

const LONGEST = "The payload has ended the stream. Press Listen twice to ask again.";
const OVER = "The simulation has ended: nothing is streamed any more.";

export function listenPanel(page, told) {
  const { listening } = page;
  const on = listening.state.on && listening.state.id === told.id;
  const press = () =>
    on ? listening.stop() : listening.start(told.id, told.sections.health?.microphones?.rate ?? null);
  return html`<section class="card listening" aria-label="Listen">
    <h2>Listen</h2>
    <p class=${["refused", "fault"].includes(listening.state.phase) ? "bad" : "soft"}>
      ${roomy(page.over ? OVER : saying(listening), LONGEST)}
    </p>
    ${page.store.fleet?.pace && !page.over ? html`<p class="soft pace">${page.store.fleet.pace}</p>` : nothing}
    <div class="listening-row">
      <button type="button" class=${on ? "" : "main"} aria-pressed=${on} ?disabled=${page.over !== "" && !on} @click=${press}>
        Listen
      </button>
      ${choices(listening, told)}
    </div>
    ${shared(listening)} ${loudness(listening)} ${levelBar("level", ...Object.values(listening.level))}
    <canvas class="spectrogram" width="300" height="96" role="img" aria-label=${spectrumOf(listening)}></canvas>
    <dl class="facts listening-facts">${facts(listening).map(fact)}</dl>
    ${others(page, told)}
  </section>`;
}

/** How it is, in words. */
export function saying({ state }) {
  const words = PHASES[state.phase] ?? state.phase;
  if (state.phase === "playing") {
    const { whom, instead } = state.told;
    if (instead) return `${words}: ${instead} instead of ${whom} (${state.why}).`;
    return `${words}: ${whom}${state.why ? ` (${state.why})` : ""}.`;
  }
  return state.why ? `${words.replace(/\.$/, "")}: ${state.why}.` : words.replace(/[^.]$/, "$&.");
}

/** What can be heard: a source stays in the list while it is chosen, also when the payload does not know it any more. */
function choices(listening, told) {
  const { choice } = listening;
  const sources = new Set((told.sections.sources ?? []).map((each) => each.source));
  if (choice.what === "source") sources.add(choice.source);
  const value = choice.what === "source" ? `source ${choice.source}` : choice.what;
  const choose = ({ target }) => listening.choose(chosen(target.value, listening));
  const option = (key, words) => html`<option value=${key} .selected=${key === value}>${words}</option>`;
  return html`<label
      >What is heard
      <select @change=${choose}>
        ${option("mixture", "Mixture (microphone 1)")}${option("target", "Target")}
        ${[...sources].sort((a, b) => a - b).map((each) => option(`source ${each}`, `Source ${each}`))}
        ${option("azimuth", "A direction")}
      </select></label
    >
    ${choice.what === "azimuth" ? direction(listening) : nothing}`;
}

const chosen = (value, { choice }) => {
  const [what, source] = value.split(" ");
  if (what === "azimuth") return { what, azimuth: choice.azimuth ?? 0 };
  return what === "source" ? { what, source: Number(source) } : { what };
};

/** One stream goes to this ground station, whoever listens. */
function shared({ state: { told } }) {
  const rest = (told?.listeners ?? 1) - 1;
  if (rest < 1) return nothing;
  const who = rest === 1 ? "1 other browser listens" : `${rest} other browsers listen`;
  return html`<p class="soft shared" role="status">${who}: what is heard is chosen for all.</p>`;
}

function direction(listening) {
  const turn = ({ target }) => {
    if (target.reportValidity()) listening.choose({ what: "azimuth", azimuth: target.valueAsNumber });
  };
  return html`<label
    >Azimuth in degrees
    <input type="number" min="-360" max="360" step="any" required .value=${String(listening.choice.azimuth)} @change=${turn}
  /></label>`;
}

function loudness(listening) {
  const percent = Math.round(100 * listening.volume);
  return html`<label class="volume"
    >Volume
    <input
      type="range"
      min="0"
      max="100"
      aria-label="Volume"
      aria-valuetext="${percent} %"
      .value=${String(percent)}
      @input=${({ target }) => listening.loud(target.valueAsNumber / 100)}
  /></label>`;
}

const spectrumOf = ({ playout }) =>
  `Spectrogram of what is heard${playout ? `, from 0 to ${number(playout.rate / 2000, 1, " kHz")}` : ""}`;

function facts(listening) {
  const { told, played } = listening.state;
  const sent = told ? told.received + told.lost : 0;
  return [
    ["Delay", number(listening.delay, 0, " ms"), "from the microphone to here, by the clocks of both computers"],
    ["Lost packets", told ? number(told.lost) : DASH, sent ? `${number((100 * told.lost) / sent, 1, " %")} of ${sent}` : ""],
    ["Interruptions", played ? number(played.gaps) : DASH, told?.dropped ? `${plural(told.dropped, "frame")} too late` : ""],
    ["Listeners", told ? number(told.listeners) : DASH, "browsers of this page"],
  ];
}

/** Who else gets sound: whoever talks to a payload can know it. */
function others(page, told) {
  const going = (told.sections.streams ?? []).filter((each) => each.on || each.fault);
  const end = ({ address, port }) => page.order(told.id, { kind: "stop_stream", address, port });
  if (!going.length) return nothing;
  return html`<h3>Streams of the payload</h3>
    <ul class="streams">
      ${going.map(
        (each) =>
          html`<li class=${each.fault ? "bad" : ""}>
            ${capital(each.whom)} to ${each.place} (${each.sink}${known(each.delay) ? `, ${number(1000 * each.delay, 0, " ms")}` : ""}): ${each.words}
            ${
              each.on && each.sink === "rtp"
                ? html`<button type="button" ?disabled=${page.commandsBlocked !== null} @click=${() => end(each)}>
                    End<span class="unseen"> the stream to ${each.place}</span>
                  </button>`
                : nothing
            }
          </li>`,
      )}
    </ul>`;
}
