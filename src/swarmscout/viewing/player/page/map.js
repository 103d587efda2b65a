// The occupancy map in the paper's colours, from above; drag to move, wheel to zoom.

import { FREE, OCCUPIED } from "./history.js";
import { MAP, ON_MAP } from "./colours.js";
import { Sheet } from "./canvas.js";
import { drawOverlay } from "./overlay.js";

export class MapView {
  /** @param box the element to fill; @param changed called when the view wants to be drawn again. */
  constructor(box, mission, changed) {
    this.box = box;
    this.mission = mission;
    this.changed = changed;
    this.sheet = new Sheet(box.querySelector("canvas"), changed);
    const { rows, columns } = mission.frame;
    this.image = new ImageData(columns, rows);
    this.picture = document.createElement("canvas");
    this.picture.width = columns;
    this.picture.height = rows;
    this.frontier = new Uint8Array(rows * columns);
    this.painted = {}; // which map, after which step
    this.window = mission.seenWindow();
    this.moved = null; // {x, y, scale} once somebody has moved the map
    this.#listen();
  }

  /** Show a window in metres: [left, bottom, right, top]. */
  fit(window) {
    this.window = window;
    this.moved = null;
    this.changed();
  }

  /** Where the map lies on the sheet: centre in metres and pixels per metre. */
  place() {
    if (this.moved) return this.moved;
    const [left, bottom, right, top] = this.window;
    const scale = Math.min(this.sheet.width / (right - left), this.sheet.height / (top - bottom));
    return { x: (left + right) / 2, y: (bottom + top) / 2, scale };
  }

  follow(x, y) {
    const place = this.place();
    this.moved = { x, y, scale: Math.max(place.scale, Math.min(this.sheet.width, this.sheet.height) / 24) };
  }

  toPixels(x, y) {
    const { x: cx, y: cy, scale } = this.place();
    return [this.sheet.width / 2 + (x - cx) * scale, this.sheet.height / 2 - (y - cy) * scale];
  }

  toMetres(px, py) {
    const { x, y, scale } = this.place();
    return [x + (px - this.sheet.width / 2) / scale, y - (py - this.sheet.height / 2) / scale];
  }

  draw(moment, look) {
    this.#paint();
    const ctx = this.sheet.begin();
    const { scale } = this.place();
    const f = this.mission.frame;
    ctx.fillStyle = `rgb(${MAP.unknown.join()})`;
    ctx.fillRect(0, 0, this.sheet.width, this.sheet.height);
    const [left, top] = this.toPixels(f.x_m, f.y_m + f.rows * f.cell_m);
    ctx.imageSmoothingEnabled = false;
    ctx.drawImage(this.picture, left, top, f.columns * f.cell_m * scale, f.rows * f.cell_m * scale);
    const view = { at: (x, y) => this.toPixels(x, y), scale: () => scale };
    drawOverlay(ctx, view, moment, { ...look, theme: ON_MAP, dark: false, dots: true });
    this.#drawScale(ctx, scale);
  }

  #paint() {
    const map = this.mission.shownMap;
    if (this.painted.map === map && this.painted.step === map.step) return;
    this.painted = { map, step: map.step };
    map.frontiers(this.frontier);
    const { rows, columns } = map.frame;
    const pixels = this.image.data;
    for (let row = 0; row < rows; row++) {
      let at = (rows - 1 - row) * columns * 4; // Row 0 is the lowest, an image's is the highest.
      for (let col = 0; col < columns; col++, at += 4) {
        const cell = row * columns + col;
        const label = map.labels[cell];
        let colour = MAP.unknown;
        if (label === FREE) colour = this.frontier[cell] ? MAP.frontier : MAP.free;
        else if (label === OCCUPIED) colour = MAP.occupied;
        pixels[at] = colour[0];
        pixels[at + 1] = colour[1];
        pixels[at + 2] = colour[2];
        pixels[at + 3] = 255;
      }
    }
    this.picture.getContext("2d").putImageData(this.image, 0, 0);
  }

  #drawScale(ctx, scale) {
    const wanted = (0.25 * this.sheet.width) / scale;
    const power = 10 ** Math.floor(Math.log10(wanted));
    const length = [5, 2, 1].map((part) => part * power).find((metres) => metres <= wanted) ?? power;
    const [x, y] = [12, this.sheet.height - 12];
    ctx.fillStyle = "rgba(255, 255, 255, 0.75)";
    ctx.fillRect(x - 5, y - 19, length * scale + 10, 25);
    ctx.strokeStyle = ctx.fillStyle = "#222";
    ctx.lineWidth = 2;
    ctx.beginPath();
    ctx.moveTo(x, y);
    ctx.lineTo(x + length * scale, y);
    ctx.stroke();
    ctx.font = "11px system-ui, sans-serif";
    ctx.textAlign = "left";
    ctx.fillText(`${length} m`, x, y - 6);
  }

  #listen() {
    const { canvas } = this.sheet;
    let grabbed = null;
    canvas.addEventListener("pointerdown", (event) => {
      grabbed = { px: event.clientX, py: event.clientY, place: this.place() };
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!grabbed || !event.buttons) return;
      const { place } = grabbed;
      const [dx, dy] = [event.clientX - grabbed.px, event.clientY - grabbed.py];
      if (Math.hypot(dx, dy) < 3 && !this.moved) return;
      this.moved = { x: place.x - dx / place.scale, y: place.y + dy / place.scale, scale: place.scale };
      this.box.dispatchEvent(new Event("moved"));
      this.changed();
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const [px, py] = [event.offsetX, event.offsetY];
      const [x, y] = this.toMetres(px, py);
      const scale = Math.max(0.5, Math.min(200, this.place().scale * Math.exp(-event.deltaY * 0.0015)));
      // The point under the pointer stays where it is.
      this.moved = {
        x: x - (px - this.sheet.width / 2) / scale,
        y: y + (py - this.sheet.height / 2) / scale,
        scale,
      };
      this.changed();
    }, { passive: false });
    canvas.addEventListener("dblclick", () => this.fit(this.window));
  }
}
