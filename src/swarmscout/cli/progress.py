"""The progress bar of a mission, with its map; nothing where stdout is not a terminal."""

from __future__ import annotations

import sys
import time
from contextlib import ExitStack
from types import TracebackType
from typing import TYPE_CHECKING, Any

from swarmscout.cli.compiling import counting_compiled

if TYPE_CHECKING:
    from rich.progress import TaskID

    from swarmscout.cli.mini_map import ProgressWithMap
    from swarmscout.mission.mission import Mission

__all__ = ["Progress", "state_of"]

_REDRAW_S = 0.1
_FIELDS = ("explored", "teams", "charging")


def state_of(mission: Mission) -> dict[str, Any]:
    """What the bar shows: explored m², number of teams, robots in CHR mode."""
    import numpy as np

    from swarmscout.core.enums import CHARGE

    exploring = mission.bodies.alive & (mission.minds.mode != CHARGE)
    return {
        "explored": f"{mission.explored_m2:.0f} m²",
        "teams": f"{len(np.unique(mission.minds.team[exploring]))} teams",
        "charging": f"{int(np.count_nonzero(mission.minds.mode == CHARGE))} charging",
    }


class Progress:
    """A bar over a mission's steps.

    Args:
        steps: the mission's length.
    """

    def __init__(self, steps: int) -> None:
        self._steps = steps
        self._bar: ProgressWithMap | None = None
        self._task: TaskID | None = None
        self._next = 0.0
        self._compiling = ExitStack()

    def __enter__(self) -> Progress:
        """Draw the bar if stdout is a terminal."""
        if sys.stdout.isatty():
            from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

            from swarmscout.cli.mini_map import ProgressWithMap

            fields = (TextColumn(f"{{task.fields[{name}]}}") for name in _FIELDS)
            self._bar = ProgressWithMap(
                TextColumn("{task.description}"),
                MofNCompleteColumn(),
                BarColumn(),
                *fields,
                TimeRemainingColumn(compact=True),
                refresh_per_second=10,
                transient=True,
            )
            empty: dict[str, Any] = dict.fromkeys(_FIELDS, "")
            self._task = self._bar.add_task("step", total=self._steps, **empty)
            self._bar.start()
            self._compiling.enter_context(counting_compiled(self._compiled))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Remove the bar."""
        self._compiling.close()
        if self._bar is not None:
            self._bar.stop()

    def _compiled(self, count: int) -> None:
        """Show that a kernel has been compiled, in the first steps of a first mission."""
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, description=f"compiled {count} functions, step")

    def say(self, line: str) -> None:
        """Print a line, above the bar where there is one."""
        if self._bar is None:
            print(line, flush=True)
        else:
            self._bar.console.print(line, markup=False, highlight=False)

    def show(self, mission: Mission) -> None:
        """Bring the bar up to date; it costs nothing most of the time."""
        if self._bar is None or self._task is None or time.monotonic() < self._next:
            return
        self._next = time.monotonic() + _REDRAW_S
        self._bar.show_map(mission)
        self._bar.update(
            self._task, completed=mission.step_number, description="step", **state_of(mission)
        )
