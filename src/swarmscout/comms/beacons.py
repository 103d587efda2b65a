"""Beacons: what a robot tells the others in each step.

A beacon carries robot, step, pose, charge, and the first columns of its sender's state: team,
leader, mode, team size, desired size, the partner it picks for joining, and destination. Phases
that follow in the same step read what was heard here, the same snapshot for all.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.jit import kernel
from swarmscout.minds.minds import BEACON, STEP, Minds

__all__ = ["exchange_beacons", "hear"]


@kernel
def hear(state, reading, sending, links, heard_state, heard_reading, still, step):  # type: ignore[no-untyped-def]
    """Every listener hears the beacons of those it is linked with, and its own.

    Args:
        state: int64[N, columns]; reading: float64[N, 4]; sending: bool[N].
        links: bool[N, N], who hears whom; not read if there is one shared listener.
        heard_state: int64[K, N, BEACON]; heard_reading: float64[K, N, 4]; still: int64[K, N].
        step: the current step.
    """
    listeners = heard_state.shape[0]
    for j in range(state.shape[0]):
        if sending[j]:
            state[j, STEP] = step
        for k in range(listeners):
            if not sending[j] or (listeners > 1 and k != j and not links[k, j]):
                # Out of range or out of charge is the same to a listener: as far as it knows, the
                # robot is where it was last heard.
                if heard_state[k, j, STEP] >= 0:
                    still[k, j] += 1
                continue
            dx = reading[j, 0] - heard_reading[k, j, 0]
            dy = reading[j, 1] - heard_reading[k, j, 1]
            # Turning on the spot is standing; noise of a centimetre or two is no motion.
            if dx * dx + dy * dy < 0.0025 and heard_state[k, j, STEP] >= 0:
                still[k, j] += 1
            else:
                still[k, j] = 0
            for c in range(BEACON):
                heard_state[k, j, c] = state[j, c]
            for c in range(4):
                heard_reading[k, j, c] = reading[j, c]


def exchange_beacons(minds: Minds, links: NDArray[np.bool_], step: int) -> None:
    """Phase 3 of a step: beacons flow along this step's links.

    Args:
        minds: written: what each listener has heard.
        links: bool[N, N]; ignored where all share one listener's row.
        step: the current step.
    """
    hear(
        minds.state,
        minds.reading,
        minds.sending,
        links,
        minds.heard_state,
        minds.heard_reading,
        minds.still,
        step,
    )
