/** What can be heard of a recorded flight: nothing until somebody asks; the mixture, the voices, one after the other. */

import { html, nothing } from "../templates.js";
import { capital } from "../formatting.js";

const STAGES = { before: "Before: the mixture, as microphones hear it.", after: "After: the target, separated." };

export function tracks(page, slot) {
  const { flight } = page.store.slots[slot];
  const names = (flight.sound ?? []).map((each) => each.track);
  if (!names.length) return nothing;
  const { flightSound: sound } = page;
  const heard = sound.trackOf(slot);
  const stage = sound.comparison?.slot === slot ? STAGES[sound.comparison.stage] : null;
  return html`<div class="playback-row tracks" role="group" aria-label="Sound of ${flight.name}">
      <span aria-hidden="true">Sound</span>
      ${names.map((name) => trackButton(page, slot, name, heard === name))}
      ${
        names.includes("mixture") && names.includes("target")
          ? html`<button type="button" class="main" @click=${() => sound.compare(page, slot)}>Before and after</button>`
          : nothing
      }
    </div>
    <p role="status" class=${sound.error ? "bad" : "soft"}>${sound.error || stage || (heard ? remark(flight) : "")}</p>`;
}

const remark = ({ playing, speed }) =>
  !playing ? "Press Play to hear it." : speed > 4 ? "Too fast for sound: it plays at up to 4 ×." : "";

const trackButton = (page, slot, name, pressed) =>
  html`<button
    type="button"
    aria-pressed=${pressed}
    @click=${() => page.flightSound.choose(page, slot, pressed ? null : name)}
  >
    ${capital(name.replace("-", " "))}
  </button>`;

/** The newest flight of which a comparison can be heard. */
export const comparable = ({ store: { flights } }) =>
  (flights ?? []).find(({ sound }) => sound?.includes("mixture") && sound.includes("target"));
