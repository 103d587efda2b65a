"""Conformance checks for plug-ins, and small worlds and views to try them in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from swarmscout.testing.check_policy import check_policy
from swarmscout.testing.check_radio import check_radio
from swarmscout.testing.check_selector import check_selector
from swarmscout.testing.check_sensor import check_sensor
from swarmscout.testing.check_task import check_task
from swarmscout.testing.check_world_reader import check_world_reader
from swarmscout.testing.harness import Guard, Report
from swarmscout.testing.policy_situations import robots_view
from swarmscout.testing.situations import Situation, leader_view, situations
from swarmscout.testing.small_worlds import small_world

__all__ = [
    "CHECKS",
    "Guard",
    "Report",
    "Situation",
    "check_policy",
    "check_radio",
    "check_selector",
    "check_sensor",
    "check_task",
    "check_world_reader",
    "leader_view",
    "robots_view",
    "situations",
    "small_world",
]

CHECKS: Mapping[str, Callable[[Any], Report]] = {
    "selector": check_selector,
    "policy": check_policy,
    "sensor": check_sensor,
    "radio": check_radio,
    "task": check_task,
    "world reader": check_world_reader,
}
"""The conformance check of each kind of plug-in, which takes a plug-in or its name."""
