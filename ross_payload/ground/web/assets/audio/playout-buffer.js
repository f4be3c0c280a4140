/**
 * What has come of a stream and is not played yet: as little as the network allows, and played a little faster or slower
 * so that it stays so, since two computers never agree on the length of a second. Knows no clock and no browser.
 */

const FIRST_TARGET = 0.04; // [s] that wait before anything is played
const LEAST_TARGET = 0.03;
const MOST_TARGET = 0.3;
const AFTER_GAP = 0.02; // [s] by which more is kept once it was too little
const CALMED = 10; // [s] without need, after which less is kept
const LESS = 0.005; // [s]
const SPARE = 0.02; // [s] that were always left over: then it is more than is needed
const FARTHEST = 0.2; // [s] above the target, beyond which the rest is left out: the browser slept
const FASTEST = 0.01; // by which it is played faster or slower at most: a sixth of a semitone
const EAGERNESS = 0.1; // of that correction: 10 ms too much are 0.1 % faster, 0.1 s and more 1 %
const SMOOTHED = 1; // [s] over which the fill is averaged
const FADE = 0.004; // [s] at the ends of a gap
const TAPS = 4; // samples that one in between is made of

export class PlayoutBuffer {
  /** @param {number} rate of the samples [Hz] */
  constructor(rate) {
    this.rate = rate;
    this.samples = new Float32Array(2 * rate);
    this.first = 0; // index of the oldest sample, counted since the beginning; also between two samples
    this.end = 0; // behind the newest
    this.target = FIRST_TARGET * rate;
    this.playing = false;
    this.gain = 0; // rises after a gap
    this.fill = this.target; // averaged
    this.calm = { samples: 0, least: Infinity };
    this.counts = { received: 0, played: 0, gaps: 0, skipped: 0 };
  }

  /** Samples that wait. */
  get waiting() {
    return this.end - this.first;
  }

  /** Take samples. @param {Float32Array} samples */
  push(samples) {
    for (let index = 0; index < samples.length; index++)
      this.samples[(this.end + index) % this.samples.length] = samples[index];
    this.end += samples.length;
    this.counts.received += samples.length;
    if (this.waiting > this.target + FARTHEST * this.rate) this.skip();
  }

  /** Fill an output with what comes next; with zeros where there is nothing. @param {Float32Array} output */
  pull(output) {
    if (!this.playing && this.waiting >= this.target + TAPS) this.begin();
    const ratio = this.playing ? this.ratio(output.length) : 1;
    const most = this.playing ? Math.floor((this.waiting - TAPS) / ratio) : 0;
    const count = Math.max(0, Math.min(output.length, most));
    for (let index = 0; index < count; index++) output[index] = this.next(ratio);
    if (count === output.length) return;
    output.fill(0, count);
    if (this.playing) this.interrupt(output, count);
  }

  begin() {
    Object.assign(this, { playing: true, gain: 0, fill: this.waiting });
    this.calm = { samples: 0, least: Infinity };
  }

  /** Nothing is left: what was played last fades, and more is kept from now on. */
  interrupt(output, count) {
    const fade = Math.min(count, Math.round(FADE * this.rate));
    for (let index = 0; index < fade; index++) output[count - 1 - index] *= index / fade;
    this.playing = false;
    this.counts.gaps += 1;
    this.target = Math.min(this.target + AFTER_GAP * this.rate, MOST_TARGET * this.rate);
  }

  /** Leave out what is too old. */
  skip() {
    const left = Math.floor(this.waiting - this.target);
    this.first += left;
    this.counts.skipped += left;
    Object.assign(this, { gain: 0, fill: this.waiting });
  }

  /** How many samples are taken for one that is played. */
  ratio(length) {
    this.fill += Math.min(length / (SMOOTHED * this.rate), 1) * (this.waiting - this.fill);
    this.relax(length);
    const excess = (this.fill - this.target) / this.rate;
    return 1 + Math.max(-FASTEST, Math.min(FASTEST, EAGERNESS * excess));
  }

  /** Keep less once more than was needed has been there for long. */
  relax(length) {
    const { calm } = this;
    calm.samples += length;
    calm.least = Math.min(calm.least, this.waiting - length);
    if (calm.samples < CALMED * this.rate) return;
    if (calm.least > SPARE * this.rate) this.target = Math.max(this.target - LESS * this.rate, LEAST_TARGET * this.rate);
    this.calm = { samples: 0, least: Infinity };
  }

  /** The next sample: cubic interpolation after Catmull and Rom between those that came. */
  next(ratio) {
    const whole = Math.floor(this.first);
    const part = this.first - whole;
    const [a, b, c, d] = [0, 1, 2, 3].map((index) => this.samples[(whole + index) % this.samples.length]);
    this.first += ratio;
    this.counts.played += 1;
    this.gain = Math.min(1, this.gain + 1 / (FADE * this.rate));
    return this.gain * (b + 0.5 * part * (c - a + part * (2 * a - 5 * b + 4 * c - d + part * (3 * (b - c) + d - a))));
  }
}
