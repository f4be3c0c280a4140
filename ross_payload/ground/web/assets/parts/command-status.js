/** Why no command can be given now, and what became of every command, newest first. */

import { html, nothing, repeat } from "../templates.js";
import { ago, fate, isOver, known } from "../formatting.js";
import { isStopping, latestStop } from "../stop.js";

const SHOWN = 8;

export function commandStatus(page, told) {
  const list = (told.sections.orders ?? []).slice(-SHOWN).reverse();
  const blocked = page.commandsBlocked;
  return html`<section class="card orders">
    <h2>Commands</h2>
    <div class="list" role="region" aria-label="Commands, newest first" tabindex="0">
      ${blocked === null ? nothing : html`<p class="tied">${blocked}</p>`}
      ${list.length || blocked !== null ? nothing : html`<p class="soft">No commands yet.</p>`}
      <ol>
        ${repeat(
          list,
          (each) => each.number,
          (each) => line(page, told, each),
        )}
      </ol>
    </div>
  </section>`;
}

function line(page, told, each) {
  const running = !isOver(each.state);
  const bad = ["refused", "failed", "no_answer"].includes(each.state);
  return html`<li class="order ${bad ? "bad" : ""}" data-state=${each.state}>
    <span class="what">${each.words}</span>
    <span class="fate">${fate(each.state)}${sending(page, told, each)}${each.reason ? html`: ${each.reason}` : nothing}</span>
    <span class="soft when">${ago(page.now() - each.since)}</span>
    ${running && known(each.progress) ? bar(each) : nothing}
    ${
      running && each.words !== "stop" // only a re-arming ends one
        ? html`<button
            type="button"
            class="quiet"
            ?disabled=${page.commandsBlocked !== null}
            @click=${() => page.order(told.id, { kind: "cancel", number: each.number })}
          >
            Cancel<span class="unseen"> ${each.words}</span>
          </button>`
        : nothing
    }
  </li>`;
}

/** Of the latest stop, which is sent for all: whether it still is. */
const sending = (page, { id, sections: { orders } }, each) =>
  each.state === "no_answer" && each === latestStop(orders) && isStopping(page, id) ? ", still being sent" : "";

const bar = ({ progress, words }) =>
  html`<progress max="1" value=${progress} aria-label="Progress of ${words}"></progress>`;
