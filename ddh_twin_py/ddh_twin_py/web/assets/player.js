/* Replay: pause, seek, rate, where a bag plays. */
import { span } from "./format.js";

const MOVED = 0.2; // s of the recording, by which a paused player was moved
const SLOW = 0.8; // share of the rate asked for, below which the speed reached is told
const STARTED = 3000; // ms until the speed over the last second is that of the rate

export class Player {
  constructor(link) {
    this.link = link;
    this.data = null;
    const get = (id) => document.getElementById(id);
    this.bar = get("player");
    this.play = get("play");
    this.slider = get("seek");
    this.position = get("position");
    this.rate = get("rate");
    this.note = get("player-note");
    this.held = false; // the slider is in somebody's hand
    this.aim = null; // s, where a seek goes, until the player has told that it is there
    this.answered = false;
    this.seeks = 0;
    this.since = 0; // ms, when it began to move, or was told another rate
    this.moving = "";
    this.play.addEventListener("click", () => this.toggle());
    get("back").addEventListener("click", () => this.step(-10));
    get("on").addEventListener("click", () => this.step(10));
    this.slider.addEventListener("input", () => {
      this.held = true;
      this.place(Number(this.slider.value));
    });
    this.slider.addEventListener("change", () => {
      this.held = false;
      this.seek(Number(this.slider.value));
    });
    for (const end of ["pointerup", "pointercancel", "blur"]) this.slider.addEventListener(end, () => setTimeout(() => this.release()));
    this.rate.addEventListener("change", () => this.wish("rate", Number(this.rate.value)));
  }

  async wish(name, value) {
    this.note.textContent = "";
    const refused = await this.link.wish(name, value);
    this.note.textContent = refused ? `✕ ${refused}` : "";
    return !refused;
  }

  async seek(offset) {
    const number = ++this.seeks;
    this.aim = Math.min(this.data.duration, Math.max(0, offset));
    this.answered = false;
    this.slider.value = this.aim;
    this.place(this.aim);
    const done = await this.wish("seek", this.aim);
    if (number !== this.seeks) return; // another one since
    this.answered = true;
    if (!done) this.show(this.data);
  }

  /* Steps add up, however fast the key is pressed. */
  step(seconds) {
    if (this.data) this.seek((this.aim ?? this.data.position) + seconds);
  }

  /* Let go of at the place where it was taken: nothing has changed, and no seek follows. */
  release() {
    if (!this.held) return;
    this.held = false;
    if (this.data) this.show(this.data);
  }

  async toggle() {
    if (!this.data) return;
    if (this.data.ended) {
      await this.seek(0);
      if (!this.data.paused) return;
    }
    this.wish("pause", !this.data.paused);
  }

  place(position) {
    this.position.textContent = `${span(position)} of ${span(Math.round(this.data.duration))}`;
  }

  show(data) {
    if (this.answered) [this.aim, this.answered] = [null, false];
    if (!data || !data.paused) this.elsewhere = false;
    else if (this.data?.paused && Math.abs(data.position - this.data.position) > MOVED) this.elsewhere = true;
    this.data = data;
    this.bar.hidden = !data;
    if (!data) return;
    const moving = data.waiting || data.paused || data.ended || this.aim !== null ? "" : `at ${data.rate}`;
    if (moving !== this.moving) [this.moving, this.since] = [moving, Date.now()];
    this.play.textContent = data.ended ? "Again" : data.paused ? "Play" : "Pause";
    this.slider.max = data.duration;
    if (!this.held && this.aim === null) {
      this.slider.value = data.position;
      this.place(data.position);
    }
    this.slider.setAttribute("aria-valuetext", `${span(data.position)} of ${span(Math.round(data.duration))}`);
    const text = String(data.rate);
    if (document.activeElement !== this.rate) {
      if (![...this.rate.options].some((option) => option.value === text)) this.rate.add(new Option(`${text} ×`, text));
      this.rate.value = text;
    }
    if (!this.note.textContent.startsWith("✕"))
      this.note.textContent = data.waiting
        ? "waits for the nodes"
        : data.paused || data.ended
          ? this.elsewhere
            ? "what is shown is of where it was paused, until Play"
            : ""
          : data.rate === 0
            ? `${data.speed.toFixed(1)} × real time`
            : data.speed < SLOW * data.rate && Date.now() - this.since > STARTED
              ? `▲ ${data.speed.toFixed(1)} × real time, as fast as this computer can`
              : "";
  }
}
