/** Sources and candidates as tables: the scope for those who read or use the keyboard. */

import { glyph } from "../instruments/colours.js";
import { html, nothing } from "../templates.js";
import { DASH, degrees, known, number } from "../formatting.js";
import { enrolButton } from "./enrolment.js";
import { table } from "./tables.js";

export function sources(page, told, mayOrder) {
  const list = told.sections.sources ?? [];
  if (!list.length) return html`<p class="soft">No sources yet. Start an exploration to find them.</p>`;
  return html`${mayOrder ? listen(page, told) : nothing}
    ${table(
      "Table of sources",
      "sources stack",
      ["Source", "Azimuth", "Confidence", "Score"],
      list.map((each) => row(page, each)),
    )}`;
}

function row(page, source) {
  const selected = page.ui.selected === source.source;
  const choose = () => page.change({ selected: selected ? null : source.source });
  return html`<tr
    class=${selected ? "selected" : ""}
    @pointerenter=${() => page.change({ hovered: source.source })}
    @pointerleave=${() => page.change({ hovered: null })}
  >
    <th scope="row">
      <button type="button" class="quiet" aria-pressed=${selected} @click=${choose}>
        ${glyph(source.source)} Source
        ${source.source}${source.target ? html` <span class="tag">target</span>` : nothing}
      </button>
    </th>
    <td data-name="Azimuth">${degrees(source.azimuth)} ± ${number(source.sigma, 1, "°")}${mirror(source)}</td>
    <td data-name="Confidence">${known(source.confidence) ? number(source.confidence * 100, 0, " %") : DASH}</td>
    <td data-name="Score">${number(source.score, 2)}</td>
  </tr>`;
}

/** Two microphones have no front: until it is resolved, the source may be on the other side of the axis. */
const mirror = ({ resolved, mirror: other }) =>
  html` <span class="soft mirrored">${resolved || !known(other) ? "" : `or ${degrees(other)}`}</span>`;

const UNSELECTED = html`<p class="soft choice">
  Select a source here or in the polar view to listen to it or enrol it.
</p>`;

/** It stands above the table, which grows. */
function listen(page, told) {
  const { selected } = page.ui;
  const there = (told.sections.sources ?? []).some((each) => each.source === selected);
  if (!there) return UNSELECTED;
  return html`<p class="buttons choice">
    <button
      type="button"
      class="main"
      ?disabled=${page.commandsBlocked !== null}
      @click=${() => page.order(told.id, { kind: "listen", source: selected })}
    >
      Listen to source ${selected}
    </button>
    ${enrolButton(page, selected)}
  </p>`;
}

const RULES = { turning: "turning to it", accepted: "accepted", rejected: "tried and rejected", planned: "planned" };

export function candidates({ plan = {} }) {
  const list = plan.candidates ?? [];
  if (!list.length) return nothing;
  return html`<ol class="candidates" aria-label="Alignment candidates">
    ${list.map(
      (each) =>
        html` <li class=${each.candidate === plan.current ? "current" : ""}>
          <strong>${degrees(each.heading)}</strong>
          for source ${each.source}: ${RULES[each.state] ?? each.state}.
          ${each.aliased.length > 1 ? `Sources ${each.aliased.join(" and ")} have the same delay here.` : ""}
          <span class="soft"
            >${each.candidate === plan.current ? each.rule_meaning : nothing}
            ${known(each.gain) ? `Predicted gain ${number(each.gain, 1, " dB")}.` : ""}</span
          >
        </li>`,
    )}
  </ol>`;
}
