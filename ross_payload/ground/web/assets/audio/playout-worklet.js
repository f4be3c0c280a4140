/** Plays a stream on the thread of the sound card: samples come by messages, and how it goes is told four times a second. */

import { PlayoutBuffer } from "./playout-buffer.js";

const TELL = 0.1; // [s]

class Playout extends AudioWorkletProcessor {
  constructor() {
    super();
    this.buffer = new PlayoutBuffer(sampleRate);
    this.heard = { samples: 0, energy: 0, peak: 0 };
    this.port.onmessage = ({ data }) => this.buffer.push(data);
  }

  process(inputs, [[output]]) {
    this.buffer.pull(output);
    const { heard } = this;
    for (const sample of output) {
      heard.energy += sample * sample;
      heard.peak = Math.max(heard.peak, Math.abs(sample));
    }
    heard.samples += output.length;
    if (heard.samples >= TELL * sampleRate) this.tell();
    return true;
  }

  tell() {
    const { samples, energy, peak } = this.heard;
    const { counts, waiting, target, playing } = this.buffer;
    const times = { waiting: waiting / sampleRate, target: target / sampleRate };
    this.port.postMessage({ ...counts, ...times, playing, rms: Math.sqrt(energy / samples), peak });
    this.heard = { samples: 0, energy: 0, peak: 0 };
  }
}

registerProcessor("playout", Playout);
