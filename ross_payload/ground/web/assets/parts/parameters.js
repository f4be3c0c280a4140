/** Every parameter with what it means and its bounds; a value is checked here before it is sent. */

import { html, nothing, repeat } from "../templates.js";
import { known } from "../formatting.js";
import { table } from "./tables.js";

const STATES = { known: "", sending: "sending", set: "set", refused: "refused", no_answer: "no answer" };

export function parameters(page, told) {
  const rows = told.sections.parameters ?? [];
  const { filter } = page.ui;
  const shown = rows.filter((each) => fits(each, filter));
  return html`<details
    class="card wide parameters"
    @toggle=${(event) => page.change({ parametersOpen: event.target.open })}
  >
    <summary>
      <h2>Parameters</h2>
      <span class="soft">${rows.length ? `${rows.length} received` : "not received yet"}</span>
    </summary>
    ${
      page.ui.parametersOpen
        ? html` <div class="entry">
              <label for="filter">Filter</label>
              <input
                id="filter"
                type="search"
                .value=${filter}
                @input=${(event) => page.change({ filter: event.target.value })}
              />
              <button
                type="button"
                ?disabled=${!page.socket.up}
                @click=${() => page.send({ type: "refresh", id: told.id })}
              >
                Refresh
              </button>
            </div>
            ${
              rows.length && !rows.some((each) => each.description)
                ? html`<p class="soft">
                    The payload sent no component metadata: only names and values are known, no descriptions or bounds.
                  </p>`
                : nothing
            }
            ${rows.length ? listing(page, told, shown, rows.length) : NONE}`
        : nothing
    }
  </details>`;
}

const NONE = html`<p class="soft">None received yet. The page has requested them.</p>`;

const fits = ({ name, description }, filter) =>
  `${name} ${description ?? ""}`.toLowerCase().includes(filter.trim().toLowerCase());

function listing(page, told, shown, total) {
  return html`<p class="soft" role="status">
      ${shown.length === total ? nothing : `${shown.length} of ${total} shown`}
    </p>
    ${table(
      "Table of parameters",
      "stack broad",
      ["Parameter", "Value", "Bounds", "Default", "State"],
      repeat(
        shown,
        (each) => each.name,
        (each) => row(page, told, each),
      ),
    )}`;
}

function row(page, told, each) {
  const draft = page.ui.drafts.get(each.name);
  const flaw = draft === undefined ? null : wrong(each, draft);
  const id = `p-${each.name}`;
  return html`<tr data-state=${each.state}>
    <th scope="row"><label for=${id}>${each.name}</label><span class="soft">${each.description ?? ""}</span></th>
    <td data-name="Value">
      <form class="value" @submit=${(event) => submit(page, told, each, event)}>
        <input
          id=${id}
          inputmode="decimal"
          autocomplete="off"
          .value=${draft ?? plain(each.value)}
          aria-invalid=${flaw !== null}
          aria-describedby="${id}-state"
          ?disabled=${page.commandsBlocked !== null}
          @input=${(event) => redraft(page, each, event.target.value)}
        />
        <span class="unit">${each.unit ?? ""}</span>
        ${
          draft === undefined
            ? nothing
            : html`<button type="submit" aria-disabled=${flaw !== null}>Set</button>
                <button type="button" class="quiet" @click=${() => redraft(page, each, undefined)}>Undo</button>`
        }
      </form>
    </td>
    <td data-name="Bounds">${bounds(each)}</td>
    <td data-name="Default">${known(each.default) ? plain(each.default) : "–"}</td>
    <td
      data-name="State"
      id="${id}-state"
      class=${flaw || each.state === "refused" || each.state === "no_answer" ? "bad" : ""}
    >
      ${flaw ?? [STATES[each.state] ?? each.state, each.reason].filter(Boolean).join(": ")}
    </td>
  </tr>`;
}

function redraft(page, each, text) {
  const drafts = new Map(page.ui.drafts);
  if (text === undefined || text === plain(each.value)) drafts.delete(each.name);
  else drafts.set(each.name, text);
  page.change({ drafts });
}

function submit(page, told, each, event) {
  event.preventDefault();
  const draft = page.ui.drafts.get(each.name);
  if (draft === undefined || wrong(each, draft) !== null) return;
  page.send({ type: "set", id: told.id, name: each.name, value: Number(draft) });
  redraft(page, each, undefined);
}

/** A float32 as people write it: 0.1, not 0.10000000149. */
export const plain = (value) => (known(value) ? String(Number(value.toPrecision(7))) : "");

/** What is wrong with a text as the value of a parameter; null: nothing. */
export function wrong({ min, max, whole }, text) {
  const value = text.trim() === "" ? NaN : Number(text);
  if (!Number.isFinite(value)) return `expected a number, got ${text.trim() || "nothing"}`;
  if (whole && !Number.isInteger(value)) return `expected a whole number, got ${plain(value)}`;
  if (known(min) && value < min) return `expected at least ${plain(min)}, got ${plain(value)}`;
  if (known(max) && value > max) return `expected at most ${plain(max)}, got ${plain(value)}`;
  return null;
}

function bounds({ min, max }) {
  if (known(min) && known(max)) return `${plain(min)} to ${plain(max)}`;
  return known(min) ? `from ${plain(min)}` : known(max) ? `up to ${plain(max)}` : "not given";
}
