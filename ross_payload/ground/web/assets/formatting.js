/** Numbers and states in words. Every number has its unit; what is not known is an en dash. */

export const DASH = "–";

const STATES = {
  idle: "Idle",
  lead_in: "Measuring the noise",
  explore_turn: "Exploring: turning",
  explore_listen: "Exploring: listening",
  align_turn: "Aligning: turning",
  check: "Checking a candidate",
  run: "Separating the voice",
  done: "Done",
  stopped: "Stopped",
  fault: "Fault",
  turn: "Turning",
  noise: "Measuring the noise",
};
const LEVELS = { good: "Good", watch: "Warning", act: "Critical", unknown: "No data" };
const SEVERITIES = ["emergency", "alert", "critical", "error", "warning", "notice", "info", "debug"];
const FATES = {
  sent: "sent, not yet acknowledged",
  acknowledged: "acknowledged",
  in_progress: "in progress",
  done: "done",
  refused: "refused",
  failed: "failed",
  cancelled: "cancelled",
  no_answer: "no answer",
};
const TROUBLE = 4; // MAV_SEVERITY: warning and worse

/** Whether a value is a number that can be shown. */
export const known = (value) => typeof value === "number" && Number.isFinite(value);

/** @param {?number} value @param {number} digits @param {string} unit with its space, as in " dB" or "°" */
export function number(value, digits = 0, unit = "") {
  if (!known(value)) return DASH;
  const text = value.toFixed(digits);
  return `${Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−")}${unit}`;
}

/** A direction, 0 to 359 degrees. */
export const degrees = (value) => (known(value) ? `${number(((Math.round(value) % 360) + 360) % 360)}°` : DASH);

export const decibels = (value) => number(value, 1, " dB");

/** A duration: 0.4 s, 12 s, 3 min 5 s, 2 h 10 min. */
export function duration(seconds) {
  if (!known(seconds)) return DASH;
  if (seconds < 10) return number(seconds, 1, " s");
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${whole % 60} s`;
  return `${Math.floor(whole / 3600)} h ${Math.floor((whole % 3600) / 60)} min`;
}

/** How long ago, about; from 0: a clock that runs a little behind is no news from the future. */
export function ago(seconds) {
  if (!known(seconds)) return "never";
  if (seconds < 60) return `${duration(Math.max(0, Math.min(seconds, 59)))} ago`;
  return seconds < 3600 ? `${Math.floor(seconds / 60)} min ago` : `${Math.floor(seconds / 3600)} h ago`;
}

/** A moment in a recording: m:ss. */
export function clock(seconds) {
  if (!known(seconds)) return DASH;
  const whole = Math.max(0, Math.floor(seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}

/** UNIX seconds as date and time, UTC. */
export function utc(seconds) {
  if (!known(seconds)) return DASH;
  return `${new Date(seconds * 1000).toISOString().slice(0, 19).replace("T", " ")} UTC`;
}

export function size(bytes) {
  if (!known(bytes)) return DASH;
  const [share, unit] = bytes < 1e3 ? [1, "B"] : bytes < 1e6 ? [1e3, "kB"] : bytes < 1e9 ? [1e6, "MB"] : [1e9, "GB"];
  return number(bytes / share, share === 1 ? 0 : 1, ` ${unit}`);
}

export const share = (value) => number(known(value) ? value * 100 : null, 0, " %");
export const state = (name) => (name == null ? "State unknown" : (STATES[name] ?? `State ${name}`));
export const level = (name) => LEVELS[name] ?? LEVELS.unknown;
export const severity = (code) => SEVERITIES[code] ?? "info";
export const isTrouble = (code) => code <= TROUBLE;
export const fate = (name) => FATES[name] ?? name;
export const frame = (earth) => (earth ? "clockwise from north" : "clockwise from the nose");

/** Words as a sentence begins. */
export const capital = (words) => `${words.charAt(0).toUpperCase()}${words.slice(1)}`;

/** One of a few, or many: `plural(1, "source")` is "1 source". */
export const plural = (count, noun) => `${count} ${noun}${count === 1 ? "" : "s"}`;

/** Whether an order in this state has its final answer. */
export const isOver = (name) => !["sent", "acknowledged", "in_progress"].includes(name);
