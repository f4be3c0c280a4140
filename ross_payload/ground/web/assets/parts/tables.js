/** Tables, and lists of terms and values. */

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

/** One row of a description list; `remark` is left out where a list has none. */
export const fact = ([term, value, remark]) =>
  html`<div>
    <dt>${term}</dt>
    <dd>${value}</dd>
    ${remark === undefined ? nothing : html`<dd class="soft">${remark ?? ""}</dd>`}
  </div>`;
