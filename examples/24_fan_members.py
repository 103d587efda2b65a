"""Members that fan out: each takes a frontier cell of its own near the team's destination."""

import swarmscout as ss

STEPS = 200

for members in ("shared", "fan"):
    teams = {"desired_size": 4, "members": members, "fan_m": 5.0}
    run = ss.explore(robots=16, steps=STEPS, teams=teams, record="summary")
    figures = run.summary
    print(f"{members:6} {figures['explored_m2']:6.1f} m², {figures['blocked_share']:.1%} blocked")
