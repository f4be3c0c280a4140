/** The controls: every command that a payload accepts. Whether it obeys now is the payload's to say. */

import { html, nothing } from "../lit.js";
import { frame } from "../words.js";

export function hands(page, told) {
  const tied = page.handsTied;
  const give = (order) => () => page.order(told.id, order);
  const button = (words, order, look = "") =>
    html`<button type="button" class=${look} ?disabled=${tied !== null} @click=${give(order)}>${words}</button>`;
  const recording = told.sections.health?.recording?.on ?? false;
  return html`<section class="card hands" aria-label="Controls">
    <h2>Controls</h2>
    ${rest(told.sections.standing)} ${tied === null ? nothing : html`<p class="tied">${tied}</p>`}
    <div class="buttons">
      ${button("Explore", { kind: "explore" }, "main")} ${button("Find the enrolled voice", { kind: "listen" }, "main")}
      ${selected(page, told, button)}
    </div>
    ${turnForm(page, told, tied)} ${azimuthForm(page, told, tied)}
    <div class="buttons">
      ${button("Cancel", { kind: "cancel" })}${button("Park", { kind: "park" })}${button("Home", { kind: "home" })}
      ${button("Rearm", { kind: "rearm" })}${button("Measure noise (3 s)", { kind: "noise", seconds: 3 })}
      ${button(recording ? "Stop recording" : "Start recording", { kind: "record", on: !recording })}
    </div>
  </section>`;
}

/** What keeps it from moving. */
const rest = (standing) =>
  standing?.state === "stopped" ? html`<p class="soft">It will not move until it is rearmed.</p>` : nothing;

function selected(page, told, button) {
  const there = (told.sections.sources ?? []).some((each) => each.source === page.ui.selected);
  if (!there) return nothing;
  return button(`Listen to source ${page.ui.selected}`, { kind: "listen", source: page.ui.selected }, "main");
}

function turnForm(page, told, tied) {
  const words = `Axis heading (degrees ${frame(told.sections.pointing?.earth)})`;
  return angleForm({
    id: "turn",
    words,
    verb: "Turn to",
    tied,
    give: (heading) => page.order(told.id, { kind: "turn", heading }),
  });
}

function azimuthForm(page, told, tied) {
  const words = `Source azimuth (degrees ${frame(told.sections.pointing?.earth)})`;
  return angleForm({
    id: "azimuth",
    words,
    verb: "Listen at",
    tied,
    give: (azimuth) => page.order(told.id, { kind: "listen", azimuth }),
  });
}

/** A field for one angle: the browser checks it before it is sent. */
function angleForm({ id, words, verb, tied, give }) {
  const send = (event) => {
    event.preventDefault();
    give(event.target.elements.angle.valueAsNumber);
  };
  return html`<form class="entry" @submit=${send}>
    <label for=${id}>${words}</label>
    <input id=${id} name="angle" type="number" min="-360" max="360" step="any" required inputmode="decimal" />
    <button type="submit" ?disabled=${tied !== null}>${verb}</button>
  </form>`;
}
