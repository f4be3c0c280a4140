/** The controls: every command that a payload accepts. Whether it obeys now is the payload's to say. */

import { html } from "../templates.js";
import { frame } from "../formatting.js";
import { roomy } from "./tables.js";

export function commands(page, told) {
  const blocked = page.commandsBlocked;
  const earth = told.sections.pointing?.earth;
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
      <label for=${id}>${roomy(`${words} (${unit(earth)})`, `${words} (${unit(false)})`)}</label>
      <input id=${id} name="angle" type="number" min="-360" max="360" step="any" required inputmode="decimal" />
      <button type="submit" ?disabled=${blocked !== null}>${verb}</button>
    </form>`;
  };
  const recording = told.sections.health?.recording?.on ?? false;
  return html`<section class="card commands" aria-label="Controls">
    <h2>Controls</h2>
    <div class="buttons">
      ${button("Explore", { kind: "explore" }, "main")} ${button("Find the enrolled voice", { kind: "listen" }, "main")}
      ${selected(page, told, give)}
    </div>
    ${angleForm("turn", "Axis heading", "Turn to", (heading) => ({ kind: "turn", heading }))}
    ${angleForm("azimuth", "Source azimuth", "Listen at", (azimuth) => ({ kind: "listen", azimuth }))}
    <div class="buttons">
      ${button("Cancel", { kind: "cancel" })}${button("Park", { kind: "park" })}${button("Home", { kind: "home" })}
      ${button("Rearm", { kind: "rearm" })}${button("Measure noise (3 s)", { kind: "noise", seconds: 3 })}
      ${button(recording ? "Stop recording" : "Start recording", { kind: "record", on: !recording })}
    </div>
  </section>`;
}

const unit = (earth) => `° ${frame(earth)}`;

/** It stays where it is, also while no source is selected. */
function selected(page, told, give) {
  const { selected: source } = page.ui;
  const there = (told.sections.sources ?? []).some((each) => each.source === source);
  return html`<button
    type="button"
    class="main"
    ?disabled=${!there || page.commandsBlocked !== null}
    @click=${give({ kind: "listen", source })}
  >
    Listen to ${there ? "" : "a "}source${there ? ` ${source}` : ""}
  </button>`;
}
