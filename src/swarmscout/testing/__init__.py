"""Conformance checks for plug-ins, and small worlds and views to try them in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from swarmscout.core.errors import SwarmscoutError, did_you_mean
from swarmscout.testing.check_policy import check_policy
from swarmscout.testing.check_selector import check_selector
from swarmscout.testing.harness import Guard, Report
from swarmscout.testing.policy_situations import robots_view
from swarmscout.testing.situations import Situation, leader_view, situations
from swarmscout.testing.small_worlds import small_world

__all__ = [
    "CHECKS",
    "Guard",
    "Report",
    "Situation",
    "check",
    "check_policy",
    "check_selector",
    "leader_view",
    "robots_view",
    "situations",
    "small_world",
]

CHECKS: Mapping[str, Callable[[Any], Report]] = {
    "selector": check_selector,
    "policy": check_policy,
}
"""The conformance check of each kind of plug-in."""


def check(kind: str, plug_in: Any) -> Report:
    """Check that a plug-in keeps to its kind's contract.

    Args:
        kind: one of :data:`CHECKS`: "selector", "policy".
        plug_in: an instance, a class that needs no arguments, a registered name, or
            ``path/to/file.py:ClassName``.

    Returns:
        What was checked; it can be printed.

    Raises:
        SwarmscoutError: the kind is unknown; or, as the kind's own error, which part of the
            contract is broken, in which situation.

    Example:
        >>> check("policy", "by-mode").name
        'by-mode'
    """
    if kind not in CHECKS:
        raise SwarmscoutError(f"unknown kind of plug-in '{kind}': {did_you_mean(kind, CHECKS)}")
    return CHECKS[kind](plug_in)
