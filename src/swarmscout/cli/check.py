"""``swarmscout check``: a plug-in of your own against the contract of its kind."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from swarmscout.core.registry import Registry

__all__ = ["check"]


def check(name: str, /, *, kind: str | None = None) -> None:
    """Check that a plug-in keeps the contract of its kind, and list what was checked.

    Args:
        name: FILE.py:NAME, or a registered name.
        kind: selector, policy, sensor, radio, task or world reader; by default the one that NAME
            can be.
    """
    from swarmscout.core.errors import SwarmscoutError, did_you_mean
    from swarmscout.destinations.registry import SELECTORS
    from swarmscout.robots.radio.registry import RADIOS
    from swarmscout.robots.sensors.registry import SENSORS
    from swarmscout.tasks.registry import TASKS
    from swarmscout.teams.registry import POLICIES
    from swarmscout.testing import CHECKS
    from swarmscout.worlds.readers import READERS

    registries: dict[str, Registry[Any]] = {
        "selector": SELECTORS,
        "policy": POLICIES,
        "sensor": SENSORS,
        "radio": RADIOS,
        "task": TASKS,
        "world reader": READERS,
    }
    if kind is not None and kind not in registries:
        raise SwarmscoutError(f"--kind '{kind}': {did_you_mean(kind, registries)}")
    if ".py" not in name and kind is None:
        registered = {each: one for one, kept in registries.items() for each in kept.names()}
        if name not in registered:
            raise SwarmscoutError(f"unknown plug-in '{name}': {did_you_mean(name, registered)}")
        kind = registered[name]
    if kind is None:
        loaded = SELECTORS.load(name)
        methods = {one: kept.method for one, kept in registries.items()}
        found = [one for one, method in methods.items() if hasattr(loaded, method.split("(")[0])]
        if not found:
            raise SwarmscoutError(
                f"'{name}' is not a plug-in: it has none of the methods "
                f"{', '.join(f'{method} ({one})' for one, method in methods.items())}"
            )
        kind = found[0]
    print(CHECKS[kind](name))
