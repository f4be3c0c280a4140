/** The page: one store, one state of the screen, at most one drawing per frame. */

import { announce } from "./announce.js";
import { FlightSound } from "./audio/flight-sound.js";
import { Listening } from "./audio/listening.js";
import { Spectrogram } from "./audio/spectrogram.js";
import { pressed } from "./keyboard.js";
import { html, render } from "./templates.js";
import { blank, closed, connect, liveAddress, take, watching } from "./connection.js";
import { banners } from "./parts/banners.js";
import { header } from "./parts/header.js";
import { chosenHeading } from "./parts/chosen-heading.js";
import { joined } from "./parts/comparison.js";
import { answered } from "./parts/playback.js";
import { routeOf, titleOf } from "./route.js";
import { isHasty, watchingMoves } from "./steadiness.js";
import { SAID_AGAIN, doubted, followed, noted, rearmed, unstopped } from "./stop.js";
import { applyTheme, readTheme } from "./theme.js";
import { fleetView } from "./views/fleet.js";
import { dropped, flightsView, isOfFiles } from "./views/flights.js";
import { helpPanel } from "./views/help.js";
import { mapView } from "./views/map.js";
import { payloadView } from "./views/payload.js";

const LOOK = 250; // [ms] between two drawings when nothing comes: ages grow
const MOST_LATENCIES = 2000;
const VIEWS = { fleet: fleetView, payload: payloadView, map: mapView, flights: flightsView };

/** Everything a view needs: what is known, how the screen is, and how to change either. */
class Page {
  constructor() {
    this.route = routeOf(location.hash);
    this.store = blank(this.route.id);
    this.socket = { up: false, ever: false, since: performance.now() };
    this.ui = {
      theme: readTheme(),
      help: false,
      selected: null,
      hovered: null,
      drag: null,
      chosen: null, // heading that a finger has chosen, to be confirmed
      stop: null,
      filter: "",
      drafts: new Map(),
      seeks: {},
      upload: null,
      map: null,
      cursor: null,
      mapSize: [800, 600],
      compare: false,
      deleting: null, // recording of which is asked whether it shall be deleted: its name, and since when
      enrolling: null, // source whose talker is to be enrolled
      lastEscape: -Infinity,
    };
    this.listening = new Listening(() => this.draw());
    this.spectrogram = new Spectrogram();
    this.flightSound = new FlightSound(() => this.draw());
    this.shut = new Set(); // slots that were closed, until a flight is opened there
    this.due = false;
    this.live = null;
  }

  start() {
    globalThis.rossSound = { live: this.listening, recorded: this.flightSound }; // tests hear what is played
    applyTheme(this.ui.theme);
    this.live = connect(() => liveAddress(location, this.store.you, this.store.proof), {
      message: (message) => {
        if (this.shut.has(message.slot)) return; // it was on its way when the slot was closed
        const before = this.store;
        this.store = take(before, message, performance.now());
        this.ui = { ...this.ui, stop: noted(this) };
        this.onMessage(message, before);
      },
      up: () => this.changeSocket({ up: true, ever: true, since: performance.now() }),
      down: () => {
        this.ui = { ...this.ui, stop: doubted(this) };
        this.changeSocket({ ...this.socket, up: false, since: this.socket.up ? performance.now() : this.socket.since });
      },
    });
    addEventListener("hashchange", () => this.go(routeOf(location.hash)));
    addEventListener("keydown", (event) => pressed(this, event));
    addEventListener("dragover", (event) => isOfFiles(event) && event.preventDefault());
    addEventListener("drop", (event) => isOfFiles(event) && dropped(this, event));
    setInterval(() => this.look(), LOOK);
    this.draw();
  }

  onMessage(message, before) {
    if (message.type === "hello") this.resume();
    if (message.type === "flight") {
      answered(this, message.slot);
      joined(this, message.slot, before);
    }
    this.draw();
  }

  /** After a reconnect the ground process knows nothing of this browser: say again what is watched. */
  resume() {
    if (this.route.view === "payload") this.send({ type: "watch", id: this.route.id });
    for (const [slot, each] of Object.entries(this.store.slots)) {
      if (!each?.flight) continue;
      this.send({ type: "flight", slot, open: each.flight.name });
      this.send({ type: "flight", slot, seek: each.flight.at });
      this.send({ type: "flight", slot, speed: each.flight.speed });
      if (each.flight.playing) this.send({ type: "flight", slot, play: true });
      if (each.payload) this.send({ type: "flight", slot, watch: each.payload.id });
    }
    this.stopAgain();
  }

  changeSocket(socket) {
    this.socket = socket;
    this.draw();
  }

  go(route) {
    const before = this.route;
    this.route = route;
    if (route.id !== before.id) this.watch(route.id);
    this.change({ help: false });
    requestAnimationFrame(() => document.querySelector("main h1")?.focus({ preventScroll: true }));
    scrollTo(0, 0);
  }

  watch(id) {
    this.listening.stop(); // what is heard is what is on the screen
    this.store = watching(this.store, id);
    this.ui = { ...this.ui, selected: null, hovered: null, drag: null, chosen: null, cursor: null, drafts: new Map(), filter: "", enrolling: null };
    this.send(id ? { type: "watch", id } : { type: "unwatch" });
  }

