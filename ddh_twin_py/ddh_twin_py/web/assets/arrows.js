/* Arrows that move along the lines of the drawing as oil and power do. */
const NS = "http://www.w3.org/2000/svg";
const SPACING = 44; // of the drawing's units, between two arrows
const FASTEST = 95; // units a second at the full value
const LEAST = 0.004; // share of the full value below which nothing moves

export class Arrows {
  constructor(group) {
    this.column = group.dataset.arrows;
    this.full = Number(group.dataset.full);
    this.offset = 0;
    this.speed = 0;
    this.shown = null;
    this.tracks = [];
    for (const path of [...group.querySelectorAll("path")]) {
      for (const piece of path.getAttribute("d").split(/(?=M)/)) this.tracks.push(track(group, piece));
    }
  }

  set(value) {
    const share = Number.isFinite(value) ? Math.min(1, Math.abs(value) / this.full) : 0;
    this.speed = share < LEAST ? 0 : Math.sign(value) * (12 + (FASTEST - 12) * Math.sqrt(share));
    const size = 0.75 + 0.5 * Math.sqrt(share);
    if (Math.abs(size - this.size) > 0.02 || this.size === undefined) this.size = size;
    this.show(this.speed !== 0);
  }

  show(visible) {
    if (visible === this.shown) return;
    this.shown = visible;
    for (const line of this.tracks) for (const arrow of line.arrows) arrow.setAttribute("visibility", visible ? "visible" : "hidden");
    if (visible) this.move(0);
  }

  /* Move on by so many seconds. */
  move(seconds) {
    if (!this.shown) return;
    this.offset = (((this.offset + this.speed * seconds) % SPACING) + SPACING) % SPACING;
    const turn = this.speed < 0 ? 180 : 0;
    for (const line of this.tracks) {
      line.arrows.forEach((arrow, i) => {
        const at = this.offset + i * SPACING;
        const point = line.points[Math.min(line.points.length - 1, Math.round(at / 2))];
        const fits = at <= line.length;
        arrow.setAttribute(
          "transform",
          fits ? `translate(${point[0]} ${point[1]}) rotate(${point[2] + turn}) scale(${this.size.toFixed(2)})` : "translate(-99 -99)",
        );
      });
    }
  }
}

function track(group, d) {
  const path = document.createElementNS(NS, "path");
  path.setAttribute("d", d);
  const length = path.getTotalLength();
  const points = [];
  for (let s = 0; s <= length; s += 2) {
    const here = path.getPointAtLength(s);
    const on = path.getPointAtLength(Math.min(length, s + 1));
    const before = path.getPointAtLength(Math.max(0, s - 1));
    points.push([here.x.toFixed(1), here.y.toFixed(1), Math.round((Math.atan2(on.y - before.y, on.x - before.x) * 180) / Math.PI)]);
  }
  const arrows = [];
  for (let i = 0; i * SPACING <= length; i++) {
    const arrow = document.createElementNS(NS, "polygon");
    arrow.setAttribute("points", "-6,-5.5 7,0 -6,5.5");
    arrow.setAttribute("visibility", "hidden");
    group.append(arrow);
    arrows.push(arrow);
  }
  return { length, points, arrows };
}
