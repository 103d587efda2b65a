"""Limited communication: each robot hears its neighbours in a chain and keeps its own map."""

import numpy as np

import swarmscout as ss

STEPS = 120
ROBOTS = 6

# links[i, j]: robot i hears robot j.
chain = np.eye(ROBOTS, k=1, dtype=bool) | np.eye(ROBOTS, k=-1, dtype=bool)


def cut_in_the_middle(step):
    links = chain.copy()
    if step % 40 > 20:  # The chain is broken half of the time.
        links[2, 3] = links[3, 2] = False
    return links


for name, links in (("full", None), ("chain", lambda step: chain), ("cut", cut_in_the_middle)):
    run = ss.explore("lava-tube-small", robots=ROBOTS, steps=STEPS, links=links)
    print(f"{name:6} {run.summary['explored_m2']:5.1f} m², own maps: {run.own_maps}")
