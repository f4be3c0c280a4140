/** The mission strip: what the mission does and has reached, in numbers that a glance takes in. */

import { html } from "../templates.js";
import { DASH, decibels, degrees, duration, known, number } from "../formatting.js";
import { fact, roomy } from "./tables.js";

const LONGEST = "Listens at a candidate, separates and compares voices with the enrolled one."; // of what states mean

export function missionFacts({ mission = {}, standing = {}, pointing = {} }) {
  const facts = [
    ["Orientation", rotation(mission), null],
    ["Elapsed", ...elapsed(mission, standing), "of unknown duration"],
    [
      "Sources (K)",
      number(mission.k),
      known(mission.k) ? (mission.certain ? "final" : "so far") : "no estimate yet",
      "no estimate yet",
    ],
    [
      "Voice score",
      number(mission.score, 2),
      known(mission.criterion) ? `criterion ${number(mission.criterion, 2)}` : "no voice compared yet",
      "no voice compared yet",
    ],
    [
      "SI-SDR, estimated",
      decibels(mission.si_sdr),
      known(mission.si_sdr) ? improvement(mission) : "no separation yet",
      "−10.0 dB better than the mixture",
    ],
    [
      "Predicted gain",
      decibels(mission.gain),
      known(mission.gain) ? "at the chosen heading" : "no heading chosen yet",
      known(mission.gain) ? "no heading chosen yet" : "at the chosen heading",
    ],
    ["Heading", degrees(pointing.heading), goal(pointing), "turning to 000°"],
    ["Target", target(mission), targetRemark(mission), "selected; not recognised as the enrolled voice"],
  ];
  return html`<section class="card mission" aria-label="Mission">
    <h2>Mission</h2>
    <p class="soft">${roomy(meaning(standing), LONGEST)}</p>
    <dl class="facts">${facts.map(fact)}</dl>
  </section>`;
}

/** What it does, and what keeps it from moving. */
const meaning = ({ state, state_meaning: words = "" }) =>
  state === "stopped" ? `${words} It will not move until it is rearmed.` : words;

function rotation({ rotation: step, rotation_max: most }) {
  if (!known(step)) return DASH;
  return known(most) ? `${step} of ${most}` : `${step}`;
}

function elapsed({ elapsed: time, expected }, { state }) {
  if (!known(time)) return [DASH, state === "idle" ? "no mission yet" : "start not received"];
  return [duration(time), known(expected) ? `of about ${duration(expected)}` : "of unknown duration"];
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
