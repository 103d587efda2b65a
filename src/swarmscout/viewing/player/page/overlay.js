// What is drawn over the cave and over the map alike: stations, teams, leaders, destinations, rays, routes.

import { raysOf, routeOf } from "./sensing.js";
import { robotColour, teamColour } from "./colours.js";

const TURN = 2 * Math.PI;

/**
 * Draw a moment of a mission.
 *
 * @param ctx a 2D context, in CSS pixels.
 * @param view `at(x, y, level)`: pixels [px, py] of a point on the floor, or as high as the floor at another point
 *   `level`, or null; `scale(x, y)`: pixels per metre there.
 * @param moment `{mission, robots, teams, time}`.
 * @param look `{theme, dark, byTeam, selected, followed, dots}`; `dots`: draw robots too.
 */
export function drawOverlay(ctx, view, moment, look) {
  const { mission, robots, teams } = moment;
  ctx.save();
  // Where a processor draws, outlines cost most of a frame, those with round joins and caps several times as much as
  // plain ones; a larger disc under a small one makes a rim for less than a stroke.
  ctx.lineJoin = "bevel";
  for (const station of mission.facts.stations_m) drawStation(ctx, view, station, look);
  for (const team of teams) drawDestination(ctx, view, mission, team, look);
  const selected = robots[look.selected];
  if (selected) drawSelected(ctx, view, moment, selected, look);
  for (const team of teams) if (team.members.length > 1) drawTeam(ctx, view, team, look);
  if (look.dots) drawDots(ctx, view, mission, robots, look);
  for (const team of teams) if (team.members.length > 1) drawLeader(ctx, view, mission, team, look);
  if (selected) drawName(ctx, view, selected, look);
  ctx.restore();
}

/** A closed, level line round a point of the floor. */
function circle(ctx, view, x, y, radius) {
  const pixels = radius * view.scale(x, y);
  const points = Math.max(14, Math.min(64, Math.round(5 * Math.sqrt(pixels))));
  ctx.beginPath();
  for (let i = 0; i < points; i++) {
    const angle = (i / points) * TURN;
    const at = view.at(x + radius * Math.cos(angle), y + radius * Math.sin(angle), [x, y]);
    if (!at) return false;
    if (i) ctx.lineTo(...at);
    else ctx.moveTo(...at);
  }
  ctx.closePath();
  return true;
}

function line(ctx, view, points) {
  ctx.beginPath();
  let down = false;
  for (const [x, y] of points) {
    const at = view.at(x, y);
    if (!at) down = false;
    else if (down) ctx.lineTo(...at);
    else {
      ctx.moveTo(...at);
      down = true;
    }
  }
  ctx.stroke();
}

export function dot(ctx, x, y, radius) {
  ctx.beginPath();
  ctx.arc(x, y, radius, 0, TURN);
  ctx.fill();
}

function drawStation(ctx, view, [x, y], look) {
  const at = view.at(x, y);
  if (at) drawPlus(ctx, ...at, Math.max(5.5, Math.min(14, 0.45 * view.scale(x, y))), look.theme);
}

/** A plus on a disc. */
export function drawPlus(ctx, x, y, size, theme) {
  ctx.fillStyle = theme.charge;
  ctx.strokeStyle = theme.halo;
  ctx.lineWidth = 2;
  ctx.beginPath();
  ctx.arc(x, y, size, 0, TURN);
  ctx.stroke();
  ctx.fill();
  ctx.lineWidth = Math.max(1.8, size / 3.2);
  ctx.beginPath();
  ctx.moveTo(x - 0.55 * size, y);
  ctx.lineTo(x + 0.55 * size, y);
  ctx.moveTo(x, y - 0.55 * size);
  ctx.lineTo(x, y + 0.55 * size);
  ctx.stroke();
}

/** Eight dots on a circle. */
export function drawDotRing(ctx, x, y, radius, size, colour) {
  ctx.fillStyle = colour;
  for (let i = 0; i < 8; i++) {
    dot(ctx, x + radius * Math.cos((i * TURN) / 8), y + radius * Math.sin((i * TURN) / 8), size);
  }
}

/** Eight dots round the cell (paper, Fig. 9), and a line from the leader to it. */
function drawDestination(ctx, view, mission, team, look) {
  if (team.destination < 0) return;
  const [x, y] = mission.centre(team.destination);
  const chosen = look.selected >= 0 && team.members.some((robot) => robot.robot === look.selected);
  ctx.setLineDash([3, 4]);
  ctx.lineWidth = chosen ? 2 : 1.2;
  ctx.strokeStyle = `${look.theme.destination}80`;
  line(ctx, view, [[team.head.x, team.head.y], [x, y]]);
  ctx.setLineDash([]);
  const at = view.at(x, y);
  if (!at) return;
  const radius = Math.max(5, Math.min(18, 0.8 * mission.frame.cell_m * view.scale(x, y)));
  drawDotRing(ctx, ...at, radius, chosen ? 2.2 : 1.5, look.theme.destination);
}

