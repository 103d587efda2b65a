// The occupancy map from above, north up; drag to move, wheel to zoom.

import { FREE, OCCUPIED } from "./history.js";
import { rgb } from "./colours.js";
import { Sheet } from "./canvas.js";
import { drawAxes, drawCompass, drawScale } from "./gauges.js";
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
    this.painted = {}; // which map, after which step, in which theme
    this.window = mission.seenWindow();
    this.moved = null; // {x, y, scale} once the map was moved by hand
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
    this.#paint(look.theme);
    const ctx = this.sheet.begin();
    const { scale } = this.place();
    const f = this.mission.frame;
    ctx.fillStyle = look.theme.unknown;
    ctx.fillRect(0, 0, this.sheet.width, this.sheet.height);
    const [left, top] = this.toPixels(f.x_m, f.y_m + f.rows * f.cell_m);
    ctx.imageSmoothingEnabled = false;
    ctx.drawImage(this.picture, left, top, f.columns * f.cell_m * scale, f.rows * f.cell_m * scale);
    const view = { at: (x, y) => this.toPixels(x, y), scale: () => scale };
    drawOverlay(ctx, view, moment, { ...look, dots: true });
    drawAxes(ctx, this.sheet, (x, y) => this.toMetres(x, y), (x, y) => this.toPixels(x, y), scale, look.theme);
    drawScale(ctx, this.sheet, scale, look.theme);
    drawCompass(ctx, this.sheet, look.theme, [1, 0], [0, 1]);
  }

  #paint(theme) {
    const map = this.mission.shownMap;
    const painted = this.painted;
    if (painted.map === map && painted.step === map.step && painted.theme === theme) return;
    this.painted = { map, step: map.step, theme };
    const [unknown, free, occupied, frontier] =
      [theme.unknown, theme.free, theme.occupied, theme.frontier].map(rgb);
    map.frontiers(this.frontier);
    const { rows, columns } = map.frame;
    const pixels = this.image.data;
    for (let row = 0; row < rows; row++) {
      let at = (rows - 1 - row) * columns * 4; // Row 0 is the lowest, an image's is the highest.
      for (let col = 0; col < columns; col++, at += 4) {
        const cell = row * columns + col;
        const label = map.labels[cell];
        let colour = unknown;
        if (label === FREE) colour = this.frontier[cell] ? frontier : free;
        else if (label === OCCUPIED) colour = occupied;
        pixels[at] = colour[0];
        pixels[at + 1] = colour[1];
        pixels[at + 2] = colour[2];
        pixels[at + 3] = 255;
      }
    }
    this.picture.getContext("2d").putImageData(this.image, 0, 0);
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
