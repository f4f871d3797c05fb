/* Puts the page together. */
import { Charts } from "./charts.js";
import { Drawing } from "./drawing.js";
import { dayAndTime, number } from "./format.js";
import { gap } from "./gap.js";
import { Nodes, Sensors } from "./health.js";
import { Link } from "./link.js";
import { limits } from "./margins.js";
import { Player } from "./player.js";
import { Store } from "./store.js";

const get = (id) => document.getElementById(id);
const root = document.documentElement;
const store = new Store();
const drawing = new Drawing(store, get("circuit"));
const charts = new Charts(store, get("chart-list"), get("windows"));
const nodes = new Nodes(get("nodes"));
const sensors = new Sensors(get("sensors"), newest);

function newest(topic) {
  if (!topic.startsWith("temperature/")) return "";
  const value = store.value(`${topic.slice(12)}.reading`);
  return Number.isFinite(value) ? `${number(value, 1)} °C` : "";
}

// --- light and dark ----------------------------------------------------------------------------

function theme(name, keep) {
  root.dataset.theme = name;
  get("theme").textContent = name === "dark" ? "Light" : "Dark";
  charts.repaint();
  if (keep)
    try {
      localStorage.setItem("ddh-twin-theme", name);
    } catch {
      /* private windows have no storage */
    }
}
function chosen() {
  try {
    return localStorage.getItem("ddh-twin-theme");
  } catch {
    return null;
  }
}
const dark = matchMedia("(prefers-color-scheme: dark)");
theme(chosen() ?? (dark.matches ? "dark" : "light"), false);
dark.addEventListener("change", (event) => {
  if (!chosen()) theme(event.matches ? "dark" : "light", false);
});
get("theme").addEventListener("click", () => theme(root.dataset.theme === "dark" ? "light" : "dark", true));

// --- what comes --------------------------------------------------------------------------------

function heading() {
  const rig = store.documents.rig?.rig_id || store.page?.rig.rig_id;
  const oil = store.documents.rig?.oil_grade;
  get("title").textContent = rig ? `DDH twin, ${rig}` : "DDH twin";
  const bag = store.documents.player?.bag ?? "";
  get("subtitle").textContent = [store.page?.namespace, oil, bag.split("/").filter(Boolean).pop()].filter(Boolean).join(" · ");
  get("subtitle").title = bag;
  const open = store.documents.gap?.state === "open";
  document.title = `${open ? "▲ gap, " : ""}${rig ? `${rig}, ` : ""}DDH twin`;
}

function document_(name, data) {
  if (name === "limits") limits(get("limits-body"), data);
  else if (name === "gap") {
    gap(get("gap-body"), get("verdict"), data);
    drawing.gapIs(data);
  } else if (name === "health") nodes.show(data);
  else if (name === "sensors") {
    sensors.show(data);
    drawing.sensorsAre(data);
  } else if (name === "player") player.show(data);
  heading();
}
store.on("document", document_);

function noTelemetry(elsewhere) {
  return elsewhere.length ? `no telemetry here, but in ${elsewhere.join(", ")}` : "no telemetry";
}

function said() {
  const pill = get("link");
  const player = store.documents.player;
  let [level, text] = ["poor", link.refusal || "connection lost, trying again"];
  if (link.state === "connecting") text = "connecting";
  else if (link.state === "live") {
    const there = (store.documents.sensors ?? []).filter((sensor) => sensor.state !== "absent");
    const stopped = there.length > 0 && there.every((sensor) => sensor.state === "stopped");
    const silent = stopped || performance.now() - store.cameAt > 2000; // what a page begins with may be old
    if (player && player.waiting) [level, text] = ["fair", "waits for the nodes"];
    else if (player && player.paused) [level, text] = ["fair", "paused"];
    else if (player && player.ended) [level, text] = ["fair", "end of the recording"];
    else if (silent) [level, text] = ["poor", noTelemetry(store.documents.elsewhere ?? [])];
    else [level, text] = ["good", player ? "replay" : "live"];
  }
  pill.className = `pill ${level}`;
  if (pill.textContent !== text) pill.textContent = text;
  document.body.classList.toggle("stale", link.state !== "live");
  get("clock").textContent = store.row ? dayAndTime(store.seconds) : "";
}

const link = new Link(store, said);
const player = new Player(link);
let fetching = null;
function lookBack() {
  // more than one reason at a time is one reason; once more when what lags behind has come too
  clearTimeout(fetching);
  fetching = setTimeout(async () => {
    await charts.fetch();
    fetching = setTimeout(() => charts.fetch(), 2500);
  }, 150);
}
link.missed.push(lookBack);
store.on("jump", () => {
  for (const chart of charts.charts) chart.lay();
  lookBack();
});
get("add").addEventListener("click", () => charts.add());

// --- keys --------------------------------------------------------------------------------------

addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("select")) return;
  if (event.key === " " && event.target.closest("button, summary, a")) return; // presses what has the focus
  if (event.key === " ") player.toggle();
  else if (event.key === "ArrowLeft") player.step(-10);
  else if (event.key === "ArrowRight") player.step(10);
  else if (event.key === "t") get("theme").click();
  else if (event.key >= "1" && event.key <= "4") charts.setWindow(Number(event.key) - 1);
  else return;
  event.preventDefault();
});

// --- the screen --------------------------------------------------------------------------------

await drawing.load();
for (const name of ["sensors", "gap"]) if (store.documents[name] !== undefined) document_(name, store.documents[name]);
let painted = 0;
function picture(now) {
  drawing.move(now);
  if (now - painted > 240) {
    painted = now;
    drawing.paint();
    if (get("all-temperatures").open) drawing.table(get("temperatures"));
    said();
  }
  if (store.page) charts.draw();
  requestAnimationFrame(picture);
}
requestAnimationFrame(picture);
root.dataset.ready = "yes";
