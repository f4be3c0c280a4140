/** The controls: every command that a payload accepts. Whether it obeys now is the payload's to say. */

import { html, nothing } from "../templates.js";
import { frame } from "../formatting.js";

export function commands(page, told) {
  const blocked = page.commandsBlocked;
  const give = (order) => () => page.order(told.id, order);
  const button = (words, order, look = "") =>
    html`<button type="button" class=${look} ?disabled=${blocked !== null} @click=${give(order)}>${words}</button>`;
  /** A field for one angle: the browser checks it before it is sent. */
  const angleForm = (id, words, verb, orderOf) => {
    const send = (event) => {
      event.preventDefault();
      page.order(told.id, orderOf(event.target.elements.angle.valueAsNumber));
    };
    return html`<form class="entry" @submit=${send}>
      <label for=${id}>${words}</label>
      <input id=${id} name="angle" type="number" min="-360" max="360" step="any" required inputmode="decimal" />
      <button type="submit" ?disabled=${blocked !== null}>${verb}</button>
    </form>`;
  };
  const unit = `degrees ${frame(told.sections.pointing?.earth)}`;
  const recording = told.sections.health?.recording?.on ?? false;
  return html`<section class="card commands" aria-label="Controls">
    <h2>Controls</h2>
    ${rest(told.sections.standing)} ${blocked === null ? nothing : html`<p class="tied">${blocked}</p>`}
    <div class="buttons">
      ${button("Explore", { kind: "explore" }, "main")} ${button("Find the enrolled voice", { kind: "listen" }, "main")}
      ${selected(page, told, button)}
    </div>
    ${angleForm("turn", `Axis heading (${unit})`, "Turn to", (heading) => ({ kind: "turn", heading }))}
    ${angleForm("azimuth", `Source azimuth (${unit})`, "Listen at", (azimuth) => ({ kind: "listen", azimuth }))}
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
