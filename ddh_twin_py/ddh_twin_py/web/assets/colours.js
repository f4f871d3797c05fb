/* Temperature to colour: ColorBrewer's RdYlBu, which colour-blind people can read; every colour stands beside its number. */
const STOPS = [
  [69, 117, 180],
  [145, 191, 219],
  [224, 243, 248],
  [254, 224, 144],
  [252, 141, 89],
  [215, 48, 39],
];
const LEAST = 15; // K that the scale spans at least
const STEP = 5; // K, to which its ends are rounded

export class Scale {
  constructor() {
    this.low = null;
    this.high = null;
  }

  /* Take in what there is to show; whether the ends have moved. */
  fit(values) {
    const there = values.filter(Number.isFinite);
    if (!there.length) return false;
    let low = STEP * Math.floor((Math.min(...there) - 0.5) / STEP);
    let high = STEP * Math.ceil((Math.max(...there) + 0.5) / STEP);
    if (high - low < LEAST) high = low + LEAST;
    const fits = this.low !== null && this.low <= low && this.high >= high;
    if (fits && low - this.low <= STEP && this.high - high <= STEP) return false; // no jumping to and fro
    [this.low, this.high] = [low, high];
    return true;
  }

  rgb(value) {
    const share = Math.min(1, Math.max(0, (value - this.low) / (this.high - this.low))) * (STOPS.length - 1);
    const k = Math.min(STOPS.length - 2, Math.floor(share));
    return STOPS[k].map((part, i) => Math.round(part + (STOPS[k + 1][i] - part) * (share - k)));
  }

  css(value) {
    return `rgb(${this.rgb(value).join(" ")})`;
  }

  /* Ink that can be read on that colour. */
  ink(value) {
    const [r, g, b] = this.rgb(value);
    return 0.299 * r + 0.587 * g + 0.114 * b > 140 ? "#1b1f24" : "#ffffff";
  }

  paint(canvas) {
    const context = canvas.getContext("2d");
    for (let x = 0; x < canvas.width; x++) {
      context.fillStyle = this.css(this.low + ((this.high - this.low) * x) / (canvas.width - 1));
      context.fillRect(x, 0, 1, canvas.height);
    }
  }
}
