"""The events of a step: what happened to which robot, written by kernels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import EVENTS
from swarmscout.core.jit import inlined

__all__ = ["EVENT", "EventLog", "note"]

EVENT = np.dtype([("kind", "i8"), ("robot", "i8"), ("other", "i8"), ("value", "i8")], align=True)
"""One event; what `other` and `value` mean depends on the kind, see ``core.enums``."""


@inlined
def note(events, kind, robot, other, value):  # type: ignore[no-untyped-def]
    """Append an event. A full log counts it and does not write it, see :class:`EventLog`."""
    n = events[0].value + 1
    events[0].value = n
    if n < events.shape[0]:
        events[n].kind = kind
        events[n].robot = robot
        events[n].other = other
        events[n].value = value


class EventLog:
    """Events of one step, in the order in which they happened.

    Attributes:
        rows: EVENT[capacity + 1]; the first row's `value` counts the events, which follow it. One
            array holds both, so that kernels can check the capacity.

    Args:
        robots: N. In a step each robot causes at most one event of each kind.
    """

    def __init__(self, robots: int) -> None:
        self.rows = np.zeros(len(EVENTS) * robots + 1, dtype=EVENT)

    def clear(self) -> None:
        """Begin a new step."""
        self.rows[0]["value"] = 0

    @property
    def entries(self) -> NDArray[np.int64]:
        """int64[k, 4]: kind, robot, other and value of each event.

        Raises:
            RuntimeError: kernels counted more events than fit, which is a defect.
        """
        count = int(self.rows[0]["value"])
        if count >= len(self.rows):
            raise RuntimeError(f"{count} events in one step, room for {len(self.rows) - 1}")
        return self.rows[1 : count + 1].view(np.int64).reshape(-1, 4)
