// Curves over the steps: explored area, charge, teams; a second run dashed; a cursor at the step.

/* global uPlot */

import { element } from "./elements.js";

const WHOLE = [1, 2, 5].flatMap((n) => [0, 1, 2, 3, 4, 5].map((power) => n * 10 ** power)).sort((a, b) => a - b);
const CHARTS = [
  { key: "explored", title: "explored area (m²)", height: 1.35, series: ["explored_m2"] },
  { key: "charge", title: "charge: mean and least (%)", height: 1, most: 100, series: ["mean", "least"] },
  { key: "teams", title: "teams · charging", height: 1, series: ["teams", "charging"] },
];

export class Curves {
  /** @param go called with the step that is pointed at. */
  constructor(box, missions, go) {
    this.box = box;
    this.missions = missions;
    this.go = go;
    this.charge = missions.map(() => ({ mean: [], least: [] }));
    this.step = 0;
    this.plots = [];
    new ResizeObserver(() => this.#fit()).observe(box);
  }

  /** Make the charts anew, in a theme's colours. */
  dress(theme) {
    this.theme = theme;
    for (const plot of this.plots) plot.destroy();
    this.box.replaceChildren();
    this.plots = CHARTS.map((chart) => this.#make(chart));
    this.#fit();
  }

  /** Take in the steps that came since. */
  update() {
    this.plots.forEach((plot, i) => plot.setData(this.#data(CHARTS[i])));
  }

  moveTo(step) {
    if (step === this.step) return;
    this.step = step;
    for (const plot of this.plots) this.#placeCursor(plot);
  }

  #values(k, name) {
    const mission = this.missions[k];
    if (name !== "mean" && name !== "least") return mission.coverage[name] ?? [];
    const charge = this.charge[k];
    const { charge: all, alive } = mission.columns;
    for (let s = charge.mean.length; s < mission.steps; s++) {
      let [sum, count, least] = [0, 0, 1000];
      for (let i = s * mission.robots; i < (s + 1) * mission.robots; i++) {
        if (!alive[i]) continue; // Stranded robots do not count.
        sum += all[i];
        count++;
        least = Math.min(least, all[i]);
      }
      charge.mean.push(count ? sum / count / 10 : null);
      charge.least.push(count ? least / 10 : null);
    }
    return charge[name];
  }

  #data(chart) {
    const length = Math.max(...this.missions.map((mission) => mission.steps));
    const steps = Array.from({ length }, (_, i) => i);
    const rows = [];
    this.missions.forEach((_, k) => {
      for (const name of chart.series) {
        const values = this.#values(k, name);
        rows.push(steps.map((i) => values[i] ?? null));
      }
    });
    return [steps, ...rows];
  }

  #make(chart) {
    const theme = this.theme;
    const colours = [chart.key === "explored" ? theme.accent : chart.key === "charge" ? theme.charge : theme.destination, theme.charge];
    const series = [{}];
    this.missions.forEach((_, k) => {
      chart.series.forEach((name, i) => {
        const second = i > 0;
        series.push({
          label: name, stroke: k ? theme.second_run : colours[chart.key === "charge" ? 0 : i],
          width: second ? 1 : 1.8, dash: k ? [5, 4] : second ? [2, 3] : undefined, points: { show: false },
        });
      });
    });
    const figure = element("figure");
    const caption = element("figcaption", {}, chart.title);
    const value = element("output");
    caption.append(value);
    figure.append(caption);
    this.box.append(figure);
    const axis = {
      stroke: theme.muted, font: "11px system-ui, sans-serif", grid: { stroke: theme.line, width: 1 },
      ticks: { show: false },
    };
    const options = {
      width: 300, height: 90, legend: { show: false }, padding: [6, 10, 0, 0],
      cursor: { y: false, points: { show: false }, drag: { setScale: false, x: false } },
      scales: { x: { time: false }, y: { range: (_, __, high) => [0, chart.most ?? (high > 0 ? high * 1.08 : 1)] } },
      axes: [
        { ...axis, size: 20, gap: 2, space: 60 },
        { ...axis, size: 44, gap: 3, space: 12, incrs: WHOLE },
      ],
      series,
      hooks: {
        draw: [(plot) => plot.ours && this.#placeCursor(plot)],
        ready: [(plot) => this.#listen(plot)],
      },
    };
    const plot = new uPlot(options, this.#data(chart), figure);
    plot.ours = { cursor: element("div", { class: "cursor" }), output: value, chart };
    plot.over.append(plot.ours.cursor);
    this.#placeCursor(plot);
    return plot;
  }

  /** The cursor is an element of its own: moving it does not draw the curves again. */
  #placeCursor(plot) {
    const { cursor, output, chart } = plot.ours;
    cursor.style.transform = `translateX(${plot.valToPos(this.step, "x")}px)`;
    const texts = this.missions.map((_, k) =>
      chart.series
        .map((name) => this.#values(k, name)[this.step])
        .map((number) => (number == null ? "–" : Math.round(number)))
        .join(" · "),
    );
    output.textContent = texts.length > 1 ? texts.map((text, k) => `${"AB"[k]}: ${text}`).join("   ") : texts[0];
  }

  #listen(plot) {
    const seek = (event) => {
      const step = Math.round(plot.posToVal(event.clientX - plot.over.getBoundingClientRect().left, "x"));
      this.go(Math.max(0, step));
    };
    plot.over.addEventListener("pointerdown", (event) => {
      plot.over.setPointerCapture(event.pointerId);
      seek(event);
    });
    plot.over.addEventListener("pointermove", (event) => event.buttons && seek(event));
  }

  #fit() {
    if (!this.plots.length) return;
    const style = getComputedStyle(this.box);
    const width = this.box.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight);
    const height = this.box.clientHeight - parseFloat(style.paddingTop) - parseFloat(style.paddingBottom);
    if (width < 40) return;
    const sum = CHARTS.reduce((total, chart) => total + chart.height, 0);
    const captions = 18 * CHARTS.length;
    this.plots.forEach((plot, i) => {
      const share = (Math.max(150, height - captions - 4) * CHARTS[i].height) / sum;
      plot.setSize({ width: Math.floor(width), height: Math.floor(share) });
    });
  }
}
