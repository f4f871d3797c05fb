/* How far the limits are away, and what keeps them. */
import { element, lasting, number, words } from "./format.js";

const NAMES = { winding_hot_spot: "winding, hottest point", oil: "oil, hottest volume", seals: "seals, pump cases and barrel" };
const COOL = 0; // degC at which a gauge begins

export function limits(body, data) {
  if (!data) return;
  const duty = data.duty_known
    ? `if the duty of the last minutes goes on (${number(data.rms_current, 1)} A rms)`
    : "no duty is known, rest is looked at";
  body.replaceChildren(
    ...data.limits.map((row) => margin(row, data)),
    element("p", { class: "note" }, `Looked ${lasting(data.horizon)} ahead, ${duty}.`),
  );
}

function margin(row, data) {
  const share = (value) => Math.min(100, Math.max(0, (100 * (value - COOL)) / (row.limit - COOL)));
  const near = (time) => time !== null && data.warn_within !== null && time <= data.warn_within;
  const soon = near(row.time_to_limit) || near(row.time_to_limit_16);
  const beyond = row.time_to_limit !== null && row.time_to_limit <= 0;
  const low = share(row.temperature - 2 * row.standard_deviation);
  const band = element("b");
  const fill = element("i");
  fill.style.width = `${share(row.temperature)}%`;
  band.style.left = `${low}%`;
  band.style.width = `${share(row.temperature + 2 * row.standard_deviation) - low}%`;
  return element(
    "div",
    { class: `margin ${beyond ? "poor" : soon ? "fair" : "good"}` },
    element(
      "p",
      {},
      element("span", {}, NAMES[row.location] ?? words(row.location)),
      element(
        "span",
        { class: "now" },
        `${number(row.temperature, 1)} ± ${number(2 * row.standard_deviation, 1)} of ${degrees(row.limit)} °C`,
      ),
    ),
    element("div", { class: "gauge" }, fill, band),
    element("span", { class: "then" }, sentence(row, data, beyond, soon)),
  );
}

/* Why a duty of more current than may be held keeps the limit all the same; empty elsewhere. */
function falls(row, data) {
  const keeps = data.duty_known && row.time_to_limit === null && row.allowed_speed !== null && row.allowed_speed >= data.mean_absolute_speed;
  if (!keeps || row.allowed_current > data.rms_current - 0.1) return "";
  return `; this duty does too: its ${number(data.rms_current, 1)} A rms fall as the oil warms`;
}

/* What keeps the limit, a sentence. */
function keeps(row, data, beyond) {
  const limit = `${degrees(row.limit)} °C`;
  if (!(row.allowed_current > 0)) return `No current keeps it below ${limit}.`;
  const speed = row.allowed_speed === null ? "" : `, or a mean of ${number((row.allowed_speed * 30) / Math.PI, 0)} rpm`;
  const does = beyond ? "comes back" : "stays";
  return `It ${does} below ${limit} for good at up to ${number(row.allowed_current, 1)} A rms held${speed}${falls(row, data)}.`;
}

function sentence(row, data, beyond, soon) {
  const kept = keeps(row, data, beyond);
  if (beyond) return `✕ Exceeded. ${kept}`;
  const horizon = lasting(data.horizon);
  if (row.time_to_limit === null) {
    const sooner = row.time_to_limit_16 === null ? "" : ` (one in six: ${lasting(row.time_to_limit_16)})`;
    return `Not within ${horizon}${sooner}, ${number(row.limit - row.temperature, 0)} K left. ${kept}`;
  }
  const late = row.time_to_limit_84 === null ? `more than ${horizon}` : lasting(row.time_to_limit_84);
  const early = row.time_to_limit_16 === null ? late : lasting(row.time_to_limit_16);
  return `${soon ? "▲ " : ""}Limit in ${lasting(row.time_to_limit)} (${early} to ${late}). ${kept}`;
}

/* A limit as it was set: 145, 72.5. */
function degrees(limit) {
  return number(limit, Math.abs(limit - Math.round(limit)) < 0.05 ? 0 : 1);
}
