/** The keyboard of the whole page. Views add their own keys where they have focus. */

import { letGo } from "./instruments/scope-axis.js";
import { closeEnrolment } from "./parts/enrolment.js";
import { stopTargets } from "./stop.js";

const TWICE = 1000; // [ms] between two presses of Escape that stop

/**
 * Escape twice within a second, or held, stops: it types nothing, so that it works in every field. `?` shows the help.
 * A first Escape gives up a drag and a chosen heading, and closes the help and the form of an enrolment.
 */
export function pressed(page, event) {
  if (event.key === "Escape") escape(page, event);
  else if (event.key === "?" && !isTyping(event.target)) page.change({ help: !page.ui.help });
}

function escape(page, event) {
  closeEnrolment();
  letGo();
  const again = event.repeat || event.timeStamp - page.ui.lastEscape < TWICE;
  if (again && !(event.repeat && page.ui.lastEscape < 0)) {
    page.stop(stopTargets(page));
    page.change({ lastEscape: -Infinity, drag: null, chosen: null }); // a held key stops once
    return;
  }
  if (event.repeat) return;
  page.change({ lastEscape: event.timeStamp, drag: null, chosen: null, help: false });
}

function isTyping(element) {
  return element instanceof HTMLElement && (element.matches("input, select, textarea") || element.isContentEditable);
}
