/* The last minutes or hours of one column, on a grid of data time: a ring of numbers, NaN where nothing came. */
export class Track {
  /* rows in a bin (1: rows as they came, else lowest and highest of each bin), values that are kept */
  constructor(rows, kept) {
    this.rows = rows;
    this.halves = rows === 1 ? 1 : 2;
    this.kept = kept;
    this.ring = new Float32Array(kept).fill(NaN);
    this.end = null; // number of the value behind the newest
  }

  reach(place) {
    if (this.end === null || place - this.end >= this.kept) this.ring.fill(NaN);
    else for (let k = this.end; k <= place; k++) this.ring[k % this.kept] = NaN;
    this.end = place + 1;
  }

  set(place, value) {
    if (this.end === null || place >= this.end) this.reach(place);
    if (place >= this.end - this.kept) this.ring[place % this.kept] = value;
  }

  /* A value of a row as it comes in. */
  put(row, value) {
    if (this.halves === 1) return this.set(row, value);
    const low = 2 * Math.floor(row / this.rows);
    if (this.end === null || low + 1 >= this.end) this.reach(low + 1);
    if (value !== value || low < this.end - this.kept) return;
    const a = low % this.kept;
    const b = (low + 1) % this.kept;
    if (!(this.ring[a] <= value)) this.ring[a] = value;
    if (!(this.ring[b] >= value)) this.ring[b] = value;
  }

  get(place) {
    return this.end === null || place >= this.end || place < this.end - this.kept ? NaN : this.ring[place % this.kept];
  }
}
