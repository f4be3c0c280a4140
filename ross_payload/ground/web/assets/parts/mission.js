/** The mission strip: what the mission does and has reached, in numbers that a glance takes in. */

import { html } from "../templates.js";
import { DASH, decibels, degrees, duration, known, number } from "../formatting.js";
import { fact } from "./tables.js";

export function missionFacts({ mission = {}, standing = {}, pointing = {} }) {
  const facts = [
    ["Orientation", rotation(mission), null],
    ["Elapsed", ...elapsed(mission, standing)],
    ["Sources (K)", number(mission.k), known(mission.k) ? (mission.certain ? "final" : "so far") : "no estimate yet"],
    [
      "Voice score",
      number(mission.score, 2),
      known(mission.criterion) ? `criterion ${number(mission.criterion, 2)}` : "no voice compared yet",
    ],
    ["SI-SDR, estimated", decibels(mission.si_sdr), known(mission.si_sdr) ? improvement(mission) : "no separation yet"],
    ["Predicted gain", decibels(mission.gain), known(mission.gain) ? "at the chosen heading" : "no heading chosen yet"],
    ["Heading", degrees(pointing.heading), goal(pointing)],
    ["Target", target(mission), targetRemark(mission)],
  ];
  return html`<section class="card mission" aria-label="Mission">
    <h2>Mission</h2>
    <p class="soft">${standing.state_meaning ?? ""}</p>
    <dl class="facts">${facts.map(fact)}</dl>
  </section>`;
}

function rotation({ rotation: step, rotation_max: most }) {
  if (!known(step)) return DASH;
  return known(most) ? `${step} of ${most}` : `${step}`;
}

function elapsed({ elapsed: time, expected }, { state }) {
  if (!known(time)) return [DASH, state === "idle" ? "no mission yet" : "start not received"];
  return [duration(time), known(expected) ? `of about ${duration(expected)}` : "expected duration unknown"];
}

const improvement = (mission) =>
  known(mission.si_sdri) ? `${number(mission.si_sdri, 1, " dB")} better than the mixture` : "";
const goal = ({ goal: to, settled }) =>
  known(to) && !settled ? `turning to ${degrees(to)}` : settled ? "settled" : "";
const target = ({ target: source }) => (known(source) ? `Source ${source}` : DASH);

/** Whether the target is the enrolled voice: one can be chosen before it is recognised, and voices may be unlike. */
function targetRemark({ target: source, target_found: found }) {
  if (!known(source)) return "no target yet";
  return found ? "recognised as the enrolled voice" : "selected; not recognised as the enrolled voice";
}
