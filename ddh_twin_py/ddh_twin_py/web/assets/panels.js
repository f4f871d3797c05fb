/* Margins, gap, nodes and sensors beside the drawing. */
import { element, lasting, number, plain, timeOfDay, words } from "./format.js";

const NAMES = { winding_hot_spot: "winding, hottest point", oil: "oil, hottest volume", seals: "seals, pump cases and barrel" };
const MARKS = { ok: "✓", warn: "▲", error: "✕", stopped: "✕", silent: "✕", absent: "–", paused: "‖" };
const LEVELS = ["ok", "warn", "error", "silent"];
const COOL = 20; // degC at which a gauge begins
const SOON = 1800; // s
const FIRST_SIGNALS = 5;

export function limits(body, data) {
  if (!data) return;
  const duty = data.duty_known ? `if the duty of the last minutes goes on (${number(data.rms_current, 1)} A rms)` : "no duty is known, rest is looked at";
  body.replaceChildren(...data.limits.map((row) => margin(row, data.horizon)), element("p", { class: "note" }, `Looked ${lasting(data.horizon)} ahead, ${duty}.`));
}

function margin(row, horizon) {
  const share = (value) => Math.min(100, Math.max(0, (100 * (value - COOL)) / (row.limit - COOL)));
  const soon = row.time_to_limit !== null && row.time_to_limit <= SOON || row.time_to_limit_16 !== null && row.time_to_limit_16 <= SOON;
  const beyond = row.time_to_limit !== null && row.time_to_limit <= 0;
  const low = share(row.temperature - 2 * row.standard_deviation);
  const band = element("b");
  const fill = element("i");
  fill.style.width = `${share(row.temperature)}%`;
  band.style.left = `${low}%`;
  band.style.width = `${share(row.temperature + 2 * row.standard_deviation) - low}%`;
  return element("div", { class: `margin ${beyond ? "poor" : soon ? "fair" : "good"}` },
    element("p", {}, element("span", {}, NAMES[row.location] ?? words(row.location)),
      element("span", { class: "now" }, `${number(row.temperature, 1)} ± ${number(2 * row.standard_deviation, 1)} of ${number(row.limit, 0)} °C`)),
    element("div", { class: "gauge" }, fill, band),
    element("span", { class: "then" }, sentence(row, horizon, beyond, soon)));
}

function sentence(row, horizon, beyond, soon) {
  const keeps = row.allowed_current > 0
    ? `${number(row.allowed_current, 1)} A rms${row.allowed_speed === null ? "" : ` or a mean of ${number((row.allowed_speed * 30) / Math.PI, 0)} rpm`} keep it for ever`
    : "no current keeps it";
  if (beyond) return `✕ exceeded; ${keeps}`;
  if (row.time_to_limit === null) {
    const sooner = row.time_to_limit_16 === null ? "" : ` (one in six: ${lasting(row.time_to_limit_16)})`;
    return `not within ${lasting(horizon)}${sooner}; ${number(row.limit - row.temperature, 0)} K left; ${keeps}`;
  }
  const late = row.time_to_limit_84 === null ? `more than ${lasting(horizon)}` : lasting(row.time_to_limit_84);
  const early = row.time_to_limit_16 === null ? late : lasting(row.time_to_limit_16);
  return `${soon ? "▲ " : ""}limit in ${lasting(row.time_to_limit)} (${early} to ${late}); ${keeps}`;
}

export function gap(body, line, data) {
  line.className = `verdict ${{ open: "poor", none: "good", learning: "" }[data?.state] ?? ""}`;
  line.textContent = data ? data.verdict : "Nothing is known of a gap: gap_monitor has said nothing yet.";
  if (!data) return;
  const parts = [];
  if (data.state === "open") parts.push(element("p", {}, data.component ? `Points to ${words(data.component)}: ${data.because}` : `Does not point to one component: ${data.because}`));
  const learning = data.state === "learning";
  const first = Math.max(FIRST_SIGNALS, data.signals.filter((row) => row.opened).length);
  parts.push(table(data.signals.slice(0, first), learning));
  if (data.signals.length > first) {
    const open = body.querySelector("details")?.open;
    parts.push(element("details", { open }, element("summary", {}, `all ${data.signals.length} signals`), table(data.signals.slice(first), learning)));
  }
  parts.push(element("p", { class: "note" }, `A gap opens when a bar, the statistic of its test, is full. Declared: one false alarm in ${plain(data.hours, 2)} h of work.`));
  const focused = body.contains(document.activeElement);
  body.replaceChildren(...parts);
  if (focused) body.querySelector("summary")?.focus();
}

