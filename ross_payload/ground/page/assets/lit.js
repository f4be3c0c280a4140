/** What the page uses of lit-html, in one place. */
export { html, nothing, render, svg } from "./vendor/lit-html.js";
export { guard } from "./vendor/directives/guard.js";
export { live } from "./vendor/directives/live.js";
export { repeat } from "./vendor/directives/repeat.js";
