"""A study's progress: rate, time left, and means so far."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from swarmscout.studies.plan import PlannedMission
    from swarmscout.studies.progress import RunningTotals
    from swarmscout.studies.worker import Outcome

__all__ = ["StudyProgress"]

_REDRAW_S = 0.25
_LINE_S = 10.0


class StudyProgress:
    """On a terminal a live table; elsewhere a line every few seconds.

    Args:
        totals: the counts.
        axis: name of the compared axis.
        baseline: the label that others are compared with.
    """

    def __init__(self, totals: RunningTotals, axis: str, baseline: str) -> None:
        self._totals = totals
        self._axis = axis
        self._baseline = baseline
        self._live: Any = None
        self._began = time.monotonic()
        self._first = 0
        self._next = 0.0 if sys.stdout.isatty() else self._began + _LINE_S

    def __enter__(self) -> StudyProgress:
        """Begin to show."""
        if sys.stdout.isatty() and self._totals.todo:
            from rich.live import Live

            self._live = Live(self.table(), refresh_per_second=4, transient=True)
            self._live.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Remove the live table."""
        if self._live is not None:
            self._live.stop()

    def count(self, mission: PlannedMission, outcome: Outcome) -> None:
        """Count a mission that has ended, and show the counts when they are due."""
        self._totals.count(mission, outcome)
        now = time.monotonic()
        if self._totals.ended == 1:
            self._began, self._first = now, 1
        if now < self._next:
            return
        if self._live is not None:
            self._next = now + _REDRAW_S
            self._live.update(self.table())
        else:
            self._next = now + _LINE_S
            print(self._line(), flush=True)

    def _line(self) -> str:
        totals = self._totals
        # The first missions wait for processes and worlds: the rate leaves them out.
        seconds = time.monotonic() - self._began
        rate = (totals.ended - self._first) / seconds if seconds > 0.0 else 0.0
        words = [f"{totals.ended} of {totals.todo} missions", f"{rate:.1f} per second"]
        if rate > 0.0:
            words.append(f"{_clock((totals.todo - totals.ended) / rate)} left")
        if totals.failed:
            words.append(f"{totals.failed} failed")
        return ", ".join(words)

    def table(self) -> Any:
        """The counts as a table that folds long labels on narrow terminals."""
        from rich.table import Table
        from rich.text import Text

        # Labels are the user's text, not markup.
        table = Table(title=Text(self._line()), title_justify="left", box=None, padding=(0, 1))
        for name in (self._axis, "missions", "explored m²", f"times {self._baseline}, so far"):
            side = "left" if name == self._axis else "right"
            table.add_column(Text(name), justify=side, overflow="fold")  # type: ignore[arg-type]
        for label, area in self._totals.areas.items():
            ratio = self._totals.ratios[label]
            spread = f" ± {ratio.error:.2f}" if ratio.n > 1 else ""
            table.add_row(
                Text(label),
                str(area.n),
                f"{area.mean:.1f}" if area.n else "",
                f"{ratio.mean:.2f}{spread}" if ratio.n else "",
            )
        return table


def _clock(seconds: float) -> str:
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02d} min"
    return f"{minutes} min {seconds:02d} s" if minutes else f"{seconds} s"
