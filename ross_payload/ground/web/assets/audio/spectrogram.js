/** The spectrum of what is heard, over the last seconds: the newest on the right. */

const STEP = 40; // [ms] between two columns
const SHADES = 256;

/** Draw into a canvas what an analyser hears, for as long as the canvas is on the page. */
export class Spectrogram {
  constructor() {
    this.canvas = null;
    this.due = 0;
  }

  /** Follow an analyser. @param {?HTMLCanvasElement} canvas @param {?AnalyserNode} spectrum null: nothing is heard */
  follow(canvas, spectrum) {
    this.spectrum = spectrum;
    if (canvas !== this.canvas) {
      this.canvas = canvas;
      this.brush = canvas?.getContext("2d", { willReadFrequently: false });
      this.look = "";
    }
    if (canvas && spectrum && !this.going) this.go();
  }

  go() {
    this.going = requestAnimationFrame((now) => {
      this.going = 0;
      if (!this.spectrum || !this.canvas?.isConnected) return;
      if (now >= this.due) {
        this.due = Math.max(this.due + STEP, now);
        this.draw();
      }
      this.go();
    });
  }

  draw() {
    const { canvas, brush, spectrum } = this;
    this.mix();
    const { width, height } = canvas;
    const levels = new Uint8Array(spectrum.frequencyBinCount);
    spectrum.getByteFrequencyData(levels);
    brush.drawImage(canvas, -1, 0);
    const column = brush.createImageData(1, height);
    for (let row = 0; row < height; row++) {
      const shade = levels[Math.floor(((height - 1 - row) * levels.length) / height)];
      column.data.set(this.shades.subarray(4 * shade, 4 * shade + 4), 4 * row);
    }
    brush.putImageData(column, width - 1, 0);
  }

  /** The shades from the background of the canvas to its colour, in the look of the page. */
  mix() {
    const { color, backgroundColor } = getComputedStyle(this.canvas);
    if (this.look === color + backgroundColor) return;
    this.look = color + backgroundColor;
    const [from, to] = [backgroundColor, color].map((each) => each.match(/[\d.]+/g).map(Number));
    this.shades = new Uint8ClampedArray(4 * SHADES);
    for (let shade = 0; shade < SHADES; shade++) {
      const part = shade / (SHADES - 1);
      for (let index = 0; index < 3; index++) this.shades[4 * shade + index] = from[index] + part * (to[index] - from[index]);
      this.shades[4 * shade + 3] = 255;
    }
    this.brush.fillStyle = backgroundColor;
    this.brush.fillRect(0, 0, this.canvas.width, this.canvas.height);
  }
}
