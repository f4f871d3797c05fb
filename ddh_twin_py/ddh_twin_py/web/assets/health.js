/* How every node and every sensor is. */
import { element, plain, words } from "./format.js";

const MARKS = { ok: "✓", warn: "▲", error: "✕", stopped: "✕", silent: "✕", absent: "–", paused: "‖" };
const LEVELS = ["ok", "warn", "error", "silent"];

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
        row.box = element(
          "details",
          { class: "row" },
          element("summary", {}, row.mark, element("span", {}, node.node.split("/").pop()), row.why, element("span", { class: "rate" })),
          row.list,
        );
        this.rows.set(node.node, row);
        this.body.append(row.box);
      }
      const state = LEVELS[node.level];
      row.box.className = `row ${state}`;
      row.mark.textContent = MARKS[state];
      row.why.textContent = node.message;
      if (row.box.open && row.list.childElementCount && row.list.contains(document.activeElement)) continue;
      if (row.box.open || !row.list.childElementCount)
        row.list.replaceChildren(...node.lines.map(([concern, level, message]) => this.line(node.node, concern, level, message)));
    }
  }

  line(node, concern, level, message) {
    const values = element("dl", { hidden: true });
    const more = element(
      "button",
      {
        type: "button",
        "aria-expanded": "false",
        "aria-label": `values of ${concern}`,
        onclick: async () => {
          values.hidden = !values.hidden;
          more.setAttribute("aria-expanded", String(!values.hidden));
          if (values.hidden) return;
          const answer = await fetch(`health?name=${encodeURIComponent(`${node}: ${concern}`)}`).catch(() => null);
          const pairs = answer?.ok ? await answer.json() : [];
          values.replaceChildren(...pairs.flatMap(([key, value]) => [element("dt", {}, key), element("dd", {}, value)]));
        },
      },
      "…",
    );
    const state = LEVELS[level];
    return element(
      "li",
      { class: state },
      more,
      element("span", { class: "mark" }, MARKS[state]),
      ` ${concern}: `,
      element("span", { class: "why" }, message),
      values,
    );
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
        row = {
          mark: element("span", { class: "mark" }),
          why: element("span", { class: "why" }),
          rate: element("span", { class: "rate" }),
        };
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
