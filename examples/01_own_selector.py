"""A selector of your own: a class with one method, choose(view, memory)."""

from dataclasses import dataclass

import swarmscout as ss
from swarmscout.destinations.selector import Choice

STEPS = 200


@dataclass(frozen=True)
class Apart:
    """The nearest frontier by route that is not close to another team's destination."""

    apart_m: float = 5.0

    def choose(self, view, memory):
        cost = view.route_costs()  # One cost per frontier cell, in metres of easy ground.
        for x_m, y_m in view.others.destinations_m:
            dx, dy = (view.frontiers_m - (x_m, y_m)).T
            cost = cost + 3 * self.apart_m * (dx**2 + dy**2 < self.apart_m**2)
        row, col = view.frontiers[cost.argmin()].tolist()
        return Choice((row, col), reason=f"cost {cost.min():.1f}")


for name in (Apart, "nearest", "random"):
    run = ss.explore(robots=15, steps=STEPS, destinations=name, seed=0)
    print(f"{run.summary['selector']:14} {run.summary['explored_m2']:6.1f} m²")
print(run.decisions.select("step", "leader", "reason").head(3))
