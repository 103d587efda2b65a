"""``swarmscout worlds import`` of a mesh: progress while it works, then what was found."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from swarmscout.worlds.world import World

__all__ = ["stages", "world_of_mesh"]


def world_of_mesh(
    file: Path,
    *,
    up: str | None,
    scale: float | None,
    start_m: Sequence[float] | None,
    roof: bool | None,
    resolution_m: float | None,
    step_height_m: float | None,
    ground_m: float | str | None,
) -> World:
    """Import a mesh with a progress display, and print the report."""
    from swarmscout.cli.compiling import uncompiled_kernels
    from swarmscout.robots.sensors.agreement import sensing_agreement
    from swarmscout.worlds.meshes.importing import import_mesh_with_report

    if any(".meshes." in name for name in uncompiled_kernels()):
        print("compiling: this happens once and takes a minute or less", flush=True)
    with stages() as show:
        world, report = import_mesh_with_report(
            file, up=up, scale=scale, start_m=start_m, roof=roof, resolution_m=resolution_m,
            step_height_m=step_height_m, ground_m=ground_m, progress=show,
        )  # fmt: skip
    for line in report.lines():
        print(line)
    found = sensing_agreement(world)
    print(
        f"exact sensing: {100.0 * found.hits:.1f} % of rays meet a wall in the mesh where they do "
        f"in the raster, or in neither; {100.0 * found.alike:.1f} % measure the same within 0.1 m"
    )
    return world


@contextmanager
def stages() -> Iterator[Callable[[str, float], None]]:
    """Show the stages of some work: a bar each on a terminal, elsewhere a line when one begins.

    Yields:
        A function of the present stage and the share of it that is done, 0 to 1.
    """
    if sys.stdout.isatty():
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

        columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
        with Progress(*columns, transient=True) as bar:
            task = bar.add_task("", total=1.0)
            yield lambda stage, share: bar.update(task, description=stage, completed=share)
        return
    last = ""

    def say(stage: str, _: float) -> None:
        nonlocal last
        if stage != last:
            last = stage
            print(f"{stage} …", flush=True)

    yield say
