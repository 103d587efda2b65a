"""A radio of your own: a class with one method, links(step, bodies, world)."""

from dataclasses import dataclass

import swarmscout as ss
from swarmscout.testing import check_radio

STEPS = 150


@dataclass(frozen=True)
class SameSide:
    """Robots hear each other if they are on the same side of a line."""

    x_m: float = 10.0

    def links(self, step, bodies, world):
        side = bodies.position[:, 0] > self.x_m
        return side[:, None] == side[None, :]  # [i, j]: robot i hears robot j


check_radio(SameSide, missions=0)
scenario = ss.Scenario(robots=8, steps=STEPS, world="lava-tube-small")
near = ss.Scenario(robots=8, steps=STEPS, world="lava-tube-small", radio={"model": "disc"})
for name, mission in (
    ("full", ss.Mission(scenario)),
    ("disc", ss.Mission(near)),
    ("same side", ss.Mission(scenario, radio=SameSide())),
):
    explored_m2 = mission.run()["explored_m2"]
    print(f"{name:9} {explored_m2:6.1f} m², {len(mission.knowledge.rows)} group(s) at the end")
