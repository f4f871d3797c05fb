/* All strip charts: which there are, what time they show, what the server remembers of them. */
import { Chart } from "./chart.js";
import { element } from "./format.js";

const WINDOWS = [
  { label: "30 s", seconds: 30, level: 0 },
  { label: "2 min", seconds: 120, level: 0 },
  { label: "15 min", seconds: 900, level: 1 },
  { label: "2 h", seconds: 7200, level: 2 },
];
const KEY = "ddh-twin-charts";

export class Charts {
  constructor(store, list, windows) {
    this.store = store;
    this.list = list;
    this.charts = [];
    this.begun = false;
    this.palette = {};
    this.quantities = new Map();
    this.kept = saved();
    this.window = WINDOWS[this.kept.window] ?? WINDOWS[0];
    this.buttons = WINDOWS.map((window, i) => element("button", { type: "button", onclick: () => this.setWindow(i) }, window.label));
    windows.append(...this.buttons);
    this.mark();
    store.on("ready", (page) => this.begin(page));
    store.on("rows", (row, stream, values) => this.take(row, stream, values));
  }

  begin(page) {
    this.quantities = new Map(page.quantities.map((q) => [q.id, q]));
    const wanted = (this.kept.charts ?? page.first_charts).filter((id) => this.quantities.has(id));
    for (const chart of [...this.charts]) chart.end();
    this.charts = [];
    this.begun = true;
    for (const id of wanted) this.add(id, false);
    this.fetch();
  }

  add(id, keep = true) {
    const charted = new Set(this.charts.map((chart) => chart.quantity.id));
    const chosen = id ?? [...this.quantities.keys()].find((name) => !charted.has(name));
    if (chosen === undefined) return; // nothing is left to draw, or the page has told of nothing yet
    const chart = new Chart(this, this.quantities.get(chosen));
    this.charts.push(chart);
    this.list.append(chart.figure);
    if (!keep) return;
    this.keep();
    this.fetch();
    chart.select.focus();
  }

  remove(chart) {
    chart.end();
    this.charts = this.charts.filter((other) => other !== chart);
    this.keep();
  }

  keep() {
    const charts = this.begun ? this.charts.map((chart) => chart.quantity.id) : this.kept.charts; // a window may be chosen before any chart is there
    this.kept = { charts, window: WINDOWS.indexOf(this.window) };
    try {
      localStorage.setItem(KEY, JSON.stringify(this.kept));
    } catch {
      /* private windows have no storage */
    }
  }

  setWindow(i) {
    if (!WINDOWS[i]) return;
    this.window = WINDOWS[i];
    this.mark();
    this.keep();
    for (const chart of this.charts) chart.lay();
    this.fetch();
  }

  mark() {
    this.buttons.forEach((button, i) => button.setAttribute("aria-pressed", String(WINDOWS[i] === this.window)));
  }

  take(row, stream, values) {
    for (const chart of this.charts) chart.take(row, stream, values);
  }

  /* What the server remembers of all columns that are charted. */
  async fetch() {
    const columns = [...new Set(this.charts.flatMap((chart) => [...chart.tracks.keys()]))];
    if (!columns.length) return;
    const { level, seconds } = this.window;
    const asked = this.window;
    for (let at = 0; at < columns.length; at += 40) {
      const some = columns.slice(at, at + 40);
      const answer = await fetch(`history?level=${level}&seconds=${seconds}&columns=${encodeURIComponent(some.join(","))}`).catch(
        () => null,
      );
      if (!answer || !answer.ok || this.window !== asked) return;
      const buffer = await answer.arrayBuffer();
      const first = Number(new DataView(buffer).getBigInt64(0, true));
      const values = new Float32Array(buffer, 8);
      const count = values.length / some.length;
      some.forEach((column, k) => {
        for (const chart of this.charts) chart.fill(column, first, values.subarray(k * count, (k + 1) * count));
      });
    }
    this.draw(true);
  }

  /* Draw what can be seen; slow windows less often. */
  draw(now = false) {
    const at = performance.now();
    const pause = this.window.level === 0 ? 180 : 900;
    if (!now && at - (this.drawnAt ?? 0) < pause) return;
    this.drawnAt = at;
    for (const chart of this.charts) if (chart.visible) chart.draw();
  }

  repaint() {
    this.palette = {};
    for (const chart of this.charts) chart.plot?.redraw(false);
  }

  colour(name) {
    return (this.palette[name] ??= getComputedStyle(document.documentElement).getPropertyValue(name).trim());
  }

  /* Since when a gap is open in a quantity, s, null where none is. */
  openSince(quantity) {
    const gap = this.store.documents.gap;
    const name = quantity.id.replace(/^gap\//, "");
    const row = gap?.signals.find(
      (r) => r.opened && (r.signal === name || quantity.lines.some((line) => `temperature/${line.column.split(".")[0]}` === r.signal)),
    );
    return row ? row.since : null;
  }
}

function saved() {
  try {
    return JSON.parse(localStorage.getItem(KEY)) ?? {};
  } catch {
    return {};
  }
}
