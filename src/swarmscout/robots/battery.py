"""Charge: spent with every step, refilled near a station (paper, "Task description")."""

from __future__ import annotations

from swarmscout.core.enums import STRANDED
from swarmscout.core.jit import kernel

__all__ = ["spend_or_charge"]


@kernel
def spend_or_charge(  # type: ignore[no-untyped-def]
    position, charge, alive, docking, stations, capacity, per_step, reach, events, count
):
    """One step's charge for all robots.

    A robot that wants to charge (`docking`) and is near a station gains; any other robot spends
    one step's charge. A robot with nothing left is stranded: it stays where it is for good.

    Args:
        position: float64[N, 2]; charge: float64[N] in steps; alive: bool[N]; docking: bool[N].
        stations: float64[k, 2]; capacity, per_step: in steps; reach: metres.
        events: int64[cap, 4] and count: int64[1], see ``core.codes``.
    """
    for i in range(position.shape[0]):
        if not alive[i]:
            continue
        gains = False
        if docking[i]:
            for s in range(stations.shape[0]):
                dx = position[i, 0] - stations[s, 0]
                dy = position[i, 1] - stations[s, 1]
                if dx * dx + dy * dy <= reach * reach:
                    gains = True
        if gains:
            charge[i] = min(capacity, charge[i] + per_step)
        else:
            charge[i] = max(0.0, charge[i] - 1.0)
            if charge[i] == 0.0:
                alive[i] = False
                events[count[0], 0] = STRANDED
                events[count[0], 1] = i
                events[count[0], 2] = -1
                events[count[0], 3] = -1
                count[0] += 1
