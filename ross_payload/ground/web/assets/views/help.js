/** Help beside the page, not over it: the stop stays in reach. */

import { html } from "../templates.js";
import { fact } from "../parts/tables.js";

const KEYS = [
  ["Escape twice, or held", "Stop. On the page of one payload that payload, elsewhere all of them. Works while typing, too."],
  ["Escape", "Cancel a drag or a chosen heading; close this help, or the form of an enrolment."],
  ["?", "Open or close this help."],
  ["Tab, Enter, Space", "Move to and press any control."],
  ["Arrow keys", "Move the goal in the polar view, pan the map, move through a flight."],
  ["+ and −", "Zoom the map. 0 shows everything."],
  ["Space on a flight’s slider", "Play or pause."],
];

export function helpPanel(page) {
  return html`<aside id="help" class="help" aria-label="Help" ?hidden=${!page.ui.help}>
    <h2>Help</h2>
    <p>
      The payload turns two microphones until the interfering voices arrive with the same delay, then separates the
      target voice. <strong>Explore</strong> finds the number of sources and their azimuths.
      <strong>Listen</strong> turns to one voice and separates it.
    </p>
    <h3>Keys</h3>
    <dl class="keys">
      ${KEYS.map(fact)}
    </dl>
    <h3>Stop</h3>
    <p>
      One press, no confirmation, from any browser, whoever has control. The motor stops. Nothing moves again until
      <strong>Rearm</strong>.
    </p>
    <h3>Control</h3>
    <p>
      One browser at a time sends commands. The first to send one takes control while no other browser has it. Another can take
      control; both are notified.
    </p>
    <h3>Terms</h3>
    <p>
      Angles are degrees clockwise: from north when the payload knows its attitude, otherwise from the payload's nose. K is the
      number of sources. SI-SDR is the quality of the separated voice, in dB. Health is Good, Warning (check when you
      can), Critical (act now) or No data.
    </p>
    <button type="button" @click=${() => page.change({ help: false })}>Close</button>
  </aside>`;
}
