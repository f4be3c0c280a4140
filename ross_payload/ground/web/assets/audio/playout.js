/** The way of samples to the loudspeaker: buffer, volume, and what shows their spectrum. */

import { PlayoutBuffer } from "./playout-buffer.js";

const BLOCK = 1024; // samples of a browser without worklets
const FFT = 1024;
const FLOOR = -100; // [dB] that is black

export class Playout {
  /** @param {number} rate of the samples [Hz] @param {(told: object) => void} onTold how it goes, ten times a second */
  constructor(rate, onTold) {
    this.rate = rate;
    this.context = new AudioContext({ sampleRate: rate, latencyHint: "interactive" });
    this.volume = new GainNode(this.context);
    this.spectrum = new AnalyserNode(this.context, {
      fftSize: FFT,
      minDecibels: FLOOR,
      maxDecibels: -20,
      smoothingTimeConstant: 0.2,
    });
    this.spectrum.connect(this.volume).connect(this.context.destination);
    this.ready = this.begin(onTold);
  }

  /** Worklets are for pages that nobody between can change (HTTPS, or this computer); elsewhere there is an older way. */
  async begin(onTold) {
    if (this.context.audioWorklet) {
      await this.context.audioWorklet.addModule("/assets/audio/playout-worklet.js");
      if (this.context.state === "closed") return; // meanwhile
      const options = { numberOfInputs: 0, outputChannelCount: [1] };
      const node = new AudioWorkletNode(this.context, "playout", options);
      node.port.onmessage = ({ data }) => onTold(data);
      this.push = (samples) => node.port.postMessage(samples, [samples.buffer]);
      node.connect(this.spectrum);
    } else this.beginWithoutWorklet(onTold);
    await this.context.resume();
  }

  beginWithoutWorklet(onTold) {
    const buffer = new PlayoutBuffer(this.rate);
    const node = this.context.createScriptProcessor(BLOCK, 1, 1);
    node.onaudioprocess = ({ outputBuffer }) => {
      const output = outputBuffer.getChannelData(0);
      buffer.pull(output);
      const energy = output.reduce((sum, sample) => sum + sample * sample, 0);
      const peak = output.reduce((most, sample) => Math.max(most, Math.abs(sample)), 0);
      const times = { waiting: buffer.waiting / this.rate, target: buffer.target / this.rate };
      onTold({ ...buffer.counts, ...times, playing: buffer.playing, rms: Math.sqrt(energy / output.length), peak });
    };
    this.push = (samples) => buffer.push(samples);
    this.node = node; // or nobody would hold it
    node.connect(this.spectrum);
  }

  /** Play samples; before all is ready they are left out. @param {Float32Array} samples */
  push() {}

  /** From here to the ear [s], as far as the browser knows. */
  get latency() {
    return (this.context.baseLatency || 0) + (this.context.outputLatency || 0);
  }

  loud(volume) {
    this.volume.gain.setTargetAtTime(volume, this.context.currentTime, 0.02);
  }

  close() {
    this.push = () => {};
    this.context.close();
  }
}
