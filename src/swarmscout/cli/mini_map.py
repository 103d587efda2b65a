"""A small live map above the progress bar, on terminals with enough lines and true colour."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from rich.console import RenderableType
from rich.progress import Progress

if TYPE_CHECKING:
    from swarmscout.mission.mission import Mission

__all__ = ["ProgressWithMap"]

_LEAST_LINES, _LEAST_COLUMNS = 20, 60
_MOST_LINES = 36
_REDRAW_STEPS = 5


class ProgressWithMap(Progress):
    """A progress bar with the map above it."""

    _map: RenderableType | None = None
    _drawn = -_REDRAW_STEPS

    def show_map(self, mission: Mission) -> None:
        """Draw the map again if some steps have passed and the terminal has room."""
        console = self.console
        width, height = console.size
        if height < _LEAST_LINES or width < _LEAST_COLUMNS or console.color_system != "truecolor":
            self._map = None
        elif mission.step_number >= self._drawn + _REDRAW_STEPS:
            from swarmscout.viewing.half_blocks import half_block_map

            self._drawn = mission.step_number
            self._map = half_block_map(mission, width - 2, min(height - 5, _MOST_LINES))

    def get_renderables(self) -> Iterable[RenderableType]:
        """The map and the bar."""
        if self._map is not None:
            yield self._map
        yield self.make_tasks_table(self.tasks)
