"""Checks for other people's parts, and small worlds and views to try them in."""

from swarmscout.testing.check_policy import PolicyReport, check_policy
from swarmscout.testing.check_selector import SelectorReport, check_selector
from swarmscout.testing.check_world_reader import WorldReaderReport, check_world_reader
from swarmscout.testing.situations import Situation, leader_view, situations
from swarmscout.testing.small_worlds import small_world

__all__ = [
    "PolicyReport",
    "SelectorReport",
    "Situation",
    "WorldReaderReport",
    "check_policy",
    "check_selector",
    "check_world_reader",
    "leader_view",
    "situations",
    "small_world",
]
