"""Step a mission by hand and look into it after each step."""

import numpy as np

import swarmscout as ss

STEPS = 100

mission = ss.Mission(ss.Scenario(world="lava-tube-small", robots=8, steps=STEPS), seed=3)
while not mission.done:
    mission.step()
    if mission.step_number % 20 == 0:
        x_m, y_m, heading_rad = mission.bodies.pose[0]  # The truth; robots do not see it.
        leaders = np.unique(mission.minds.leader)
        print(
            f"step {mission.step_number:3}: {mission.explored_m2:5.1f} m², "
            f"{len(mission.map.frontiers())} frontier cells, leaders {leaders.tolist()}, "
            f"robot 0 at ({x_m:.1f}, {y_m:.1f}) heading {np.degrees(heading_rad):.0f}°"
        )
print(f"ended: {mission.end_reason}")
