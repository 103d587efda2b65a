"""What a scenario says of batteries, as the rules by which robots return to charge."""

from __future__ import annotations

from dataclasses import replace

from swarmscout.mission.scenario import Scenario
from swarmscout.planning.docking import ChargingRules

__all__ = ["make_charging"]

STEPS_PER_METRE = 1.55
"""Moves that a metre of planned way takes, in units of a straight drive: turns and detours."""

RESERVE_STEPS = 40.0
"""Steps to spare, …"""

CROWD_STEPS = 0.4
"""… and for each robot of the swarm, up to `CROWD`: they meet on the way and at the station."""

CROWD = 120


def make_charging(scenario: Scenario) -> ChargingRules:
    """What robots know of their batteries and of stations.

    Under the rule "threshold" the way home does not matter.
    """
    battery = scenario.battery
    steps_per_m = STEPS_PER_METRE / scenario.body.forward_m
    charging = ChargingRules(
        range_m=battery.station_range_m,
        occupied_m=0.75 * battery.capacity_steps / battery.charge_per_step / steps_per_m,
    )
    if battery.return_rule == "threshold" or not battery.enabled:
        return charging
    crowd = CROWD_STEPS * min(scenario.robots, CROWD)
    reserve = min(RESERVE_STEPS + crowd, 0.25 * battery.capacity_steps)
    return replace(
        charging,
        share_per_m=steps_per_m / battery.capacity_steps,
        share_reserve=reserve / battery.capacity_steps,
    )
