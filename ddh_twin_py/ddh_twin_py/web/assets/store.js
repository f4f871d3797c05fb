/* What has come: the newest value of every column, documents by name, and who wants to know. */
const AHEAD = 40; // rows that a stream may be ahead of the clock
const JUMP = 2400; // rows on, from which the charts are fetched anew

export class Store {
  constructor() {
    this.page = null;
    this.documents = {};
    this.latest = new Float32Array(0);
    this.place = new Map(); // column to its place in latest
    this.streams = [];
    this.row = 0; // the page's clock, in steps of the grid
    this.cameAt = 0; // ms, when the clock last moved
    this.listeners = { document: [], rows: [], jump: [], ready: [] };
  }

  on(what, listener) {
    this.listeners[what].push(listener);
  }

  tell(what, ...given) {
    for (const listener of this.listeners[what]) listener(...given);
  }

  put(name, data) {
    this.documents[name] = data;
    if (name === "page") this.lay(data);
    this.tell("document", name, data);
  }

  lay(page) {
    this.page = page;
    let at = 0;
    this.place.clear();
    this.streams = page.streams.map((stream) => {
      const first = at;
      for (const field of stream.fields) this.place.set(`${stream.name}.${field}`, at++);
      return { name: stream.name, first: first, width: stream.fields.length, newest: 0 };
    });
    this.latest = new Float32Array(at).fill(NaN);
    this.tell("ready", page);
  }

  value(column) {
    const place = this.place.get(column);
    return place === undefined ? NaN : this.latest[place];
  }

  get seconds() {
    return this.page ? this.row * this.page.grid : 0;
  }

  /* One frame: see web/frames.py. Returns its number. */
  frame(buffer) {
    const size = new DataView(buffer).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
    if (!this.page) return header.n;
    const jumped = header.t < this.row - AHEAD || header.t > this.row + JUMP;
    if (header.t !== this.row) this.cameAt = performance.now();
    this.row = header.t;
    if (jumped) this.tell("jump");
    let at = 4 + size;
    for (const [number, before] of header.b) {
      const stream = this.streams[number];
      if (stream.newest > header.t + AHEAD) stream.newest = 0; // of the time before a jump
      for (const behind of before) {
        const values = new Float32Array(buffer, at, stream.width);
        const row = header.t - behind;
        at += 4 * stream.width;
        this.tell("rows", row, stream, values);
        if (row < stream.newest) continue; // came late
        stream.newest = row;
        this.latest.set(values, stream.first);
      }
    }
    return header.n;
  }
}
