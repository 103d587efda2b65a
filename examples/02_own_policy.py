"""A policy of your own: the desired team size of each robot, in one call per step."""

from dataclasses import dataclass

import numpy as np

import swarmscout as ss

STEPS = 200


@dataclass(frozen=True)
class OpenGround:
    """Single robots where many frontier cells are near, else teams of three."""

    reach_m: float = 5.0
    many: int = 20

    def desired(self, view):
        near = view.frontiers_within(self.reach_m)  # int[N], what each robot's own map shows.
        return np.where(near >= self.many, 1, 3)


for name, policy in {"by-mode": "by-mode", "5 m": OpenGround, "10 m": OpenGround(10.0)}.items():
    teams = {"policy": policy, "leave_rule": "general"}
    run = ss.explore(robots=15, steps=STEPS, teams=teams, seed=0)
    print(f"{run.summary['explored_m2']:6.1f} m², {run.summary['joins']} joins, {name}")
