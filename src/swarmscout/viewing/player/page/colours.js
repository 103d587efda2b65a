// Colours: the palettes of viewing/palette.py, and a hue for each team.

import { PALETTES } from "./palette.js";

export const THEMES = PALETTES;

/** A colour as [red, green, blue] from 0 to 255. */
export function rgb(colour) {
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
}

/** A team's colour, from its leader: it stays while teams grow. */
export function teamColour(leader, dark) {
  const hue = (leader * 137.508 + 20) % 360;
  // With commas: three.js reads no other form.
  return `hsl(${hue.toFixed(1)}, ${dark ? 75 : 70}%, ${dark ? 64 : 42}%)`;
}

/** A robot's colour: by mode as in the paper, or by team. */
export function robotColour(robot, theme, byTeam, dark) {
  if (!robot.alive) return theme.stranded;
  if (byTeam && !robot.charging) return teamColour(robot.leader, dark);
  return robot.charging ? theme.charge : theme.explore;
}
