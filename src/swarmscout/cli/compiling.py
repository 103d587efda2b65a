"""Kernels: which are compiled, compiling all of them, and problems of their cache."""

from __future__ import annotations

import inspect
import os
import pickle
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from traceback import walk_tb
from typing import Any

__all__ = [
    "cache_folders",
    "cache_problem",
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


def cache_problem(error: Exception) -> str:
    """What is wrong with the cache of compiled kernels if an error arose there, else nothing.

    A damaged cache (a power cut, a full disk, an interrupted copy) is emptied: it is rebuilt when
    kernels are used again.
    """
    files = [frame.f_code.co_filename for frame, _ in walk_tb(error.__traceback__)]
    if not any(Path(file).parts[-3:] == ("numba", "core", "caching.py") for file in files):
        return ""
    where = f"the cache of compiled kernels in '{Path(os.path.commonpath(cache_folders()))}'"
    if isinstance(error, OSError):
        return f"{where}: {error.strerror or error}: make room, or set NUMBA_CACHE_DIR to another"
    for folder in cache_folders():
        for file in [*folder.glob("*.nbi"), *folder.glob("*.nbc")]:
            file.unlink(missing_ok=True)
    return f"{where} was damaged and has been emptied: run the command again"


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

    return [name for name, compiled in kernels.items() if not _is_cached(compiled)]


def cache_folders() -> list[Path]:
    """The folders in which Numba keeps the imported kernels."""
    from swarmscout.core.jit import kernels

    return sorted({Path(compiled.stats.cache_path) for compiled in kernels.values()})


def _is_cached(compiled: Any) -> bool:
    """Whether Numba's cache holds a kernel as its source is now."""
    try:
        # Numba compares the source's stamp itself; it says so nowhere in public.
        return bool(compiled._cache._cache_file._load_index())
    except (EOFError, pickle.UnpicklingError, OSError):
        return False  # Damaged.
    except AttributeError:
        source = Path(inspect.getfile(compiled.py_func))
        python = f"py{sys.version_info.major}{sys.version_info.minor}"
        pattern = f"{source.stem}.{compiled.py_func.__qualname__}-*.{python}*.nbi"
        return any(Path(compiled.stats.cache_path).glob(pattern))
