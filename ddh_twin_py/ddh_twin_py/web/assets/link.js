/* The WebSocket: frames and documents in, acknowledgements and wishes out; comes back by itself. */
const SEEN = 5; // frames between two acknowledgements
const REFUSED = [401, 403, 503];
const PAUSES = [250, 500, 1000, 2000, 3000]; // ms before the next try

export class Link {
  constructor(store, changed) {
    this.store = store;
    this.changed = changed; // told "live", "lost" or "connecting"
    this.state = "connecting";
    this.tries = 0;
    this.unseen = 0;
    this.last = 0;
    this.wishes = new Map();
    this.number = 0;
    this.version = null;
    this.refusal = ""; // why the server lets nobody in
    this.missed = []; // called where frames were left out
    this.connect();
    addEventListener("online", () => this.again(0));
  }

  connect() {
    clearTimeout(this.timer);
    const before = this.socket;
    const address = new URL("ws", location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    if (before) before.close(); // it may be opening still
    this.last = 0;
    this.unseen = 0;
    socket.onmessage = (event) => {
      if (this.socket !== socket) return;
      if (typeof event.data === "string") this.document(JSON.parse(event.data));
      else this.frame(event.data);
    };
    socket.onclose = () => {
      if (this.socket !== socket) return;
      if (this.last === 0) this.ask();
      this.set("lost");
      for (const done of this.wishes.values()) done("the connection is lost");
      this.wishes.clear();
      this.again(PAUSES[Math.min(this.tries++, PAUSES.length - 1)]);
    };
  }

  /* A WebSocket does not say why it was refused; a request does. */
  async ask() {
    const answer = await fetch("ws").catch(() => null);
    this.refusal = answer && REFUSED.includes(answer.status) ? (await answer.text()).trim() : "";
    this.changed(this.state);
  }

  again(pause) {
    if (this.state === "live") return;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.connect(), pause);
  }

  set(state) {
    this.state = state;
    this.changed(state);
  }

  document(message) {
    if (message.doc === "version") {
      if (this.version !== null && this.version !== message.data) location.reload(); // another page is served now
      this.version = message.data;
    } else if (message.doc === "answer") {
      const done = this.wishes.get(message.data.id);
      this.wishes.delete(message.data.id);
      if (done) done(message.data.refused);
    } else {
      this.store.put(message.doc, message.data);
    }
  }

  frame(buffer) {
    const number = this.store.frame(buffer);
    if (this.state !== "live") {
      this.tries = 0;
      this.refusal = "";
      this.set("live");
    }
    if ((this.last !== 0 && number > this.last + 1) || this.last === 0) for (const listener of this.missed) listener();
    this.last = number;
    if (++this.unseen < SEEN) return;
    this.socket.send(JSON.stringify({ seen: this.unseen }));
    this.unseen = 0;
  }

  /* Ask for something; resolves to '' or why it was refused. */
  wish(name, value) {
    if (this.state !== "live") return Promise.resolve("not connected");
    const id = ++this.number;
    return new Promise((done) => {
      this.wishes.set(id, done);
      this.socket.send(JSON.stringify({ do: name, value: value, id: id }));
    });
  }
}
