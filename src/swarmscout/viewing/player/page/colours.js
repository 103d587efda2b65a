// Colours: the paper's, for both themes, and a hue for each team.

export const THEMES = {
  dark: {
    background: "#0e1115", text: "#e9e5dc", muted: "#8d949d", line: "#2b313a",
    explore: "#ff5d4f", charge: "#2fd07a", stranded: "#7fa3cf", destination: "#b98bff",
    station: "#2fd07a", ring: "rgba(233, 229, 220, 0.55)", ringSelected: "#ffd166",
    link: "rgba(185, 139, 255, 0.5)", ray: "#ffd166", route: "#ffd166", trail: "rgba(255, 209, 102, 0.45)",
    curve: "#ffb35c", ghost: "#6f93c4", second: "#2fd07a", third: "#b98bff", grid: "#232931",
    halo: "rgba(10, 12, 15, 0.85)",
  },
  light: {
    background: "#f4f1ea", text: "#23272c", muted: "#646a72", line: "#d9d3c7",
    explore: "#d7261d", charge: "#00783a", stranded: "#35608f", destination: "#7a2bd6",
    station: "#00783a", ring: "rgba(35, 39, 44, 0.5)", ringSelected: "#b35c00",
    link: "rgba(122, 43, 214, 0.45)", ray: "#b35c00", route: "#b35c00", trail: "rgba(179, 92, 0, 0.4)",
    curve: "#b4540a", ghost: "#5d7fae", second: "#00783a", third: "#7a2bd6", grid: "#e4dfd4",
    halo: "rgba(255, 253, 248, 0.9)",
  },
};

/** The map's colours (paper, Fig. 1): the same in both themes. */
export const MAP = {
  unknown: [158, 158, 158], free: [255, 255, 255], occupied: [0, 0, 0], frontier: [92, 212, 92],
};
/** On the map's white and gray the light theme's colours are legible, whatever the page's theme is. */
export const ON_MAP = THEMES.light;

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
