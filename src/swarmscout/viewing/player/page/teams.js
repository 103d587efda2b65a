// Teams as they stand at a moment: who belongs together, where, and where they are heading.

/** Teams of exploring robots: `{number, leader, members, x, y, radius, destination}`. */
export function teamsOf(robots) {
  const teams = new Map();
  for (const robot of robots) {
    if (!robot.alive || robot.charging) continue;
    const team = teams.get(robot.team);
    if (team) team.members.push(robot);
    else teams.set(robot.team, { number: robot.team, leader: robot.leader, members: [robot] });
  }
  for (const team of teams.values()) {
    const { members } = team;
    team.x = members.reduce((sum, robot) => sum + robot.x, 0) / members.length;
    team.y = members.reduce((sum, robot) => sum + robot.y, 0) / members.length;
    team.radius = Math.max(...members.map((robot) => Math.hypot(robot.x - team.x, robot.y - team.y)));
    const leader = members.find((robot) => robot.robot === team.leader) ?? members[0];
    team.destination = leader.destination;
    team.head = leader;
  }
  return [...teams.values()];
}
