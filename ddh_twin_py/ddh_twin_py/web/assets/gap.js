/* The gap as it opens: the verdict, and how the test of each signal stands. */
import { element, number, plain, timeOfDay, words } from "./format.js";

const FIRST_SIGNALS = 5;

export function gap(body, line, data) {
  line.className = `verdict ${{ open: "poor", none: "good", learning: "" }[data?.state] ?? ""}`;
  line.textContent = data ? data.verdict : "Nothing is known of a gap: gap_monitor has said nothing yet.";
  if (!data) return;
  const parts = [];
  if (data.state === "open")
    parts.push(
      element(
        "p",
        {},
        data.component ? `Points to ${words(data.component)}: ${data.because}` : `Does not point to one component: ${data.because}`,
      ),
    );
  const learning = data.state === "learning";
  const first = Math.max(FIRST_SIGNALS, data.signals.filter((row) => row.opened).length);
  parts.push(table(data.signals.slice(0, first), learning));
  if (data.signals.length > first) {
    const open = body.querySelector("details")?.open;
    parts.push(
      element(
        "details",
        { open },
        element("summary", {}, `all ${data.signals.length} signals`),
        table(data.signals.slice(first), learning),
      ),
    );
  }
  parts.push(
    element(
      "p",
      { class: "note" },
      `A gap opens when a bar, the statistic of its test, is full. Declared: one false alarm in ${plain(data.hours, 2)} h of work.`,
    ),
  );
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
  const more = row.opened
    ? `${number(Math.abs(row.floors), 1)} × floor, since ${timeOfDay(row.since)}`
    : learning
      ? `${number(100 * row.learned, 0)} % learned`
      : `${number(100 * row.share, 0)} %`;
  return element(
    "li",
    { class: row.opened ? "open" : "" },
    element("p", {}, element("span", {}, row.opened ? `▲ ${row.name}` : row.name), element("span", { class: "now" }, size)),
    element("p", {}, element("div", { class: `gauge small${learning ? " learn" : ""}` }, fill), element("small", {}, more)),
  );
}
