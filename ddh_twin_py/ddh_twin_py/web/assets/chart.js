/* One strip chart: a quantity, measured against the twin, with its band. uPlot draws. */
import { DASH, element, number, timeOfDay } from "./format.js";
import { Track } from "./tracks.js";

const HEIGHT = 170;
const GAP = 2.5; // s of data without a value, or three values, that break a line
const WIDE = 3; // times its narrowest in the window, beyond which a band does not stretch the axis: what was not yet known hides nothing

export class Chart {
  constructor(charts, quantity) {
    this.charts = charts;
    this.visible = true;
    this.reach = [Infinity, -Infinity]; // of the bands, on the axis
    const remove = element(
      "button",
      { type: "button", class: "remove", "aria-label": "remove this chart", title: "remove", onclick: () => charts.remove(this) },
      "✕",
    );
    this.select = element(
      "select",
      {
        "aria-label": "quantity of this chart",
        onchange: () => {
          this.setQuantity(charts.quantities.get(this.select.value));
          charts.keep();
          charts.fetch();
        },
      },
      ...groups(charts.quantities),
    );
    this.box = element("div", { class: "plot" });
    this.legend = element("ul", { class: "legend" });
    this.figure = element("figure", { class: "chart" }, element("figcaption", {}, this.select, remove), this.box, this.legend);
    this.watch = new IntersectionObserver((entries) => {
      this.visible = entries.at(-1).isIntersecting; // a busy browser tells several changes at once, the newest last
    });
    this.watch.observe(this.figure);
    this.resize = new ResizeObserver(() => {
      if (this.plot && Math.abs(this.box.clientWidth - this.plot.width) > 1)
        this.plot.setSize({ width: this.box.clientWidth, height: HEIGHT });
    });
    this.resize.observe(this.box);
    this.setQuantity(quantity);
  }

  end() {
    this.watch.disconnect();
    this.resize.disconnect();
    this.plot?.destroy();
    this.figure.remove();
  }

  setQuantity(quantity) {
    this.quantity = quantity;
    this.select.value = quantity.id;
    this.legend.replaceChildren(
      ...quantity.lines.map((line) =>
        element(
          "li",
          { class: `${line.role}${line.dots ? " dots" : ""}` },
          element("i"),
          `${line.label}${line.band ? ` ± ${line.spread}` : ""} `,
          element("b", {}, DASH),
        ),
      ),
    );
    this.lay();
  }

  /* Tracks for the window in force, and an empty plot. */
  lay() {
    const level = this.charts.window.level;
    const { step, seconds } = this.charts.store.page.levels[level];
    const grid = this.charts.store.page.grid;
    const rows = level === 0 ? 1 : Math.round((2 * step) / grid);
    const columns = this.quantity.lines.flatMap((line) => (line.band ? [line.column, line.band] : [line.column]));
    this.tracks = new Map(columns.map((column) => [column, new Track(rows, Math.round(seconds / step))]));
    this.step = step;
    this.make();
  }

  take(row, stream, values) {
    for (const [column, track] of this.tracks) {
      const place = this.charts.store.place.get(column) - stream.first;
      if (place >= 0 && place < stream.width) track.put(row, values[place]);
    }
  }

  fill(column, first, values) {
    const track = this.tracks.get(column);
    if (!track) return;
    const newest = track.end;
    for (let k = 0; k < values.length; k++)
      if (values[k] === values[k] || newest === null || first + k < newest) track.set(first + k, values[k]);
  }

  make() {
    this.plot?.destroy();
    const series = [{}];
    const bands = [];
    for (const line of this.quantity.lines) {
      const paint = () => this.charts.colour(`--r-${line.role}`);
      series.push({
        stroke: paint,
        width: line.dots ? 0 : line.role === "measured" ? 2.6 : 1.6,
        paths: line.dots ? () => null : undefined,
        dash: line.role === "twin" ? [7, 4] : line.role === "soft" ? [2, 3] : undefined,
        points: line.dots ? { show: true, size: 4.5, width: 0, fill: paint } : { show: false },
      });
      if (!line.band) continue;
      for (let k = 0; k < 2; k++) series.push({ stroke: "transparent", width: 0, points: { show: false }, auto: false });
      bands.push({ series: [series.length - 2, series.length - 1], fill: () => this.charts.colour(`--r-${line.role}-band`) });
    }
    const ink = () => this.charts.colour("--ink-2");
    const grid = { stroke: () => this.charts.colour("--grid"), width: 1 };
    const font = "11px system-ui, sans-serif";
    this.plot = new uPlot(
      {
        width: Math.max(200, this.box.clientWidth),
        height: HEIGHT,
        series,
        bands,
        legend: { show: false },
        padding: [8, 26, 0, 0], // half a time's label
        scales: { x: { time: false }, y: { range: (u, min, max) => this.range(min, max) } },
        axes: [
          {
            stroke: ink,
            grid,
            ticks: { ...grid, size: 4 },
            font,
            size: 24,
            space: 80,
            incrs: [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600],
            values: (u, at) => at.map(timeOfDay),
          },
          {
            stroke: ink,
            grid,
            ticks: { ...grid, size: 4 },
            font,
            size: 54,
            values: (u, at) => at.map((v) => (v == null ? "" : v.toLocaleString("en", { maximumFractionDigits: 6 }).replace("-", "−"))),
            space: 30,
            label: this.quantity.unit,
            labelSize: 15,
            labelGap: 0,
            labelFont: font,
          },
        ],
        cursor: { drag: { x: false, y: false }, points: { size: 6 }, sync: { key: "strip" }, y: false },
        hooks: { drawClear: [(u) => this.shade(u)], setCursor: [() => this.tell()] },
      },
      [[], ...series.slice(1).map(() => [])],
      this.box,
    );
  }

