"""Batteries: how capacity and the rule for returning change a mission."""

import swarmscout as ss

STEPS = 300

BATTERIES = {
    "off": {"enabled": False},
    "default": {},
    "small": {"capacity_steps": 150},
    "small, returns in time": {"capacity_steps": 150, "return_rule": "distance"},
}
for name, battery in BATTERIES.items():
    run = ss.explore(robots=10, steps=STEPS, battery=battery, record="summary")
    figures = run.summary
    print(
        f"{name:22} {figures['explored_m2']:6.1f} m², {figures['charges']} charges, "
        f"{figures['stranded']} robots stranded"
    )
