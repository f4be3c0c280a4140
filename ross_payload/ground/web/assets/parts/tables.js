/** Tables, lists of terms and values, and words that move nothing when they change. */

import { html, nothing } from "../templates.js";

/** A table that can be scrolled; `rows` are its `<tr>`. @param {string[]} heads */
export const table = (label, kind, heads, rows) =>
  html`<div class="scroll" tabindex="0" role="region" aria-label=${label}>
    <table class=${kind}>
      <thead>
        <tr>
          ${heads.map((head) => html`<th scope="col">${head}</th>`)}
        </tr>
      </thead>
      <tbody>
        ${rows}
      </tbody>
    </table>
  </div>`;

/** Words in the room that the longest ones need which may stand there: what is beside and below stays where it is. */
export const roomy = (words, longest) =>
  html`<span class="room" data-room=${longest}><span>${words}</span></span>`;

/** One row of a description list; `remark` is left out where a list has none. `longest`: the remark in its room. */
export const fact = ([term, value, remark, longest = ""]) =>
  html`<div>
    <dt>${term}</dt>
    <dd>${value}</dd>
    ${remark === undefined ? nothing : html`<dd class="soft">${roomy(remark ?? "", longest)}</dd>`}
  </div>`;
