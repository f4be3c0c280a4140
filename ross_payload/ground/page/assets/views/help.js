/** Help beside the page, not over it: the stop stays in reach. */

import { html } from "../lit.js";
import { fact } from "../parts/facts.js";

const KEYS = [
  ["Escape twice, or held", "Stop. On a payload’s page that payload, elsewhere all. It works in every field, too."],
  ["Escape", "Give up a drag; close this help."],
  ["?", "Open or close this help."],
  ["Tab, Enter, Space", "Reach and press everything."],
  ["Arrow keys", "Turn the goal in the picture, move the map, move in a flight’s time."],
  ["+ and −", "Zoom the map. 0 shows everything."],
  ["Space on a flight’s time", "Play or pause."],
];

export function helpPanel(page) {
  return html`<aside id="help" class="help" aria-label="Help" ?hidden=${!page.ui.help}>
    <h2>Help</h2>
    <p>
      The payload turns two microphones so that unwanted voices pose as one, and separates the wanted one.
      <strong>Explore</strong> finds out who talks, and where. <strong>Listen</strong> finds a voice and keeps to it.
    </p>
    <h3>Keys</h3>
    <dl class="keys">
      ${KEYS.map(fact)}
    </dl>
    <h3>Stop</h3>
    <p>
      One press, no question, from every browser, whoever has control. The motor halts. Nothing moves again before
      <strong>Rearm</strong>.
    </p>
    <h3>Control</h3>
    <p>
      One browser gives orders. The first that orders takes control while it is free; another one can take it, and both
      see it.
    </p>
    <h3>Words</h3>
    <p>
      Degrees count clockwise: from north when the payload knows its attitude, else from its nose. K is the
      number of sources. SI-SDR tells how clean a voice is, in dB. Red means that something must be done.
    </p>
    <button type="button" @click=${() => page.change({ help: false })}>Close</button>
  </aside>`;
}
