"""A study's progress: rate, time left, and what is known so far."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from swarmscout.studies.plan import Planned
    from swarmscout.studies.progress import SoFar
    from swarmscout.studies.worker import Outcome

__all__ = ["StudyProgress"]

_REDRAW_S = 0.25
_LINE_S = 10.0


class StudyProgress:
    """On a terminal a bar and a live table; elsewhere a line now and then.

    Args:
        known: the counts.
        axis: the compared axis' name.
        baseline: the label that others are compared to.
    """

    def __init__(self, known: SoFar, axis: str, baseline: str) -> None:
        self._known = known
        self._axis = axis
        self._baseline = baseline
        self._live: Any = None
        self._began = time.monotonic()
        self._first = 0
        self._next = 0.0 if sys.stdout.isatty() else self._began + _LINE_S

    def __enter__(self) -> StudyProgress:
        """Begin to show."""
        if sys.stdout.isatty() and self._known.todo:
            from rich.live import Live

            self._live = Live(self._table(), refresh_per_second=4, transient=True)
            self._live.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Take the live table away."""
        if self._live is not None:
            self._live.stop()

    def count(self, mission: Planned, outcome: Outcome) -> None:
        """Count a mission that has ended, and show it when it is time to."""
        self._known.count(mission, outcome)
        now = time.monotonic()
        if self._known.ended == 1:
            self._began, self._first = now, 1
        if now < self._next:
            return
        if self._live is not None:
            self._next = now + _REDRAW_S
            self._live.update(self._table())
        else:
            self._next = now + _LINE_S
            print(self._line(), flush=True)

    def _line(self) -> str:
        known = self._known
        # The first missions wait for processes to start and worlds to be made: count from there.
        seconds = time.monotonic() - self._began
        rate = (known.ended - self._first) / seconds if seconds > 0.0 else 0.0
        words = [f"{known.ended} of {known.todo} missions", f"{rate:.1f} per second"]
        if rate > 0.0:
            words.append(f"{_clock((known.todo - known.ended) / rate)} left")
        if known.failed:
            words.append(f"{known.failed} failed")
        return ", ".join(words)

    def _table(self) -> Any:
        from rich.table import Table

        table = Table(title=self._line(), title_justify="left", box=None, padding=(0, 2))
        for name in (self._axis, "missions", "explored m²", f"times {self._baseline}, so far"):
            table.add_column(name, justify="left" if name == self._axis else "right")
        for label, area in self._known.areas.items():
            ratio = self._known.ratios[label]
            spread = f" ± {ratio.error:.2f}" if ratio.n > 1 else ""
            table.add_row(
                label,
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
