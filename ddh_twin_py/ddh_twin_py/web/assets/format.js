/* Numbers and times as people read them. */
export const DASH = "–";

export function number(value, digits) {
  if (value == null || !Number.isFinite(value)) return DASH;
  const written = value.toFixed(digits);
  return Number(written) === 0 ? written.replace("-", "") : written.replace("-", "−");
}

export function plain(value, figures = 3) {
  if (value == null || !Number.isFinite(value)) return DASH;
  if (value === 0) return "0";
  return number(value, Math.max(0, figures - 1 - Math.floor(Math.log10(Math.abs(value)))));
}

export function watts(value, digits = 2) {
  return Math.abs(value) < 999.5 ? number(value, 0) + " W" : number(value / 1000, digits) + " kW";
}

export function words(name) {
  return name.replaceAll("_", " ");
}

/* 75.3 to 1:15; with hours where there are any. */
export function span(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  const h = Math.floor(whole / 3600);
  const m = Math.floor((whole % 3600) / 60);
  const s = String(whole % 60).padStart(2, "0");
  return h ? `${h}:${String(m).padStart(2, "0")}:${s}` : `${m}:${s}`;
}

/* A time to a limit. */
export function lasting(seconds) {
  if (seconds < 120) return `${Math.round(seconds)} s`;
  if (seconds < 7200) return `${Math.round(seconds / 60)} min`;
  return `${number(seconds / 3600, 1)} h`;
}

/* Time of day of the data, in the time zone of whoever looks. */
export function timeOfDay(seconds) {
  return new Date(seconds * 1000).toLocaleTimeString([], { hour: "2-digit", minute: "2-digit", second: "2-digit", hourCycle: "h23" });
}

export function dayAndTime(seconds) {
  return new Date(seconds * 1000).toLocaleDateString([], { year: "numeric", month: "short", day: "numeric" }) + ", " + timeOfDay(seconds);
}

/* An element with its content; text is never taken as markup. */
export function element(tag, attributes = {}, ...content) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "class") made.className = value;
    else if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value !== false && value != null) made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...content.filter((part) => part != null));
  return made;
}
