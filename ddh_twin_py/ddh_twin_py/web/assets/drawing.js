/* The circuit: colours, numbers, the piston, arrows, and how each sensor is. */
import { Arrows } from "./arrows.js";
import { Scale } from "./colours.js";
import { element, number, watts, words } from "./format.js";

const NS = "http://www.w3.org/2000/svg";
const STROKE = 160; // of the drawing's units
const BORE = [410, 672];
const PISTON = [446, 462];
const SENSOR_OF = {
  end_winding: "motor_winding",
  housing: "motor_housing",
  pump_1_case: "pump_1_case",
  pump_2_case: "pump_2_case",
  tank_oil: "tank_oil",
  tank_wall: "tank_wall",
  cylinder_barrel: "cylinder_barrel",
  line_a_wall: "line_a",
  line_b_wall: "line_b",
};
const SHORT_DIGITS = 0;

export class Drawing {
  constructor(store, box) {
    this.store = store;
    this.box = box;
    this.svg = null;
    this.scale = new Scale();
    this.still = matchMedia("(prefers-reduced-motion: reduce)");
    this.then = 0;
  }

  async load() {
    this.box.innerHTML = await (await fetch("circuit.svg")).text();
    this.svg = this.box.querySelector("svg");
    const all = (selector) => [...this.svg.querySelectorAll(selector)];
    this.nodes = all("[data-node]");
    this.shown = all("[data-show]");
    this.on = all("[data-on]");
    this.arrows = all("[data-arrows]").map((group) => new Arrows(group));
    this.sensors = all("[data-sensor]");
    for (const badge of this.sensors) dress(badge);
    for (const channel of all(".channel")) channel.parentNode.insertBefore(trace(channel), channel.parentNode.firstChild);
    this.moving = this.svg.querySelector('[data-moving="piston"]');
    this.pointer = this.svg.querySelector('[data-moving="pointer"]');
    this.chambers = { a: this.svg.querySelector('[data-chamber="a"]'), b: this.svg.querySelector('[data-chamber="b"]') };
  }

  /* Fused, else free run, else what the sensor there reads. */
  temperature(node) {
    const store = this.store;
    const fused = store.value(`estimate.${node}.temperature`);
    if (Number.isFinite(fused)) return fused;
    const free = store.value(`prediction.temperature.${node}`);
    if (Number.isFinite(free)) return free;
    return node in SENSOR_OF ? store.value(`${SENSOR_OF[node]}.reading`) : NaN;
  }

  /* Colours and numbers; a few times a second. */
  paint() {
    if (!this.svg || !this.store.page) return;
    const known = new Map();
    for (const part of this.nodes) if (!known.has(part.dataset.node)) known.set(part.dataset.node, this.temperature(part.dataset.node));
    if (this.scale.fit([...known.values()])) this.legend();
    for (const part of this.nodes) {
      const value = known.get(part.dataset.node);
      const there = Number.isFinite(value) && this.scale.low !== null;
      const colour = there ? this.scale.css(value) : "";
      if (
        part.tagName === "path" &&
        (part.classList.contains("pipe-oil") || part.classList.contains("pipe-wall") || part.classList.contains("port"))
      )
        part.style.stroke = colour;
      else part.style.fill = colour;
      part.classList.toggle("unknown", !there);
    }
    for (const label of this.on)
      if (Number.isFinite(known.get(label.dataset.on)))
        for (const text of [label, ...label.children]) text.style.fill = this.scale.ink(known.get(label.dataset.on));
    for (const label of this.shown) {
      const text = this.text(label.dataset);
      if (label.textContent !== text) label.textContent = text;
    }
    for (const arrows of this.arrows) arrows.set(this.store.value(arrows.column));
    this.svg.setAttribute("aria-description", this.sentence(known));
  }

  legend() {
    document.getElementById("coolest").textContent = `${this.scale.low} °C`;
    document.getElementById("warmest").textContent = `${this.scale.high} °C`;
    this.scale.paint(document.getElementById("colours"));
  }

  text(what) {
    const store = this.store;
    const name = what.show;
    if (name === "payload") return store.documents.rig?.payload_mass ? `${number(store.documents.rig.payload_mass, 1)} kg` : "";
    if (name === "stroke") return `${number(store.page.rig.stroke * 1000, 0)} mm`;
    if (name.startsWith("pressure_")) {
      const bar = measured(store, `hydraulics.${name}`, `state.${name}`) * 1e-5;
      return quantity(bar, what.short && Math.abs(bar) >= 10 ? 0 : 1, "bar"); // below 0 the tenths tell how near a vacuum is
    }
    if (name === "rod_velocity") return quantity(measured(store, "hydraulics.rod_velocity", "state.rod_velocity") * 1000, 0, "mm/s");
    if (name.endsWith("_flow")) {
      const value = store.value(name) * 6e4;
      return what.only && !(value > 0.005) ? "" : quantity(value, 1, "L/min");
    }
    if (name.startsWith("state.")) {
      const value = store.value(name);
      if (!Number.isFinite(value)) return "";
      return what.heat ? `heat ${watts(value)}` : watts(value, what.short ? 1 : 2);
    }
    const value = name === "ambient" ? measured(store, "estimate.ambient", "ambient.reading") : this.temperature(name);
    if (!Number.isFinite(value)) return "";
    if (what.short) return `${number(value, SHORT_DIGITS)}°`;
    const deviation = store.value(`estimate.${name}.standard_deviation`);
    if (name === "ambient" && !Number.isFinite(store.value("ambient.reading"))) return `${number(value, 1)} °C, assumed`;
    const spread = what.spread && Number.isFinite(deviation) ? ` ± ${number(store.page.band * deviation, 1)}` : "";
    return `${number(value, 1)}${spread} °C`;
  }

