"""Kernels: which are compiled already, and compiling all of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

__all__ = [
    "cache_folders",
    "compile_all",
    "counting_compiled",
    "load_kernels",
    "say_if_compiling",
    "uncompiled_kernels",
]


def say_if_compiling() -> None:
    """Print one line when most kernels have yet to be compiled.

    A few may be missing for good: those that no mission with these settings calls.
    """
    from swarmscout.core.jit import kernels

    missing = len(uncompiled_kernels())
    if 2 * missing > len(kernels):
        print(
            f"compiling {missing} kernels: this happens once and takes a minute or less", flush=True
        )


@contextmanager
def counting_compiled(on_count: Callable[[int], object]) -> Iterator[None]:
    """Call a function with the number of kernels compiled so far, whenever one is compiled."""
    from numba.core import event

    class Counter(event.Listener):  # type: ignore[misc]
        count = 0

        def on_start(self, _: Any) -> None:
            pass

        def on_end(self, _: Any) -> None:
            self.count += 1
            on_count(self.count)

    counter = Counter()
    event.register("numba:compile", counter)
    try:
        yield
    finally:
        event.unregister("numba:compile", counter)


def load_kernels() -> int:
    """Import every module that has kernels; return how many kernels there are."""
    from swarmscout.core.jit import kernels
    from swarmscout.destinations.registry import selectors
    from swarmscout.mission.mission import Mission
    from swarmscout.mission.scenario_files import make_scenario

    for name in selectors():
        # A mission that is made and not run loads its selector and all else that it needs.
        Mission(make_scenario({"robots": 1, "steps": 1, "destinations": name}))
    return len(kernels)


def compile_all() -> None:
    """Run short missions, so that every kernel is called once."""
    import numpy as np

    from swarmscout.api import record_mission
    from swarmscout.destinations.registry import selectors
    from swarmscout.mission.mission import Mission
    from swarmscout.mission.scenario_files import load_scenario
    from swarmscout.worlds.arrays import world_from_array
    from swarmscout.worlds.meshes.mesh import Mesh

    for name in selectors():
        Mission(load_scenario("paper", {"robots": 6, "steps": 30, "destinations": name})).run()
    # What the defaults leave out: other rules, robots low on charge, and maps of their own.
    others = {"start": "spread", "battery.start_min": 0.0, "battery.return_rule": "distance"}
    literal = load_scenario("paper-literal", {"robots": 6, "steps": 30, **others})
    crowd = {"robots": 6, "steps": 30, "teams.policy": "by-crowd", "teams.members": "fan"}
    Mission(load_scenario("paper", crowd)).run()
    Mission(load_scenario("paper", {"robots": 6, "steps": 2}), policy=_LooksAtFrontiers()).run()
    record_mission(literal, links=lambda _: np.ones((6, 6), dtype=np.bool_)).map_at(robot=0)
    corners = np.array([[4, 0, -1], [4, 4, -1], [4, 0, 2]], dtype=np.float32)
    wall = Mesh(corners, np.array([[0, 1, 2]], dtype=np.int32))
    room = np.ones((40, 40), dtype=np.uint8)
    world = world_from_array(room, ground_m=np.zeros(room.shape, dtype=np.float32), mesh=wall)
    Mission(load_scenario("paper", {"steps": 2, "sensor.sensing": "mesh"}), world=world).run()


class _LooksAtFrontiers:
    """A policy that asks what no policy of the package asks, and others may."""

    def desired(self, view: Any) -> Any:
        return 1 + view.frontiers_within(2.0)


def uncompiled_kernels() -> list[str]:
    """Names of the kernels that are imported and have no up-to-date file in Numba's cache."""
    from swarmscout.core.jit import kernels

    return [name for name, compiled in kernels.items() if not compiled._cache.is_filled()]


def cache_folders() -> list[Path]:
    """The folders in which Numba keeps the imported kernels."""
    from swarmscout.core.jit import kernels

    return sorted({Path(compiled.stats.cache_path) for compiled in kernels.values()})