  range(min, max) {
    const q = this.quantity;
    if (min == null) return [0, 1];
    [min, max] = [Math.min(min, this.reach[0]), Math.max(max, this.reach[1])];
    if (q.zero) [min, max] = [Math.min(0, min), Math.max(0, max)];
    if (q.floor) [min, max] = [Math.min(-1.5 * q.floor, min), Math.max(1.5 * q.floor, max)];
    const room = Math.max(0.06 * (max - min), 4 * 10 ** -q.digits);
    return [min - room, max + room];
  }

  /* Behind the lines: the noise floor, and since when a gap is open. */
  shade(u) {
    const context = u.ctx;
    context.save();
    if (this.quantity.floor) {
      const [top, bottom] = [this.quantity.floor, -this.quantity.floor].map((v) => u.valToPos(v, "y", true));
      context.fillStyle = this.charts.colour("--r-measured-band");
      context.fillRect(u.bbox.left, top, u.bbox.width, bottom - top);
    }
    const since = this.charts.openSince(this.quantity);
    this.figure.classList.toggle("open", since !== null);
    if (since !== null && since < u.scales.x.max) {
      const left = Math.max(u.bbox.left, u.valToPos(since, "x", true));
      context.fillStyle = this.charts.colour("--gap");
      context.fillRect(left, u.bbox.top, u.bbox.left + u.bbox.width - left, u.bbox.height);
    }
    context.restore();
  }

  draw() {
    const store = this.charts.store;
    const { seconds, level } = this.charts.window;
    const halves = level === 0 ? 1 : 2;
    const last = level === 0 ? store.row : halves * Math.floor(store.row / Math.round((2 * this.step) / store.page.grid)) + 1;
    const count = Math.round(seconds / this.step);
    const first = last - count + 1;
    const x = new Array(count);
    for (let k = 0; k < count; k++) x[k] = (first + k) * this.step;
    const data = [x];
    const most = Math.max(3, Math.round(GAP / this.step));
    this.reach = [Infinity, -Infinity];
    const { factor } = this.quantity;
    for (const line of this.quantity.lines) {
      const middle = this.column(line.column, first, count, factor, line.dots ? Infinity : most);
      data.push(middle);
      if (!line.band) continue;
      const deviation = this.column(line.band, first, count, factor * store.page.band, most);
      let last = null;
      const widths = deviation.map((width) => (last = width ?? last));
      const edge = (sign) => middle.map((v, k) => (v == null ? v : widths[k] === null ? undefined : (line.around ?? v) + sign * widths[k]));
      const edges = [edge(1), edge(-1)];
      data.push(...edges);
      this.stretch(edges, widths);
    }
    this.plot.setData(data, false);
    this.plot.batch(() => {
      this.plot.setScale("x", { min: x[0], max: x[count - 1] });
    });
    this.tell();
  }

  /* Bring what of a band is not wide into the axis. */
  stretch([upper, lower], widths) {
    const narrowest = upper.reduce((least, v, k) => (v == null ? least : Math.min(least, widths[k])), Infinity);
    upper.forEach((v, k) => {
      if (v == null || widths[k] > WIDE * narrowest) return;
      this.reach = [Math.min(this.reach[0], lower[k]), Math.max(this.reach[1], v)];
    });
  }

  /* Values of a column; undefined where a line goes on over it, null where it breaks. */
  column(name, first, count, factor, most) {
    const track = this.tracks.get(name);
    const values = new Array(count);
    let missing = 0;
    for (let k = 0; k < count; k++) {
      const value = track.get(first + k);
      if (value === value) {
        values[k] = value * factor;
        missing = 0;
      } else {
        values[k] = ++missing >= most ? null : undefined;
      }
    }
    return values;
  }

  /* Values under the pointer, else the newest. */
  tell() {
    if (!this.plot) return;
    const at = this.plot.cursor.idx;
    const pointed = at != null && this.plot.cursor.left >= 0;
    let next = 1;
    const columns = this.quantity.lines.map((line) => {
      const values = this.plot.data[next];
      next += line.band ? 3 : 1;
      return values;
    });
    const told = pointed ? columns.map((values) => values[at]) : ofOneInstant(columns, GAP / this.step);
    this.quantity.lines.forEach((line, k) => {
      const value = told[k];
      const text = value == null ? DASH : `${number(value, this.quantity.digits)} ${this.quantity.unit}`;
      const place = this.legend.children[k].lastChild;
      if (place.textContent !== text) place.textContent = text;
    });
  }
}

/* The newest value of every column that all have reached, but for those that stopped `most` rows ago: numbers of two instants are no gap. */
export function ofOneInstant(columns, most) {
  const newest = columns.map((values) => values.findLastIndex((value) => value != null));
  const last = Math.max(...newest);
  const common = Math.min(...newest.filter((k) => k >= 0 && last - k <= most));
  return columns.map((values, k) => {
    let back = Math.min(newest[k], common);
    while (back >= 0 && values[back] == null) back--;
    return values[back >= 0 ? back : newest[k]];
  });
}

function groups(quantities) {
  const by = new Map();
  for (const q of quantities.values()) by.set(q.group, [...(by.get(q.group) ?? []), q]);
  return [...by].map(([label, some]) => element("optgroup", { label }, ...some.map((q) => element("option", { value: q.id }, q.label))));
}
