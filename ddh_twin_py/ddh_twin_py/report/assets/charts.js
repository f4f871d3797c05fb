/* Draws every figure.chart of the page with uPlot. Zoom, pan and cursor are shared.
   Drag: zoom. Shift and drag: pan. Double click: all. Ctrl and wheel: zoom. Two fingers: zoom.
   Keys on a focused chart: left, right, plus, minus, 0. */
(function () {
  "use strict";
  const root = document.documentElement;
  const plots = [];
  let palette = {};
  let domain = null;
  let moving = false;

  function colour(name) {
    if (!(name in palette)) palette[name] = getComputedStyle(root).getPropertyValue(name).trim();
    return palette[name];
  }

  function bytes(text) {
    const raw = atob(text);
    const out = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
    return out.buffer;
  }

  function unpack(packed) {
    const [low, high, text] = packed;
    const place = new Uint16Array(bytes(text));
    const out = new Float64Array(place.length);
    const step = (high - low) / 65534;
    for (let i = 0; i < place.length; i++) out[i] = place[i] === 65535 ? NaN : place[i] === 65534 ? high : low + place[i] * step;
    return out;
  }

  function withGaps(values) {
    for (let i = 0; i < values.length; i++) {
      if (values[i] !== values[i]) return Array.from(values, (v) => (v !== v ? null : v));
    }
    return values;
  }

  function clock(seconds, digits) {
    if (domain[1] - domain[0] < 180 && Math.abs(seconds) < 180) return seconds.toFixed(digits) + " s";
    const sign = seconds < 0 ? "-" : "";
    const whole = Number(Math.abs(seconds).toFixed(digits)); // rounded before it is split, or 119.997 is 1:60.00
    const h = Math.floor(whole / 3600);
    const m = Math.floor((whole - 3600 * h) / 60);
    const s = (whole - 3600 * h - 60 * m).toFixed(digits).padStart(digits ? digits + 3 : 2, "0");
    return sign + (h ? h + ":" + String(m).padStart(2, "0") : m) + ":" + s;
  }

  const STEPS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 43200, 86400];

  function setRange(min, max) {
    const span = Math.min(max - min, domain[1] - domain[0]);
    if (!(span > 0.02)) return;
    min = Math.max(domain[0], Math.min(min, domain[1] - span));
    moving = true;
    for (const u of plots) u.setScale("x", { min: min, max: min + span });
    moving = false;
    const whole = span >= domain[1] - domain[0] - 1e-6;
    root.classList.toggle("zoomed", !whole);
  }

  function all() {
    setRange(domain[0], domain[1]);
  }

  function zoom(u, factor, at) {
    const scale = u.scales.x;
    if (at === undefined) at = 0.5 * (scale.min + scale.max);
    setRange(at - (at - scale.min) * factor, at + (scale.max - at) * factor);
  }

  function gestures(u) {
    const over = u.over;
    over.addEventListener("wheel", (e) => {
      if (!e.ctrlKey && !e.metaKey) return;
      e.preventDefault();
      zoom(u, e.deltaY < 0 ? 0.8 : 1.25, u.posToVal(e.clientX - over.getBoundingClientRect().left, "x"));
    }, { passive: false });

    const fingers = new Map();
    let from = null;
    over.addEventListener("pointerdown", (e) => {
      const pan = e.pointerType === "touch" || e.shiftKey;
      if (!pan) return;
      fingers.set(e.pointerId, e.clientX);
      over.setPointerCapture(e.pointerId);
      from = { xs: [...fingers.values()], min: u.scales.x.min, max: u.scales.x.max };
    });
    over.addEventListener("pointermove", (e) => {
      if (!fingers.has(e.pointerId)) return;
      fingers.set(e.pointerId, e.clientX);
      const rect = over.getBoundingClientRect();
      const span = from.max - from.min;
      const value = (x) => from.min + ((x - rect.left) / rect.width) * span;
      const xs = [...fingers.values()];
      if (xs.length === 1) {
        if (span >= domain[1] - domain[0]) return;
        const shift = value(from.xs[0]) - value(xs[0]);
        setRange(from.min + shift, from.max + shift);
      } else {
        const before = Math.max(20, Math.abs(from.xs[1] - from.xs[0]));
        const factor = before / Math.max(20, Math.abs(xs[1] - xs[0]));
        const middle = value(0.5 * (from.xs[0] + from.xs[1]));
        setRange(middle - (middle - from.min) * factor, middle + (from.max - middle) * factor);
      }
    });
    const gone = (e) => {
      fingers.delete(e.pointerId);
      if (fingers.size) from = { xs: [...fingers.values()], min: u.scales.x.min, max: u.scales.x.max };
    };
    over.addEventListener("pointerup", gone);
    over.addEventListener("pointercancel", gone);
    over.addEventListener("dblclick", all);
  }

  function keys(box, u) {
    box.addEventListener("keydown", (e) => {
      if (e.target !== box || e.ctrlKey || e.metaKey || e.altKey) return;
      const scale = u.scales.x;
      const shift = 0.2 * (scale.max - scale.min);
      if (e.key === "ArrowLeft") setRange(scale.min - shift, scale.max - shift);
      else if (e.key === "ArrowRight") setRange(scale.min + shift, scale.max + shift);
      else if (e.key === "+" || e.key === "=") zoom(u, 0.5);
      else if (e.key === "-") zoom(u, 2);
      else if (e.key === "0" || e.key === "Escape") all();
      else return;
      e.preventDefault();
    });
  }

  function draw(figure) {
    const holder = figure.querySelector('script[type="application/json"]');
    const spec = JSON.parse(holder.textContent);
    holder.remove();
    domain = domain ? [Math.min(domain[0], spec.domain[0]), Math.max(domain[1], spec.domain[1])] : spec.domain.slice();
    const box = figure.querySelector(".plot");
    const x = new Float32Array(bytes(spec.x));
    const columns = spec.y.map(unpack);
    const below = spec.differences ? { titled: true, height: spec.below, digits: spec.digits, floor: spec.floor, unsettled: spec.unsettled, lines: [] } : null;
    spec.floor = 0;
    const main = plot(box, spec, [x].concat(columns.map(withGaps)), Boolean(below));
    const all = [main];
    if (below) {
      const at = [];
      let column = 0;
      for (const line of spec.lines) { at.push(column); column += line.band ? 3 : 1; }
      const rows = spec.differences.map(([a, b]) => {
        const line = spec.lines[spec.lines[a].role === "measured" ? b : a];
        below.lines.push({ label: plain(spec.lines[a].label) + " \u2212 " + plain(spec.lines[b].label), role: line.role, thin: true });
        const difference = new Float64Array(x.length);
        for (let i = 0; i < x.length; i++) difference[i] = columns[at[a]][i] - columns[at[b]][i];
        return withGaps(difference);
      });
      all.push(plot(box, below, [x].concat(rows), false));
    }
    keys(box, main);
    new ResizeObserver(() => {
      if (root.classList.contains("print")) return;
      const width = box.clientWidth;
      for (const u of all) if (width && Math.abs(width - u.width) > 1) u.setSize({ width: width, height: u.height });
    }).observe(box);
  }

  // a legend without a value names its lines alone
  function untold(u) { u.root.classList.toggle("untold", u.cursor.idx == null); }

  function plain(label) { return label.split(" \u00b1")[0]; }

  function aroundZero(u, axis, min, max) {
    const most = Math.max(-min, max);
    const ten = Math.pow(10, Math.floor(Math.log10(most)));
    const step = ten * (most >= 5.5 * ten ? 5 : most >= 2.2 * ten ? 2 : 1);
    return [-step, 0, step].filter((v) => v >= min && v <= max);
  }

  function plot(box, spec, data, bare) {
    const format = (v) => (v == null ? "\u2013" : v.toFixed(spec.digits));
    const series = [{ label: domain[1] - domain[0] < 180 ? "time" : domain[1] < 3600 ? "time, min:s" : "time, h:min:s", value: (u, v) => (v == null ? "\u2013" : clock(v, 2)) }];
    const bands = [];
    const edges = {};
    // what is still being found does not stretch the axis: there what counts is a copy of it without its beginning
    const settled = spec.unsettled ? Array.from(data[0], (t) => !spec.unsettled.some(([from, to]) => t > from - 1e-3 && t < to)) : []; // times are float32
    const waits = settled.some(Boolean);
    const copied = [];
    for (const line of spec.lines) {
      const own = series.length;
      const late = waits && line.role !== "measured";
      if (late) { copied.push([own, own]); edges[own] = []; }
      const paint = () => colour("--s-" + line.role);
      const measured = line.role === "measured";
      series.push({
        label: line.label,
        stroke: measured ? () => colour("--s-measured-line") : paint,
        width: line.dots ? 0 : measured ? 3 : line.thin ? 1 : 1.5,
        dash: line.dash ? [6, 3] : undefined,
        show: !line.hidden,
        auto: !late,
        paths: line.dots ? () => null : undefined,
        points: line.dots ? { show: true, size: 3.5, width: 0, fill: () => colour(line.role === "measured" ? "--s-measured-line" : "--s-" + line.role), stroke: () => "transparent" } : { show: false },
        value: line.band
          ? (u, v, i, at) => (v == null || at == null ? "\u2013" : format(v) + (line.ends
            ? " (" + format(data[own + 2][at]) + " to " + format(data[own + 1][at]) + ")"
            : " \u00b1 " + (data[own + 1][at] - v).toFixed(spec.digits)))
          : (u, v) => format(v),
      });
      if (!line.band) continue;
      edges[own] = [own + 1, own + 2];
      for (let k = 0; k < 2; k++) {
        if (late) copied.push([own, series.length]);
        series.push({ label: "", class: "edge", stroke: "transparent", width: 0, show: !line.hidden, points: { show: false }, auto: !late });
      }
      bands.push({ series: [own + 1, own + 2], fill: () => colour("--s-" + line.role + "-band") });
    }
    for (const [own, original] of copied) {
      edges[own].push(series.length);
      series.push({ label: "", class: "edge", stroke: "transparent", width: 0, show: series[original].show, points: { show: false } });
      data = data.concat([Array.from(data[original], (v, i) => (settled[i] ? v : null))]);
    }
    const ink = () => colour("--ink-2");
    const grid = { stroke: () => colour("--grid"), width: 1 };
    const ticks = { stroke: () => colour("--grid"), width: 1, size: 4 };
    const font = "11px " + getComputedStyle(document.body).fontFamily;
    const shadeFloor = (u) => {
      if (!spec.floor) return;
      const top = u.valToPos(Math.min(spec.floor, u.scales.y.max), "y", true);
      const bottom = u.valToPos(Math.max(-spec.floor, u.scales.y.min), "y", true);
      u.ctx.save();
      u.ctx.fillStyle = colour("--s-measured-band");
      u.ctx.fillRect(u.bbox.left, top, u.bbox.width, bottom - top);
      u.ctx.restore();
    };
    const u = new uPlot({
      width: Math.max(200, box.clientWidth),
      height: spec.height,
      series: series,
      bands: bands,
      scales: {
        x: { time: false },
        y: {
          range: (u, min, max) => {
            if (min == null) return [0, 1];
            if (spec.zero) { min = Math.min(0, min); max = Math.max(0, max); }
            if (spec.floor) { min = Math.min(-spec.floor, min); max = Math.max(spec.floor, max); }
            const room = Math.max(0.06 * (max - min), 2 * Math.pow(10, -spec.digits));
            return [spec.zero && min === 0 ? 0 : min - room, spec.zero && max === 0 ? 0 : max + room];
          },
        },
      },
      axes: [
        {
          stroke: ink, grid: grid, ticks: ticks, font: font, size: bare ? 6 : 28, space: 64, incrs: STEPS,
          values: (u, at, k, space, step) => at.map((v) => (bare ? "" : clock(v, step < 0.1 ? 2 : step < 1 ? 1 : 0))),
        },
        { stroke: ink, grid: grid, ticks: ticks, font: font, size: 52, splits: spec.titled ? aroundZero : undefined,
          space: (u, axis, min, max, pixels) => Math.min(32, pixels / 4) }, // a step is less than twice that, so that two fit at least
      ],
      cursor: {
        y: false, sync: { key: "time" }, drag: { x: true, y: false, setScale: false }, points: { size: 6 },
        bind: { dblclick: () => null, mousedown: (u, el, handler) => (e) => (e.shiftKey ? null : handler(e)) },
      },
      legend: {
        markers: {
          width: 0,
          fill: (u, i) => {
            const line = spec.lines.find((l) => l.label === u.series[i].label);
            if (!line) return "transparent";
            const paint = "var(--s-" + line.role + (line.role === "measured" ? "-line)" : ")");
            return line.dash ? "repeating-linear-gradient(90deg," + paint + " 0 5px,transparent 5px 8px)" : paint;
          },
        },
      },
      hooks: {
        drawClear: [shadeFloor],
        setCursor: [untold],
        setSelect: [(u) => {
          if (u.select.width > 4) setRange(u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x"));
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        }],
        setSeries: [(u, i, options) => {
          if (i == null || !(i in edges) || options.show == null) return;
          for (const edge of edges[i]) u.setSeries(edge, { show: options.show });
        }],
      },
    }, data, box);
    plots.push(u);
    u.root.querySelectorAll(".u-series").forEach((row, i) => {
      const head = row.querySelector("th");
      if (i === 0 || !head || row.classList.contains("edge")) return;
      head.tabIndex = 0;
      head.setAttribute("role", "button");
      head.title = "show or hide";
      const line = spec.lines.find((l) => l.label === u.series[i].label);
      if (line && line.dots) row.classList.add("dots");
      if (line && line.role === "measured") row.classList.add("thick");
      head.addEventListener("keydown", (e) => {
        if (e.key === "Enter" || e.key === " ") { e.preventDefault(); head.click(); }
      });
    });
    if (spec.titled) u.root.classList.add("below");
    untold(u);
    gestures(u);
    return u;
  }

  function repaint() {
    palette = {};
    for (const u of plots) u.redraw(false);
  }

  function theme(name) {
    root.dataset.theme = name;
    repaint();
  }

  document.querySelectorAll("figure.chart").forEach(draw);
  if (plots.length) all();

  // a table or a map of which more lies to the right fades there
  for (const box of document.querySelectorAll(".scroll")) {
    const tell = () => box.classList.toggle("more", box.scrollLeft + box.clientWidth < box.scrollWidth - 1);
    box.addEventListener("scroll", tell, { passive: true });
    new ResizeObserver(tell).observe(box);
  }

  const toggle = document.getElementById("theme");
  if (toggle) toggle.addEventListener("click", () => theme(root.dataset.theme === "dark" ? "light" : "dark"));
  const reset = document.getElementById("all");
  if (reset) reset.addEventListener("click", all);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (e) => theme(e.matches ? "dark" : "light"));

  let before = null;
  const folded = [];
  addEventListener("beforeprint", () => {
    before = root.dataset.theme;
    root.classList.add("print");
    theme("light");
    for (const fold of document.querySelectorAll("details:not([open])")) { fold.open = true; folded.push(fold); }
    for (const u of plots) u.setSize({ width: u.root.closest(".wide") ? 760 : 370, height: u.height });
  });
  addEventListener("afterprint", () => {
    root.classList.remove("print");
    while (folded.length) folded.pop().open = false;
    for (const u of plots) u.setSize({ width: u.root.parentElement.clientWidth, height: u.height });
    if (before) theme(before);
  });
  root.dataset.drawn = String(plots.length);
})();
