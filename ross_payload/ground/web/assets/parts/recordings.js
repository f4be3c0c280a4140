/** Recorded sessions: where they are kept, their download, and their deletion. */

import { html, nothing } from "../templates.js";
import { duration, size } from "../formatting.js";

const TWICE = 500; // [ms] after which a press is an answer to the question, and not the second one of a double click

/** The list; nothing when the ground process offers no recordings. */
export function recordings(page) {
  const told = page.store.recordings;
  if (!told) return nothing;
  return html`<section class="card" aria-label="Recordings">
    <h2>Recordings</h2>
    <p class="soft">
      Kept in <code>${told.folder}</code>. They contain speech of people: download and keep them only if you are allowed to.
    </p>
    ${page.ui.recordingError ? html`<p class="bad" role="alert">${page.ui.recordingError}</p>` : nothing}
    ${
      told.known.length
        ? html`<ul class="known">
            ${told.known.map((each) => row(page, each))}
          </ul>`
        : html`<p class="soft">Nothing is recorded yet.</p>`
    }
  </section>`;
}

function row(page, { name, bytes, seconds, state, running }) {
  return html`<li>
    <span class="name"
      ><strong>${name}</strong>
      <span class="soft">${[duration(seconds), size(bytes), state].join(" · ")}</span></span
    >
    <span class="buttons">
      <a class="button" href=${addressOf(name, ".zip")} download>Download<span class="unseen"> ${name}</span></a>
      ${page.ui.deleting?.name === name ? question(page, name) : deletion(page, name, running)}
    </span>
  </li>`;
}

const deletion = (page, name, running) =>
  html`<button type="button" ?disabled=${running} @click=${() => asked(page, name)}>
    Delete<span class="unseen"> ${name}</span>
  </button>`;

/** Asked in its row: a dialog of the browser would hold up the page, its stop included. */
const question = (page, name) =>
  html`<span>This cannot be undone.</span>
    <button type="button" @click=${() => remove(page, name)}>
      Delete<span class="unseen"> ${name}</span> for good
    </button>
    <button type="button" class="keep" @click=${() => page.change({ deleting: null })}>
      Keep<span class="unseen"> ${name}</span>
    </button>`;

function asked(page, name) {
  page.change({ deleting: { name, at: performance.now() } });
  requestAnimationFrame(() => requestAnimationFrame(() => document.querySelector(".known .keep")?.focus()));
}

const addressOf = (name, suffix = "") => `/recordings/${encodeURIComponent(name)}${suffix}`;

async function remove(page, name) {
  if (!(performance.now() - page.ui.deleting?.at >= TWICE)) return;
  page.change({ deleting: null });
  const answer = await fetch(addressOf(name), { method: "DELETE" }).catch(() => null);
  const told = answer?.ok ? {} : await answer?.json().catch(() => ({}));
  page.change({ recordingError: answer?.ok ? null : `${name}: ${told?.error ?? "it was not deleted"}` });
}
