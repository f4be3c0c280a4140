/** Recorded flights: pick or drop one, move in its time, compare two. */

import { html, nothing } from "../templates.js";
import { comparison, seekBoth } from "../parts/comparison.js";
import { date, payloadOf, playbackOf, seekTo } from "../parts/playback.js";
import { recordings } from "../parts/recordings.js";
import { DASH, duration, size } from "../formatting.js";
import { recordedView } from "./payload.js";

export function flightsView(page) {
  const { slots } = page.store;
  const open = ["a", "b"].filter((slot) => slots[slot]?.flight);
  return html`<h1 tabindex="-1">Flights</h1>
    ${picker(page, open)} ${recordings(page)}
    ${open.length > 1 ? comparison(page) : nothing}
    ${
      open.length
        ? html`<div class="slots ${open.length > 1 ? "two" : ""}">
            ${open.map((slot) => slotView(page, slot, open.length > 1))}
          </div>`
        : nothing
    }`;
}

function slotView(page, slot, shared) {
  const { flight } = page.store.slots[slot];
  const told = payloadOf(page, slot);
  const seek = (at) => (shared ? seekBoth(page, at) : seekTo(page, slot, at));
  return html`<section class="slot" aria-label="Flight ${flight.name}">
    ${playbackOf(page, slot, shared, seek)} ${told ? recordedView(page, told) : html`<p class="opening">${nothingIn(flight)}</p>`}
  </section>`;
}

const nothingIn = ({ payloads }) =>
  payloads.length ? "No telemetry from the payload at this time yet." : "This log contains no RoSS payload.";

function picker(page, open) {
  const known = page.store.flights;
  return html`<section class="card picker" aria-label="Open a flight">
    <div class="drop">
      <label for="file">Drop a telemetry log (<code>.tlog</code>), an MCAP file with sound or a session folder here, or choose a
        file</label
      >
      <input id="file" type="file" accept=".tlog,.mcap" @change=${(event) => chosen(page, event.target)} />
    </div>
    ${upload(page.ui.upload)}
    ${
      known?.length
        ? html`<ul class="known">
            ${known.map((each) => knownFlight(page, each, open))}
          </ul>`
        : html`<p class="soft">
            No flights yet. <code>ross ground --log DIR</code> records all telemetry received.
          </p>`
    }
  </section>`;
}

function knownFlight(page, each, open) {
  const into = (slot) => () => page.send({ type: "flight", slot, open: each.name });
  return html`<li>
    <span class="name"
      ><strong>${each.name}</strong>
      <span class="soft"
        >${[date(each), duration(each.duration)].filter((words) => words !== DASH).join(" · ")}</span
      >
      ${(each.notes ?? []).map((note) => html`<span class="note">${note}</span>`)}</span
    >
    <span class="buttons">
      <button type="button" ?disabled=${!page.socket.up} @click=${into("a")}>
        Open<span class="unseen"> ${each.name}</span>
      </button>
      ${
        open.length
          ? html`<button type="button" ?disabled=${!page.socket.up} @click=${into("b")}>
              Compare<span class="unseen"> with ${each.name}</span>
            </button>`
          : nothing
      }
    </span>
  </li>`;
}

function upload(state) {
  if (!state) return nothing;
  if (state.error) return html`<p class="bad" role="alert">${state.name}: ${state.error}</p>`;
  if (state.done) return html`<p role="status">${state.name} has been uploaded.</p>`;
  return html`<p>
    Uploading ${state.name}, ${size(state.size)}
    <progress max="1" value=${state.share} aria-label="Uploading ${state.name}"></progress>
  </p>`;
}

function chosen(page, input) {
  const [file] = input.files;
  if (file) sendFile(page, file, file.name);
  input.value = "";
}

/** Whether files are dragged; text may be dropped into fields. */
export const isOfFiles = ({ dataTransfer }) => dataTransfer?.types.includes("Files") ?? false;

/** Take a log that is dropped anywhere: beside our own place the browser would leave the page, and its stop, for the file. */
export async function dropped(page, event) {
  event.preventDefault();
  location.hash = "#/flights";
  const [item] = event.dataTransfer.items;
  const entry = item?.webkitGetAsEntry?.();
  if (entry?.isDirectory) {
    const file = await logIn(entry);
    if (file) sendFile(page, file, `${entry.name}.tlog`);
    else page.change({ upload: { name: entry.name, error: "expected a session folder with telemetry.tlog, got none" } });
    return;
  }
  const [file] = event.dataTransfer.files;
  if (file) sendFile(page, file, file.name);
}

/** The telemetry log of a session folder; null: there is none. */
function logIn(folder) {
  return new Promise((resolve) => {
    folder.getFile(
      "telemetry.tlog",
      {},
      (entry) => entry.file(resolve, () => resolve(null)),
      () => resolve(null),
    );
  });
}

/** Send a file to the ground process, and open it in the first free slot. */
function sendFile(page, file, name) {
  const request = new XMLHttpRequest();
  const told = (state) => page.change({ upload: { name, size: file.size, share: 0, ...state } });
  request.open("POST", `/flights?name=${encodeURIComponent(name)}`);
  request.responseType = "json";
  request.upload.addEventListener("progress", ({ loaded, total }) => told({ share: total ? loaded / total : 0 }));
  request.addEventListener("load", () => {
    const answer = request.response ?? {};
    if (request.status >= 400 || !answer.name) {
      told({ error: answer.error ?? `the ground process rejected it (HTTP ${request.status})` });
      return;
    }
    told({ done: true });
    page.send({ type: "flight", slot: page.store.slots.a?.flight ? "b" : "a", open: answer.name });
  });
  request.addEventListener("error", () => told({ error: "the upload failed: check that ross ground is running" }));
  told({});
  request.send(file);
}
