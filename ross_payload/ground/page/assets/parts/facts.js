/** What is known of a thing, as terms and values. */

import { html, nothing } from "../lit.js";

/** One row of a description list; `remark` is left out where a list has none. */
export const fact = ([term, value, remark]) =>
  html`<div>
    <dt>${term}</dt>
    <dd>${value}</dd>
    ${remark === undefined ? nothing : html`<dd class="soft">${remark ?? ""}</dd>`}
  </div>`;
