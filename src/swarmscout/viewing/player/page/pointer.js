// The pointer: what it is over, what it selects; and pictures of a view.

import { cellTip, robotTip } from "./describe.js";
import { paintLegend } from "./legend.js";

const NEAR_PIXELS = 13;

/** Hover for details, click to select. */
export function hearPointer(player, view) {
  const sheet = view.sheet.canvas;
  const tip = document.getElementById("tip");
  let pressed = null;
  sheet.addEventListener("pointermove", (event) => {
    if (event.buttons) {
      tip.hidden = true;
      return;
    }
    const moment = player.moment(view.mission);
    const robot = robotUnder(view, moment.robots, event.offsetX, event.offsetY);
    const place = view.toMetres(event.offsetX, event.offsetY);
    const text = robot
      ? robotTip(view.mission, robot, moment.teams)
      : place && view.mission.groundAt ? cellTip(view.mission, ...place) : "";
    sheet.style.cursor = robot ? "pointer" : "";
    tip.hidden = !text;
    tip.textContent = text;
    const left = Math.min(event.clientX + 14, window.innerWidth - tip.offsetWidth - 6);
    const top = Math.min(event.clientY + 14, window.innerHeight - tip.offsetHeight - 6);
    tip.style.left = `${left}px`;
    tip.style.top = `${top}px`;
  });
  sheet.addEventListener("pointerleave", () => (tip.hidden = true));
  sheet.addEventListener("pointerdown", (event) => {
    pressed = [event.clientX, event.clientY];
  });
  sheet.addEventListener("pointerup", (event) => {
    if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;
    const { robots } = player.moment(view.mission);
    player.select(robotUnder(view, robots, event.offsetX, event.offsetY)?.robot ?? -1);
  });
}

function robotUnder(view, robots, px, py) {
  let [best, near] = [null, NEAR_PIXELS];
  for (const robot of robots) {
    const at = view.toPixels(robot.x, robot.y);
    const far = at ? Math.hypot(at[0] - px, at[1] - py) : Infinity;
    if (far < near) [best, near] = [robot, far];
  }
  return best;
}

/** Save the large view as a PNG, with its legend and a title. */
export async function savePicture(player) {
  player.draw();
  const views = document.body.dataset.view === "map" || !player.scenes.length ? player.maps : player.scenes;
  const shown = document.body.dataset.view === "both" ? [...player.scenes, ...player.maps] : views;
  const layers = shown.map((view) => [...view.box.querySelectorAll("canvas")]);
  const height = Math.max(...layers.map(([canvas]) => canvas.height));
  const line = Math.round(34 * shown[0].sheet.ratio);
  const picture = document.createElement("canvas");
  const widths = layers.map(([canvas]) => Math.round((canvas.width * height) / canvas.height));
  picture.width = widths.reduce((sum, width) => sum + width, 0);
  const { ratio } = shown[0].sheet;
  const inner = picture.width / ratio - 24;
  picture.height = height + line + Math.round(ratio * (paintLegend(null, player.look, 0, 0, inner) + 12));
  const ctx = picture.getContext("2d");
  ctx.fillStyle = player.look.theme.background;
  ctx.fillRect(0, 0, picture.width, picture.height);
  let left = 0;
  layers.forEach((canvases, i) => {
    for (const canvas of canvases) ctx.drawImage(canvas, left, 0, widths[i], height);
    left += widths[i];
  });
  ctx.fillStyle = player.look.theme.text;
  ctx.font = `${Math.round(line * 0.42)}px system-ui, sans-serif`;
  ctx.textBaseline = "middle";
  const names = player.missions.map((mission) => mission.facts.name).join(" | ");
  ctx.fillText(`${names} · ${document.getElementById("now").textContent}`, line * 0.4, height + line / 2);
  ctx.scale(ratio, ratio);
  paintLegend(ctx, player.look, 12, (height + line) / ratio, inner);
  const blob = await new Promise((done) => picture.toBlob(done, "image/png"));
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `${player.mission.facts.name}-step-${player.clock.step}.png`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
