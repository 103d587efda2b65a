"""``swarmscout worlds import`` of a mesh: progress while it works, then what was found."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.progress import TaskID

    from swarmscout.worlds.world import World

__all__ = ["Stages", "world_of_mesh"]


def world_of_mesh(
    file: Path,
    *,
    up: str | None,
    scale: float | None,
    start_m: Sequence[float] | None,
    roof: bool | None,
    resolution_m: float | None,
    step_height_m: float | None,
) -> World:
    """Import a mesh, show how it goes on, and print the report."""
    from swarmscout.cli.compiling import uncompiled_kernels
    from swarmscout.robots.agreement import sensing_agreement
    from swarmscout.worlds.meshes.importing import import_mesh_with_report

    if any(".meshes." in name for name in uncompiled_kernels()):
        print("compiling: this happens once and takes a minute or less", flush=True)
    with Stages() as stages:
        world, report = import_mesh_with_report(
            file, up=up, scale=scale, start_m=start_m, roof=roof, resolution_m=resolution_m,
            step_height_m=step_height_m, progress=stages.show,
        )  # fmt: skip
    for line in report.lines():
        print(line)
    found = sensing_agreement(world)
    print(
        f"exact sensing: {100.0 * found.hits:.1f} % of rays meet a wall in the mesh where they do "
        f"in the raster, or in neither; {100.0 * found.alike:.1f} % measure the same within 0.1 m"
    )
    return world


class Stages:
    """A bar for each stage of some work on a terminal; elsewhere a line when a stage begins."""

    def __init__(self) -> None:
        self._bar: Any = None
        self._task: TaskID | None = None
        self._stage = ""

    def __enter__(self) -> Stages:
        """Draw the bar when someone sits in front of it."""
        if sys.stdout.isatty():
            from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

            self._bar = Progress(
                TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), transient=True
            )
            self._task = self._bar.add_task("", total=1.0)
            self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.stop()

    def show(self, stage: str, share: float) -> None:
        """Say what is being done, and the share that is done of it, 0 to 1."""
        begins, self._stage = stage != self._stage, stage
        if self._bar is not None:
            self._bar.update(self._task, description=stage, completed=share)
        elif begins:
            print(f"{stage} …", flush=True)
