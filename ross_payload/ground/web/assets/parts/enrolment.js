/** Enrolling the talker at a source: only with the consent of whoever it is, which is part of the order. */

import { html, nothing } from "../templates.js";

/** The button that asks about a source. */
export const enrolButton = (page, source) =>
  html`<button
    type="button"
    aria-haspopup="dialog"
    ?disabled=${page.commandsBlocked !== null}
    @click=${() => opened(page, source)}
  >
    Enrol source ${source}…
  </button>`;

function opened(page, source) {
  document.querySelector("#enrolment form")?.reset(); // it may be open for another: consent is that of one person
  page.change({ enrolling: source });
  requestAnimationFrame(() => requestAnimationFrame(() => document.getElementById("enrolment")?.show())); // not modal: the stop stays in reach
}

/** Close the dialog, if it is there. */
export const closeEnrolment = () => document.getElementById("enrolment")?.close();

/** The dialog; nothing while nobody is to be enrolled. */
export function enrolment(page, told) {
  const { enrolling: source } = page.ui;
  if (source == null) return nothing;
  const close = () => page.change({ enrolling: null });
  const enrol = (event) => {
    const { consent, voice, seconds } = event.target.elements;
    const numbers = { voice: voice.valueAsNumber || 0, seconds: seconds.valueAsNumber || 0 };
    page.order(told.id, { kind: "enrol", source, consent: consent.checked, ...numbers });
  };
  return html`<dialog id="enrolment" aria-labelledby="enrolment-title" @close=${close}>
    <form method="dialog" @submit=${enrol}>
      <h2 id="enrolment-title">Enrol the talker at source ${source}</h2>
      <p>
        The payload turns to this talker, separates the voice and stores a voice print, by which it can find the same
        person again. A voice print is personal data.
      </p>
      <label class="consent"
        ><input type="checkbox" name="consent" required /> This person knows what is stored and has agreed to it.</label
      >
      <label>Number of the talker (0: the next free one) <input name="voice" type="number" min="0" max="9999" step="1" value="0" /></label>
      <label
        >Seconds of speech (0: as configured)
        <input name="seconds" type="number" min="0" max="300" step="any" value="0"
      /></label>
      <div class="buttons">
        <button type="submit" class="main">Enrol</button>
        <button type="button" @click=${closeEnrolment}>Cancel</button>
      </div>
    </form>
  </dialog>`;
}
