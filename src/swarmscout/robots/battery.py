"""Charge: spent with every step, refilled near a station (paper, "Task description")."""

from __future__ import annotations

import numpy as np

from swarmscout.core.enums import STRANDED
from swarmscout.core.events import note
from swarmscout.core.jit import kernel

__all__ = ["CHARGER", "spend_or_charge"]

CHARGER = np.dtype(
    [
        ("capacity_steps", "f8"),
        ("charge_per_step", "f8"),
        ("range_m", "f8"),  # this near to a station a robot charges
    ],
    align=True,
)
"""Batteries and stations."""


@kernel
def spend_or_charge(position, charge, alive, can, docking, stations, charger, events):  # type: ignore[no-untyped-def]
    """One step's charge for all robots.

    A robot that wants to charge (`docking`) and is near a station gains; any other robot spends
    one step's charge. A robot with nothing left is stranded: it stays where it is for good.

    Args:
        position: float64[N, 2]; charge: float64[N] in steps; alive: bool[N].
        can: CAPABILITIES[N]; docking: bool[N].
        stations: float64[k, 2]; charger: CHARGER[1]; events: see ``EventLog``.
    """
    charger = charger[0]
    for i in range(position.shape[0]):
        if not alive[i]:
            continue
        gains = False
        if docking[i]:
            for s in range(stations.shape[0]):
                dx = position[i, 0] - stations[s, 0]
                dy = position[i, 1] - stations[s, 1]
                if dx * dx + dy * dy <= charger.range_m * charger.range_m:
                    gains = True
        if gains:
            charge[i] = min(charger.capacity_steps, charge[i] + charger.charge_per_step)
        else:
            charge[i] = max(0.0, charge[i] - 1.0)
            if charge[i] == 0.0:
                alive[i] = False
                can[i].drive = False
                can[i].sense = False
                can[i].send = False
                can[i].think = False
                note(events, STRANDED, i, -1, -1)