  /** Change how the screen is, and draw it. */
  change(patch) {
    this.ui = { ...this.ui, ...patch };
    this.draw();
  }

  /** Send a message to the ground process; false: there is no link to it. */
  send(message) {
    if (message.type === "flight" && message.open) this.shut.delete(message.slot);
    return this.live?.send(message) ?? false;
  }

  order(id, order) {
    if (isHasty(order)) return this.withhold(order);
    if (order.kind === "rearm") this.ui = { ...this.ui, stop: rearmed(this.ui.stop, id) }; // it shall move again
    return this.send({ type: "order", id, order });
  }

  /** Send nothing, and say so. */
  withhold({ kind: what }) {
    const refused = { type: "refused", what, reason: "the page had just moved under the pointer; press again" };
    this.store = take(this.store, refused, performance.now());
    this.draw();
    return false;
  }

  /** Stop these payloads. Without a link it is sent as soon as there is one: a late stop still stops. */
  stop(ids) {
    const { stop } = this.ui;
    const earlier = unstopped(stop, ids); // they are still to be stopped
    const all = [...ids, ...Object.keys(earlier)];
    const sent = this.over !== "" || (stop?.waiting ? all : ids).map((id) => this.order(id, { kind: "stop" })).every(Boolean);
    this.change({
      stop: { ids: all, at: performance.now(), now: this.now(), waiting: !sent, stopped: [], earlier },
      chosen: null,
    });
  }

  /** Say a stop again to whom it has not stopped: it may have been lost with the old socket. */
  stopAgain() {
    const { stop } = this.ui;
    if (!stop || stop.confirmed || !(stop.waiting || performance.now() - stop.at < SAID_AGAIN)) return;
    const sent = stop.ids
      .filter((id) => !stop.stopped.includes(id))
      .map((id) => this.order(id, { kind: "stop" }))
      .every(Boolean);
    const at = stop.waiting ? performance.now() : stop.at;
    const earlier = stop.waiting ? {} : stop.earlier;
    this.change({ stop: { ...stop, at, now: this.now(), waiting: !sent, earlier } });
  }

  closeSlot(slot) {
    this.send({ type: "flight", slot, close: true });
    this.store = closed(this.store, slot);
    this.shut.add(slot);
    this.draw();
  }

  /** Why no payload can be heard any more, as a sentence: its simulation has ended. Empty: it can. */
  get over() {
    return this.store.fleet?.over ?? "";
  }

  /** Why nobody can give a command here, in words; null: commands are sent, and the payload decides. */
  get commandsBlocked() {
    const { mayOrder, control } = this.store;
    if (!this.socket.up) return "No connection to the ground process: commands cannot be sent.";
    if (!mayOrder) return "Recordings do not accept commands.";
    if (this.over) return `${this.over} Commands are no longer accepted.`;
    if (control.holder && !control.yours)
      return `${control.name ?? control.holder} has control. Take control to send commands.`;
    return null;
  }

  /** The ground process's clock [s], carried on while it is silent. */
  now() {
    const { fleet, fleetGot, payload } = this.store;
    const [base, got] = payload && payload.got > fleetGot ? [payload.now, payload.got] : [fleet?.now, fleetGot];
    return base == null ? null : base + (performance.now() - got) / 1000;
  }

  /** Seconds since the ground process itself was heard; null: it never was. */
  silence() {
    const got = Math.max(this.store.fleetGot, this.store.payload?.got ?? 0);
    return got ? (performance.now() - got) / 1000 : null;
  }

  /** A browser draws nothing in a tab that is not seen; it is heard all the same. */
  look() {
    if (document.hidden) this.flightSound.follow(this);
    this.draw();
  }

  draw() {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      watchingMoves(() => this.paint());
    });
  }

  paint() {
    this.ui = { ...this.ui, stop: followed(this), chosen: chosenHeading(this) };
    const view = VIEWS[this.route.view];
    render(
      html`<div class="pinned">${header(this)}</div>
        <main id="main" class="view view-${this.route.view}">${view(this)}</main>
        ${banners(this)}
        ${helpPanel(this)}`,
      document.getElementById("page"),
    );
    document.title = `${titleOf(this.route)} · RoSS ground`;
    announce(this);
    this.flightSound.follow(this);
    this.spectrogram.follow(document.querySelector(".spectrogram"), this.listening.playout?.spectrum ?? null);
    this.fitMap();
    this.measure();
  }

  /** The map is drawn in pixels: draw it again when its place has another size. */
  fitMap() {
    const box = document.querySelector(".map");
    if (!box) return;
    const [width, height] = this.ui.mapSize;
    if (box.clientWidth === width && box.clientHeight === height) return;
    this.change({ mapSize: [box.clientWidth, box.clientHeight] });
  }

  /** Tell tests when the newest message of the watched payload was on the screen: `rossLatency`, and an event. */
  measure() {
    const told = this.store.payload;
    if (!told || told === this.measured || told.heard == null) return;
    this.measured = told;
    const entry = { heard: told.heard, drawn: performance.timeOrigin + performance.now() }; // UNIX time [ms]
    globalThis.rossLatency = [...(globalThis.rossLatency ?? []), entry].slice(-MOST_LATENCIES);
    dispatchEvent(new CustomEvent("ross-drawn", { detail: entry }));
  }
}

document.getElementById("page").replaceChildren();
new Page().start();
