"""The paper to the letter, and with the repairs that docs/paper.md explains."""

import swarmscout as ss

STEPS = 300

for name in ("paper-literal", "paper"):
    scenario = ss.load_scenario(name, {"steps": STEPS, "seed": 4})
    run = ss.record_mission(scenario, record="curves")
    print(f"{name:14} {run.summary['explored_m2']:6.1f} m²; {scenario.renewal.rule} destinations")
