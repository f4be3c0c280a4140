/** The sound of recorded flights: one track of one flight at a time, moved and played as its telemetry is. */

import { momentOf, seekTo } from "../parts/playback.js";

const APART = 0.2; // [s] between sound and telemetry, from which on the sound is moved
const FASTEST = 4; // times, beyond which nobody understands a word
const BRIEF = 0.2; // [s] before the end of the flight, where it stops by itself
const SPAN = 6; // [s] of a comparison
const SETTLED = 700; // [ms] after a move, until what is told is of after it
const NONE = { slot: null, name: null, track: null };

export class FlightSound {
  /** @param {() => void} changed called when there is something new to show */
  constructor(changed) {
    this.changed = changed;
    this.audio = new Audio();
    this.audio.preload = "auto";
    this.chosen = NONE;
    this.comparison = null; // {name, stage: "opening" | "before" | "after", from, since}
    this.error = "";
    this.audio.addEventListener("error", () => this.failed("this browser cannot play it"));
  }

  /** Which track of a slot is heard; null: none. */
  trackOf(slot) {
    return this.chosen.slot === slot ? this.chosen.track : null;
  }

  /** Hear a track of a flight, or nothing of it (null). */
  choose(page, slot, track) {
    this.comparison = null;
    this.hear(page, slot, track);
  }

  hear(page, slot, track) {
    const { name } = page.store.slots[slot].flight;
    this.error = "";
    this.chosen = track ? { slot, name, track } : NONE;
    if (track) this.audio.src = soundOf(name, track);
    else this.audio.removeAttribute("src");
    this.changed();
  }

  /** Play some seconds of the mixture, then the same of the target. */
  compare(page, slot) {
    const { flight } = page.store.slots[slot];
    const target = flight.sound.find((each) => each.track === "target");
    const [at, end] = [momentOf(page, slot), target.begin + target.duration];
    const from = at >= target.begin && at < end - 1 ? at : Math.max(target.begin, 0);
    this.play(page, slot, { name: flight.name, stage: "before", from, until: Math.min(from + SPAN, end, flight.duration) - BRIEF });
  }

  /** Open a flight, and compare as soon as it is there. */
  openAndCompare(page, name) {
    this.comparison = { name, stage: "opening" };
    page.send({ type: "flight", slot: "a", open: name });
    location.hash = "#/flights";
  }

  play(page, slot, comparison) {
    this.hear(page, slot, comparison.stage === "before" ? "mixture" : "target");
    this.comparison = { ...comparison, slot, since: performance.now() };
    page.send({ type: "flight", slot, speed: 1 });
    seekTo(page, slot, comparison.from);
    page.send({ type: "flight", slot, play: true });
  }

  /** After every drawing: be where the telemetry is. */
  follow(page) {
    this.goOn(page);
    const { slot, name, track } = this.chosen;
    if (!track) return this.audio.pause();
    const flight = page.store.slots[slot]?.flight;
    const about = flight?.name === name ? flight.sound.find((each) => each.track === track) : null;
    if (!about || page.route.view !== "flights") return this.silence();
    const at = momentOf(page, slot) - about.begin;
    const inside = at >= 0 && at < about.duration;
    if (inside && Math.abs(this.audio.currentTime - at) > APART) this.audio.currentTime = at;
    if (!inside || !flight.playing || flight.speed > FASTEST) return this.audio.pause();
    this.audio.playbackRate = flight.speed;
    if (this.audio.paused) this.audio.play().catch((error) => error.name === "AbortError" || this.failed(error.message));
  }

  goOn(page) {
    const { comparison } = this;
    if (!comparison) return;
    const slot = comparison.slot ?? "a";
    const flight = page.store.slots[slot]?.flight;
    if (comparison.stage === "opening") {
      if (flight?.name === comparison.name && page.route.view === "flights") this.compare(page, slot);
      return;
    }
    if (flight?.name !== comparison.name) this.comparison = null;
    else if (performance.now() - comparison.since > SETTLED && momentOf(page, slot) >= comparison.until) {
      if (comparison.stage === "before") return this.play(page, slot, { ...comparison, stage: "after" });
      this.comparison = null;
      page.send({ type: "flight", slot, play: false });
      this.changed();
    }
  }

  silence() {
    this.audio.pause();
    this.chosen = NONE;
    if (this.comparison?.stage !== "opening") this.comparison = null;
  }

  failed(why) {
    if (!this.chosen.track) return;
    this.silence();
    this.error = why;
    this.changed();
  }
}

/** Where a track of a flight is to be had. */
const soundOf = (name, track) => `/flights/${encodeURIComponent(name)}/sound/${encodeURIComponent(track)}`;
