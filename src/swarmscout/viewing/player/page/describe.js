// Descriptions of a run, a robot and a point.

import { element } from "./elements.js";

export function aboutRun(mission, missions) {
  if (missions > 1) return "two missions, in step";
  const f = mission.facts;
  return `${f.world} · ${f.selector} · ${f.robots} robots · seed ${f.seed}`;
}

const DOES = { stop: "stands still", forward: "drives forward", left: "turns left", right: "turns right" };

export function stateWords(state, mission) {
  if (state === "recorded") {
    const broken = mission.facts.finished === false;
    return broken ? `not finished: the recording ends at step ${mission.last}` : "";
  }
  if (state === "live") return "running";
  if (state === "waiting") return "connection lost, reconnecting";
  return mission.facts.end_reason ? `finished: ${mission.facts.end_reason}` : "finished";
}

function mode(robot) {
  if (!robot.alive) return "stranded";
  return robot.charging ? "CHR" : "EXP";
}

/** A robot's state as nodes: words and, in bold, numbers. */
export function aboutRobot(mission, robot, moment) {
  if (!robot) return ["Select a robot: click it, type its number, or press n."];
  const bold = (text) => element("b", {}, text);
  const team = moment.teams.find((one) => one.number === robot.team && !robot.charging);
  const nodes = [
    bold(mode(robot)), " at ", bold(`${robot.x.toFixed(2)}, ${robot.y.toFixed(2)} m`),
    `, charge `, bold(`${Math.round(100 * robot.charge)} %`),
    `, ${DOES[mission.facts.words.action[robot.action]] ?? ""}`,
  ];
  if (robot.contact) nodes.push(`, touches a ${mission.facts.words.contact[robot.contact]}`);
  if (team && team.members.length > 1) {
    const size = team.members.length;
    if (team.leader === robot.robot) nodes.push(", leads ", bold(`a team of ${size}`));
    else nodes.push(", follows robot ", bold(`${team.leader}`), ` in a team of ${size}`);
  } else if (robot.alive && !robot.charging) nodes.push(", alone");
  if (robot.destination >= 0 && !robot.charging && robot.alive) {
    const [x, y] = mission.centre(robot.destination);
    nodes.push(`, drives to `, bold(`${x.toFixed(1)}, ${y.toFixed(1)} m`));
  }
  return nodes;
}

/** A robot in a few lines, for the tip beside the pointer. */
export function robotTip(mission, robot, teams) {
  const team = teams.find((one) => one.number === robot.team && !robot.charging);
  const size = team ? team.members.length : 1;
  const lines = [
    `robot ${robot.robot} · ${mode(robot)} · charge ${Math.round(100 * robot.charge)} %`,
    `${robot.x.toFixed(2)}, ${robot.y.toFixed(2)} m`,
  ];
  if (size > 1) lines.push(`team of ${size}, led by robot ${robot.leader}`);
  return lines.join("\n");
}

/** A map cell in a line. */
export function cellTip(mission, x, y) {
  const cell = mission.cellAt(x, y);
  const where = `${x.toFixed(1)}, ${y.toFixed(1)} m`;
  if (cell < 0) return where;
  const label = ["unknown", "free", "occupied"][mission.labels[cell]];
  const p = 1 / (1 + Math.exp(-mission.logOdds[cell] / 1000));
  return `${where}\n${label}, p(occupied) = ${p.toFixed(2)}`;
}