  sentence(known) {
    let [warmest, most] = ["", -Infinity];
    for (const [node, value] of known) if (value > most) [warmest, most] = [node, value];
    return warmest && Number.isFinite(most) ? `Warmest is ${words(warmest)} at ${number(most, 1)} °C.` : "No temperature is known.";
  }

  /* What moves; with every picture of the screen that the browser makes. */
  move(now) {
    if (!this.svg || !this.store.page) return;
    const seconds = Math.min(0.1, (now - this.then) / 1000);
    if (seconds < 0.03) return;
    this.then = now;
    const store = this.store;
    const share = Math.min(1.02, Math.max(-0.02, measured(store, "hydraulics.rod_position", "state.rod_position") / store.page.rig.stroke));
    if (Number.isFinite(share) && share !== this.share) {
      this.share = share;
      const x = (STROKE * share).toFixed(1);
      this.moving.setAttribute("transform", `translate(${x} 0)`);
      this.pointer.setAttribute("transform", `translate(${x} 0)`);
      this.chambers.a.setAttribute("width", (PISTON[0] + STROKE * share - BORE[0]).toFixed(1));
      this.chambers.b.setAttribute("x", (PISTON[1] + STROKE * share).toFixed(1));
      this.chambers.b.setAttribute("width", (BORE[1] - PISTON[1] - STROKE * share).toFixed(1));
    }
    const halted = this.still.matches || performance.now() - store.cameAt > 700;
    if (!halted) for (const arrows of this.arrows) arrows.move(seconds);
  }

  /* How each sensor is: rows of the document "sensors". */
  sensorsAre(rows) {
    if (!this.svg) return;
    const by = new Map(rows.map((row) => [row.topic, row]));
    for (const badge of this.sensors) {
      const row = by.get(badge.dataset.sensor);
      for (const state of ["ok", "warn", "error", "stopped", "paused", "absent"])
        badge.classList.toggle(state, row ? row.state === state : state === "absent");
      badge.querySelector("title").textContent = row ? `${words(row.name)}: ${row.why}` : badge.dataset.sensor;
    }
  }

  /* Where a gap is open: rows of the document "gap", and the component that it points to. */
  gapIs(gap) {
    if (!this.svg) return;
    const open = new Map();
    for (const row of gap ? gap.signals : []) if (row.opened && !open.has(row.place)) open.set(row.place, row);
    for (const badge of this.sensors) {
      const place = badge.dataset.place || badge.dataset.sensor.replace("temperature/", "").replace("/telemetry", "");
      const isTemperature = badge.dataset.sensor.startsWith("temperature/");
      const row = [...open.values()].find((r) => r.place === place && r.signal.startsWith("temperature/") === isTemperature);
      badge.classList.toggle("gap", Boolean(row));
      badge.querySelector(".gap-size").textContent = row ? `${number(Math.abs(row.floors), 1)} ×` : "";
    }
    for (const group of this.svg.querySelectorAll("[data-component]"))
      group.classList.toggle("pointed", Boolean(gap && gap.component && group.dataset.component === gap.component));
  }

  /* Rows of the table of all temperatures. */
  table(body) {
    if (!this.store.page) return;
    const nodes = this.store.page.quantities.filter(
      (q) => q.group === "temperatures" && this.store.place.has(`estimate.${q.id.slice(12)}.temperature`),
    );
    if (body.childElementCount !== nodes.length) {
      body.replaceChildren(
        ...nodes.map((q) =>
          element("tr", {}, element("th", { scope: "row" }, q.label), ...[0, 1, 2].map(() => element("td", { class: "n" }))),
        ),
      );
    }
    nodes.forEach((q, i) => {
      const node = q.id.slice(12);
      const value = (column) => this.store.value(column);
      const cells = body.children[i].children;
      cells[1].textContent = `${number(value(`estimate.${node}.temperature`), 1)} ± ${number(this.store.page.band * value(`estimate.${node}.standard_deviation`), 1)}`;
      cells[2].textContent = number(value(`prediction.temperature.${node}`), 1);
      cells[3].textContent = node in SENSOR_OF ? number(value(`${SENSOR_OF[node]}.reading`), 1) : "";
    });
  }
}

function measured(store, ...columns) {
  for (const column of columns) if (Number.isFinite(store.value(column))) return store.value(column);
  return NaN;
}

function quantity(value, digits, unit) {
  return Number.isFinite(value) ? `${number(value, digits)} ${unit}` : "";
}

function trace(channel) {
  const copy = channel.cloneNode();
  channel.classList.remove("channel");
  return copy;
}

function dress(badge) {
  const make = (tag, attributes) => {
    const made = document.createElementNS(NS, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    badge.append(made);
    return made;
  };
  make("circle", { class: "ring", r: 17 });
  make("path", { class: "cross", d: "M-9 -9L9 9M9 -9L-9 9" });
  const side = {
    above: [0, -20, "middle"],
    below: [0, 31, "middle"],
    left: [-19, 5, "end"],
    right: [19, 5, "start"],
    "left-above": [6, -21, "end"],
    "left-below": [8, 32, "end"],
    "right-below": [-8, 32, "start"],
  }[badge.dataset.side ?? "right"];
  make("text", { class: "gap-size", x: side[0], y: side[1] }).style.textAnchor = side[2];
  make("title", {});
}
