"""What ``swarmscout worlds`` prints and draws of a world."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from swarmscout.worlds.world import World

__all__ = ["draw", "print_hints", "report", "with_inverted_hint"]


def report(world: World, robots: int) -> None:
    """Print area, size, start, stations, and what the reader of the file noted."""
    import numpy as np

    from swarmscout.worlds.placement import place_stations
    from swarmscout.worlds.reachability import reachable
    from swarmscout.worlds.starts import start_of

    left, right, bottom, top = world.extent
    cell_m2 = world.resolution_m**2
    free = float(np.count_nonzero(world.free)) * cell_m2
    reached = float(np.count_nonzero(reachable(world))) * cell_m2
    x, y = start_of(world)
    count = len(place_stations(world, robots))
    print(f"{world.name}: {right - left:.1f} m x {top - bottom:.1f} m at {world.resolution_m:g} m")
    print(f"free: {free:,.1f} m², reachable from the start: {reached:,.1f} m²")
    print(f"start: {x:.2f},{y:.2f} m; charging stations for {robots} robots: {count}")
    if "notes" in world.source:
        print(f"note: {world.source['notes']}")


def print_hints(world: World, robots: int, picture: Path, *, start_given: bool) -> None:
    """Print what may not be as it was meant; a start that is proposed is drawn.

    Args:
        world: a world that was read from a file.
        robots: for how many robots the picture is drawn.
        picture: the file for the picture of a proposed start.
        start_given: whether the user chose the start.
    """
    from swarmscout.core.errors import WorldError
    from swarmscout.worlds.arrays import with_places
    from swarmscout.worlds.hints import inside_hint, inverted_hint

    inside = None if start_given else inside_hint(world)
    if inside is None:
        inverted = inverted_hint(world)
        if inverted is not None:
            print(f"hint: {inverted.text}")
        return
    print(f"hint: {inside.text}")
    try:
        draw(with_places(world, inside.start_m), robots, picture)
    except WorldError as error:
        print(f"no picture of that start: {error}")


def with_inverted_hint(world: World, error: Exception) -> str:
    """The words of an error about a world, and whether the world may be inverted."""
    from swarmscout.worlds.hints import inverted_hint

    hint = inverted_hint(world)
    return str(error) if hint is None else f"{error}; hint: {hint.text}"


def draw(world: World, robots: int, path: Path) -> None:
    """Draw a world into a file and print its name."""
    from swarmscout.viewing.world_picture import world_picture

    print(f"picture: {world_picture(world, path, robots)}")
