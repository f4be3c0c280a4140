/** The heading that a finger has chosen in the polar view: nothing turns before it is confirmed. */

import { turn } from "../instruments/geometry.js";
import { html, nothing } from "../templates.js";
import { degrees, known } from "../formatting.js";

const ASKED = 10_000; // [ms] that is waited for a confirmation
const SAME = 1; // degrees by which a goal differs that is the same

/** Ask whether a payload shall turn. */
export const choose = (page, { id, sections }, heading) =>
  page.change({ drag: null, chosen: { id, heading, at: performance.now(), before: movement(sections) } });

/** The chosen heading while it can be confirmed: not for long, nor once the payload was stopped or turned otherwise. */
export function chosenHeading(page) {
  const { chosen } = page.ui;
  const told = page.store.payload;
  if (!chosen || told?.id !== chosen.id || performance.now() - chosen.at > ASKED) return null;
  return isAsBefore(chosen.before, movement(told.sections)) ? chosen : null;
}

/** The question over the end of the polar view; nothing while no heading is chosen. */
export function confirmation(page, told) {
  const { chosen } = page.ui;
  if (chosen?.id !== told.id) return nothing;
  const confirmed = () => {
    const stands = chosenHeading(page) === chosen; // what came since the last drawing may have ended it
    page.change({ chosen: null });
    if (stands) page.order(told.id, { kind: "turn", heading: chosen.heading });
  };
  return html`<div class="buttons confirmation" role="group" aria-label="Chosen heading">
    <button type="button" class="main" ?disabled=${page.commandsBlocked !== null} @click=${confirmed}>
      Turn to ${degrees(chosen.heading)}
    </button>
    <button type="button" @click=${() => page.change({ chosen: null })}>Cancel</button>
  </div>`;
}

function movement({ standing = {}, pointing = {}, orders = [] }) {
  const { state, boots } = standing;
  return { state, boots, earth: pointing.earth, goal: pointing.goal, order: orders.at(-1)?.number };
}

function isAsBefore(before, now) {
  const stopped = now.state === "stopped" && before.state !== "stopped";
  if (stopped || ["boots", "earth", "order"].some((each) => now[each] !== before[each])) return false;
  if (explores(before) && explores(now)) return true; // it turns on and on
  return known(now.goal) && known(before.goal) ? Math.abs(turn(before.goal, now.goal)) < SAME : known(now.goal) === known(before.goal);
}

const explores = ({ state }) => Boolean(state?.startsWith("explore"));
