// The legend: what colours, rings, stars and marks mean; on the page and on saved pictures.

import { robotColour, teamColour } from "./colours.js";
import { element } from "./elements.js";
import { dot, drawDotRing, drawPlus, star } from "./overlay.js";

const WIDTH = 24;
const HEIGHT = 18;
const [X, Y] = [WIDTH / 2, HEIGHT / 2];

function line(ctx, colour, width, dash = []) {
  ctx.strokeStyle = colour;
  ctx.lineWidth = width;
  ctx.setLineDash(dash);
  ctx.beginPath();
  ctx.moveTo(2, Y);
  ctx.lineTo(WIDTH - 2, Y);
  ctx.stroke();
  ctx.setLineDash([]);
}

function ring(ctx, colour, width) {
  ctx.strokeStyle = colour;
  ctx.lineWidth = width;
  ctx.beginPath();
  ctx.arc(X, Y, 7, 0, 2 * Math.PI);
  ctx.stroke();
}

function cell(ctx, look, colour) {
  ctx.fillStyle = colour;
  ctx.fillRect(4, 3, WIDTH - 8, HEIGHT - 6);
  ctx.strokeStyle = look.theme.muted;
  ctx.lineWidth = 1;
  ctx.strokeRect(4.5, 3.5, WIDTH - 9, HEIGHT - 7);
}

function robot(ctx, look, state) {
  ctx.fillStyle = robotColour({ alive: true, charging: false, leader: 1, ...state }, look.theme, look.byTeam, look.dark);
  dot(ctx, X, Y, 5);
}

/** Entries as `[text, draw(ctx, look)]`; `draw` has WIDTH × HEIGHT pixels. */
function entries(look) {
  const { theme } = look;
  const robots = look.byTeam
    ? [["robot, in its team's colour", (ctx) => [1, 2, 4].forEach((leader, i) => {
      ctx.fillStyle = teamColour(leader, look.dark);
      dot(ctx, X + 7 * (i - 1), Y, 3.2);
    })]]
    : [["robot, exploring (EXP)", (ctx) => robot(ctx, look, {})]];
  const chosen = look.selected < 0 ? [] : [
    ["selected robot or team", (ctx) => ring(ctx, theme.selected, 2.4)],
    ["its rays; dot: wall measured", (ctx) => {
      line(ctx, theme.selected, 1);
      ctx.fillStyle = theme.selected;
      dot(ctx, WIDTH - 4, Y, 2.4);
    }],
    ["its route", (ctx) => line(ctx, theme.selected, 1.8, [1.5, 4])],
    ["its path, last 40 steps", (ctx) => line(ctx, `${theme.selected}73`, 2.5)],
  ];
  return [
    ...robots,
    ["robot, going to charge (CHR)", (ctx) => robot(ctx, look, { charging: true })],
    ["stranded; tick on the time line", (ctx) => robot(ctx, look, { alive: false })],
    ["team", (ctx) => ring(ctx, theme.team, 1.4)],
    ["team leader", (ctx) => {
      star(ctx, X, Y, 6.8, "rgba(0, 0, 0, 0.75)");
      star(ctx, X, Y, 6, "#fff");
    }],
    ["team's destination", (ctx) => drawDotRing(ctx, X, Y, 6, 1.5, theme.destination)],
    ["from leader to destination", (ctx) => line(ctx, theme.destination, 1.2, [3, 4])],
    ["charging station", (ctx) => drawPlus(ctx, X, Y, 7, theme)],
    ...chosen,
    ["map: unknown", (ctx) => cell(ctx, look, theme.unknown)],
    ["map: free", (ctx) => cell(ctx, look, theme.free)],
    ["map: wall", (ctx) => cell(ctx, look, theme.occupied)],
    ["frontier: free beside unknown", (ctx) => cell(ctx, look, theme.frontier)],
    ["3D: mapped ground; else gray", (ctx) => cell(ctx, look, theme.ground_high)],
  ];
}

export class Legend {
  constructor(box) {
    this.list = box.querySelector("ul");
    this.shown = "";
  }

  /** Write the legend anew if what it explains has changed. */
  update(look) {
    const key = `${look.dark} ${look.byTeam} ${look.selected < 0}`;
    if (key === this.shown) return;
    this.shown = key;
    this.list.replaceChildren(...entries(look).map(([text, draw]) => {
      const canvas = element("canvas", { "aria-hidden": "true" });
      const ratio = Math.min(window.devicePixelRatio || 1, 2);
      [canvas.width, canvas.height] = [WIDTH * ratio, HEIGHT * ratio];
      const ctx = canvas.getContext("2d");
      ctx.scale(ratio, ratio);
      draw(ctx);
      const item = element("li");
      item.append(canvas, text);
      return item;
    }));
  }
}

/** Paint the legend in columns; returns its height in pixels of the page. */
export function paintLegend(ctx, look, left, top, width) {
  const all = entries(look);
  const column = 230;
  const columns = Math.max(1, Math.floor(width / column));
  const rows = Math.ceil(all.length / columns);
  if (ctx) {
    all.forEach(([text, draw], i) => {
      ctx.save();
      ctx.translate(left + column * Math.floor(i / rows), top + 22 * (i % rows));
      draw(ctx);
      ctx.fillStyle = look.theme.text;
      ctx.font = "13px system-ui, sans-serif";
      ctx.textAlign = "left";
      ctx.textBaseline = "middle";
      ctx.fillText(text, WIDTH + 6, Y);
      ctx.restore();
    });
  }
  return 22 * rows;
}