function table(rows, learning) {
  return element("ul", { class: "signals" }, ...rows.map((row) => signal(row, learning || !row.tested)));
}

function signal(row, learning) {
  const fill = element("i");
  fill.style.width = `${Math.min(100, 100 * (learning ? row.learned : row.share))}%`;
  const size = row.opened ? row.size : row.floor ? `floor ${row.floor}` : "";
  const more = row.opened ? `${number(Math.abs(row.floors), 1)} × floor, since ${timeOfDay(row.since)}` : learning ? `${number(100 * row.learned, 0)} % learned` : `${number(100 * row.share, 0)} %`;
  return element("li", { class: row.opened ? "open" : "" },
    element("p", {}, element("span", {}, row.opened ? `▲ ${row.name}` : row.name), element("span", { class: "now" }, size)),
    element("p", {}, element("div", { class: `gauge small${learning ? " learn" : ""}` }, fill), element("small", {}, more)));
}

/* Rows that stay where they are while their words change, so that what is open stays open and the focus is kept. */
export class Nodes {
  constructor(body) {
    this.body = body;
    this.rows = new Map();
  }

  show(data) {
    if (!this.rows.size && data.length) this.body.replaceChildren();
    for (const node of data) {
      let row = this.rows.get(node.node);
      if (!row) {
        row = { mark: element("span", { class: "mark" }), why: element("span", { class: "why" }), list: element("ul") };
        row.box = element("details", { class: "row" }, element("summary", {}, row.mark, element("span", {}, node.node.split("/").pop()), row.why, element("span", { class: "rate" })), row.list);
        this.rows.set(node.node, row);
        this.body.append(row.box);
      }
      const state = LEVELS[node.level];
      row.box.className = `row ${state}`;
      row.mark.textContent = MARKS[state];
      row.why.textContent = node.message;
      if (row.box.open && row.list.childElementCount && row.list.contains(document.activeElement)) continue;
      if (row.box.open || !row.list.childElementCount) row.list.replaceChildren(...node.lines.map(([concern, level, message]) => this.line(node.node, concern, level, message)));
    }
  }

  line(node, concern, level, message) {
    const values = element("dl", { hidden: true });
    const more = element("button", { type: "button", "aria-expanded": "false", "aria-label": `values of ${concern}`, onclick: async () => {
      values.hidden = !values.hidden;
      more.setAttribute("aria-expanded", String(!values.hidden));
      if (values.hidden) return;
      const answer = await fetch(`health?name=${encodeURIComponent(`${node}: ${concern}`)}`).catch(() => null);
      const pairs = answer?.ok ? await answer.json() : [];
      values.replaceChildren(...pairs.flatMap(([key, value]) => [element("dt", {}, key), element("dd", {}, value)]));
    } }, "…");
    const state = LEVELS[level];
    return element("li", { class: state }, more, element("span", { class: "mark" }, MARKS[state]), ` ${concern}: `, element("span", { class: "why" }, message), values);
  }
}

export class Sensors {
  constructor(body, newest) {
    this.body = body;
    this.newest = newest; // text of the newest value of a topic
    this.rows = new Map();
  }

  show(data) {
    if (!this.rows.size && data.length) this.body.replaceChildren();
    for (const sensor of data) {
      let row = this.rows.get(sensor.topic);
      if (!row) {
        row = { mark: element("span", { class: "mark" }), why: element("span", { class: "why" }), rate: element("span", { class: "rate" }) };
        row.box = element("div", { class: "row" }, element("p", {}, row.mark, element("span", {}, words(sensor.name)), row.why, row.rate));
        this.rows.set(sensor.topic, row);
        this.body.append(row.box);
      }
      row.box.className = `row ${sensor.state}`;
      row.box.dataset.state = sensor.state;
      row.box.dataset.topic = sensor.topic;
      row.mark.textContent = MARKS[sensor.state];
      row.why.textContent = sensor.why;
      const rate = sensor.rate === null || sensor.state !== "ok" ? "" : `${plain(sensor.rate, 2)} Hz`;
      row.rate.textContent = [sensor.state === "absent" ? "" : this.newest(sensor.topic), rate].filter(Boolean).join(", ");
    }
  }
}
