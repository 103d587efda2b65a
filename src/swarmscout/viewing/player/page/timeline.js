// The line of steps: a slider over the curve of the explored area, with marks where robots stranded.

import { Sheet } from "./canvas.js";

export class Timeline {
  constructor(box, mission, clock) {
    this.mission = mission;
    this.clock = clock;
    this.slider = box.querySelector("input");
    this.sheet = new Sheet(box.querySelector("canvas"), () => this.#paint());
    this.slider.addEventListener("input", () => {
      clock.play(false);
      clock.goTo(Number(this.slider.value));
    });
  }

  dress(theme) {
    this.theme = theme;
    this.#paint();
  }

  draw() {
    const { slider, clock } = this;
    if (Number(slider.max) !== clock.last) {
      slider.max = clock.last;
      this.#paint();
    }
    slider.value = clock.step;
    slider.setAttribute("aria-valuetext", `step ${clock.step} of ${clock.last}`);
  }

  #paint() {
    if (!this.theme) return;
    const { sheet, mission, clock } = this;
    const ctx = sheet.begin();
    const explored = mission.coverage.explored_m2 ?? [];
    const high = Math.max(1, explored.at(-1) ?? 1);
    // The thumb is 3 px wide, and its middle runs from 1.5 px to 1.5 px before the end.
    const x = (step) => 1.5 + (step / Math.max(1, clock.last)) * (sheet.width - 3);
    const y = (value) => sheet.height - 2 - (value / high) * (sheet.height - 6);
    ctx.beginPath();
    ctx.moveTo(x(0), sheet.height);
    const stride = Math.max(1, Math.floor(explored.length / sheet.width));
    for (let step = 0; step < explored.length; step += stride) ctx.lineTo(x(step), y(explored[step]));
    ctx.lineTo(x(explored.length - 1), y(explored.at(-1) ?? 0));
    ctx.lineTo(x(explored.length - 1), sheet.height);
    ctx.closePath();
    ctx.globalAlpha = 0.22;
    ctx.fillStyle = this.theme.accent;
    ctx.fill();
    ctx.globalAlpha = 1;
    ctx.fillStyle = this.theme.stranded;
    const stranded = mission.facts.words.event.indexOf("stranded");
    mission.events.kind.forEach((kind, i) => {
      if (kind === stranded) ctx.fillRect(x(mission.events.step[i]) - 1, 0, 2, 5);
    });
  }
}