function drawTeam(ctx, view, team, look) {
  const chosen = team.members.some((robot) => robot.robot === look.selected);
  if (!circle(ctx, view, team.x, team.y, team.radius + 0.45)) return;
  ctx.strokeStyle = look.byTeam ? teamColour(team.leader, look.dark) : `${look.theme.team}b0`;
  if (chosen) ctx.strokeStyle = look.theme.selected;
  ctx.lineWidth = chosen ? 2.4 : 1.4;
  ctx.stroke();
}

export function star(ctx, x, y, size, colour) {
  ctx.beginPath();
  for (let i = 0; i < 10; i++) {
    const r = i % 2 ? 0.45 * size : size;
    const angle = -Math.PI / 2 + (i * Math.PI) / 5;
    ctx.lineTo(x + r * Math.cos(angle), y + r * Math.sin(angle));
  }
  ctx.fillStyle = colour;
  ctx.fill();
}

/** A small star on the leader. */
function drawLeader(ctx, view, mission, team, look) {
  const at = view.at(team.head.x, team.head.y);
  if (!at) return;
  const size = Math.max(3.2, Math.min(9, 0.75 * mission.facts.radius_m * view.scale(team.head.x, team.head.y)));
  star(ctx, ...at, size + 0.8, "rgba(0, 0, 0, 0.75)");
  star(ctx, ...at, size, "#fff");
}

function drawDots(ctx, view, mission, robots, look) {
  for (const robot of robots) {
    const at = view.at(robot.x, robot.y);
    if (!at) continue;
    const radius = Math.max(3.6, mission.facts.radius_m * view.scale(robot.x, robot.y));
    ctx.fillStyle = "rgba(255, 255, 255, 0.9)";
    dot(ctx, ...at, radius + 0.45);
    ctx.fillStyle = robotColour(robot, look.theme, look.byTeam, look.dark);
    dot(ctx, ...at, radius - 0.45);
    const nose = view.at(robot.x + 0.3 * Math.cos(robot.heading), robot.y + 0.3 * Math.sin(robot.heading));
    if (!nose || !robot.alive) continue;
    const length = Math.hypot(nose[0] - at[0], nose[1] - at[1]) || 1;
    ctx.strokeStyle = ctx.fillStyle;
    ctx.lineWidth = Math.max(1.4, radius / 2.2);
    ctx.beginPath();
    ctx.moveTo(...at);
    ctx.lineTo(at[0] + ((nose[0] - at[0]) / length) * radius * 1.9, at[1] + ((nose[1] - at[1]) / length) * radius * 1.9);
    ctx.stroke();
  }
}

/** The selected robot: where it came from, its route, its rays, and a ring. */
function drawSelected(ctx, view, { mission, time }, robot, look) {
  const came = [];
  for (let s = Math.max(0, Math.floor(time) - 40); s <= time; s++) {
    const past = mission.robotAt(robot.robot, s);
    came.push([past.x, past.y]);
  }
  came.push([robot.x, robot.y]);
  ctx.strokeStyle = `${look.theme.selected}73`;
  ctx.lineWidth = 2.5;
  line(ctx, view, came);
  const route = routeOf(mission, robot);
  if (route) {
    ctx.strokeStyle = look.theme.selected;
    ctx.lineWidth = 1.8;
    ctx.setLineDash([1, 5]);
    ctx.lineCap = "round";
    line(ctx, view, [[robot.x, robot.y], ...route.slice(1)]);
    ctx.lineCap = "butt";
    ctx.setLineDash([]);
  }
  ctx.strokeStyle = look.theme.selected;
  ctx.fillStyle = look.theme.selected;
  ctx.lineWidth = 1;
  for (const ray of robot.alive ? raysOf(mission, robot) : []) {
    line(ctx, view, [[robot.x, robot.y], [ray.x, ray.y]]);
    const at = view.at(ray.x, ray.y);
    if (at && ray.hit) dot(ctx, ...at, 2.4);
  }
  const at = view.at(robot.x, robot.y);
  if (!at) return;
  ctx.strokeStyle = look.theme.selected;
  ctx.lineWidth = 2.4;
  ctx.beginPath();
  ctx.arc(...at, Math.max(8, 2 * mission.facts.radius_m * view.scale(robot.x, robot.y)), 0, TURN);
  ctx.stroke();
}

function drawName(ctx, view, robot, look) {
  const at = view.at(robot.x, robot.y);
  if (!at) return;
  const text = `robot ${robot.robot}`;
  ctx.font = "600 12px system-ui, sans-serif";
  ctx.textAlign = "center";
  ctx.lineWidth = 4;
  ctx.strokeStyle = look.theme.halo;
  ctx.fillStyle = look.theme.text;
  ctx.strokeText(text, at[0], at[1] - 15);
  ctx.fillText(text, at[0], at[1] - 15);
}
