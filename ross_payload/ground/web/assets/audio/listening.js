/** Live listening to one payload: a socket that is open for as long as somebody listens, and what plays what comes. */

import { Playout } from "./playout.js";

const RETRY = 1000; // [ms]
const PING = 2000; // [ms]
const HEAD = 8; // bytes before the samples: index, age of the first [ms]
const FULL = 32768;
const QUIET = -90; // [dB]
const RATES = [48000, 24000, 16000, 12000, 8000]; // that the ground process gives [Hz]
const MEASURED = 0.01; // share by which a rate that was measured may be wrong
const REFUSED = 1008; // close code

const decibel = (amplitude) => Math.max(QUIET, 20 * Math.log10(amplitude || 1e-9));
const OFF = { on: false, id: null, phase: "off", told: null, played: null, trip: null, age: null, why: "" };

/** Return the address of the sound of a payload beside this page. */
const soundAddress = ({ protocol, host }, id) =>
  `${protocol === "https:" ? "wss" : "ws"}://${host}/listen?id=${encodeURIComponent(id)}`;

export class Listening {
  /** @param {() => void} changed called whenever there is something new to show */
  constructor(changed) {
    this.changed = changed;
    this.choice = { what: "target" };
    this.volume = 1;
    this.playout = null;
    this.socket = null;
    this.state = OFF;
  }

  /** Begin to listen to a payload; to be called when the user asks for it. @param {?number} rate of its microphones */
  start(id, rate) {
    this.stop();
    this.set({ ...OFF, on: true, id, phase: "connecting" });
    this.play(RATES.find((each) => Math.abs(rate / each - 1) < MEASURED) ?? RATES[0]);
    this.open();
  }

  /** Be silent. */
  stop() {
    clearTimeout(this.retry);
    clearInterval(this.pings);
    const { socket, playout } = this;
    this.socket = this.playout = null;
    socket?.close();
    playout?.close();
    if (this.state.on) this.set(OFF);
  }

  /** Choose what is heard. @param {{what: string, source?: number, azimuth?: number}} choice */
  choose(choice) {
    this.choice = choice;
    this.say({ type: "choose", ...choice });
    this.changed();
  }

  loud(volume) {
    this.volume = volume;
    this.playout?.loud(volume);
    this.changed();
  }

  /** From the microphone to the ear [ms]; null: not known. */
  get delay() {
    const { age, trip, played } = this.state;
    if (age === null || !played?.playing) return null;
    return age + (trip ?? 0) / 2 + 1000 * (played.waiting + (this.playout?.latency ?? 0));
  }

  /** What is heard at the moment [dB re full scale]. */
  get level() {
    const { played } = this.state;
    return played ? { rms: decibel(played.rms), peak: decibel(played.peak) } : { rms: null, peak: null };
  }

  open() {
    const socket = new WebSocket(soundAddress(location, this.state.id));
    socket.binaryType = "arraybuffer";
    socket.addEventListener("open", () => {
      this.say({ type: "choose", ...this.choice });
      clearInterval(this.pings);
      const ping = () => this.say({ type: "ping", at: performance.now() });
      this.pings = setInterval(ping, PING);
      ping();
    });
    socket.addEventListener("message", ({ data }) => socket === this.socket && this.take(data));
    socket.addEventListener("close", (event) => socket === this.socket && this.closed(event));
    this.socket = socket;
  }

  closed({ code }) {
    clearInterval(this.pings);
    this.socket = null;
    if (code === REFUSED) {
      const { why } = this.state;
      this.stop();
      this.set({ ...OFF, phase: "refused", why });
      return;
    }
    this.set({ ...this.state, phase: "connecting", told: null, age: null });
    this.retry = setTimeout(() => this.open(), RETRY);
  }

  say(message) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  take(data) {
    if (data instanceof ArrayBuffer) return this.hear(data);
    const message = JSON.parse(data);
    if (message.type === "pong") this.set({ ...this.state, trip: performance.now() - message.at });
    else if (message.type === "refused") this.set({ ...this.state, why: message.why });
    else if (message.type === "listening") this.follow(message);
  }

  follow(told) {
    if (this.playout?.rate !== told.rate) this.play(told.rate);
    this.choice = told.choice;
    this.set({ ...this.state, phase: told.state, why: told.why, told });
  }

  hear(data) {
    const age = new DataView(data).getFloat32(4, true);
    this.state = { ...this.state, age: Number.isFinite(age) ? age : null };
    this.playout?.push(Float32Array.from(new Int16Array(data, HEAD), (sample) => sample / FULL));
  }

  play(rate) {
    this.playout?.close();
    const playout = new Playout(rate, (played) => playout === this.playout && this.set({ ...this.state, played }));
    playout.loud(this.volume);
    playout.ready.catch((error) => playout === this.playout && this.failed(error)); // or it was closed meanwhile
    this.playout = playout;
  }

  failed(error) {
    this.stop();
    this.set({ ...OFF, phase: "refused", why: `this browser cannot play it: ${error.message}` });
  }

  set(state) {
    this.state = state;
    this.changed();
  }
}
