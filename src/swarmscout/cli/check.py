"""``swarmscout check``: a plug-in of your own against the contract of its kind."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from swarmscout.core.registry import Registry

__all__ = ["check"]


def check(name: str, /, *, kind: str | None = None) -> None:
    """Check that a selector or a policy keeps its contract, and list what was checked.

    Args:
        name: FILE.py:NAME, or a registered name.
        kind: selector or policy; by default the kind that NAME can be used as.
    """
    from swarmscout.core.errors import SwarmscoutError, did_you_mean
    from swarmscout.destinations.registry import SELECTORS
    from swarmscout.teams.registry import POLICIES
    from swarmscout.testing import check_policy, check_selector

    # One line for each kind of plug-in: its registry, and its check.
    kinds: dict[str, tuple[Registry[Any], Callable[[str], object]]] = {
        "selector": (SELECTORS, check_selector),
        "policy": (POLICIES, check_policy),
    }
    if kind is not None and kind not in kinds:
        raise SwarmscoutError(f"--kind '{kind}': {did_you_mean(kind, kinds)}")
    if ".py" not in name and kind is None:
        registered = {each: one for one, (kept, _) in kinds.items() for each in kept.names()}
        if name not in registered:
            raise SwarmscoutError(f"unknown plug-in '{name}': {did_you_mean(name, registered)}")
        kind = registered[name]
    refusals = []
    for registry, check_it in kinds.values() if kind is None else [kinds[kind]]:
        try:
            registry.make(name)
        except SwarmscoutError as error:
            refusals.append(
                str(error).replace(registry.noun, "plug-in" if kind is None else registry.noun)
            )
        else:
            print(check_it(name))
            return
    raise SwarmscoutError("; ".join(dict.fromkeys(refusals)))
