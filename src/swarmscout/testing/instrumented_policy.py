"""Asking a policy while watching what it reads, draws and changes."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import PolicyError
from swarmscout.core.tracebacks import describe_error
from swarmscout.teams.desired_size import checked_sizes
from swarmscout.teams.policy import LARGEST, DesiredSizePolicy
from swarmscout.teams.robots_view import RobotsView
from swarmscout.testing.fingerprints import (
    fingerprint,
    global_states,
    held_by,
    seeded_globals,
    writes_read_only,
)

__all__ = ["answered"]

_OF_THE_VIEW = {RobotsView.__module__, __name__}
_CLOCKS = ("time", "monotonic", "perf_counter", "process_time")
_LATER_S = 86_461.7


class _WatchedView(RobotsView):
    """A view that notes who reads its private attributes, and may show other rows but for one."""

    __slots__ = ("mixed", "private_reads")

    def __init__(self, view: RobotsView, mixed: tuple[int, RobotsView] | None) -> None:
        super().__init__(view._minds, view._knowledge, view.step, view.desired_size)
        self.mixed = mixed
        self.private_reads: list[str] = []

    def __getattribute__(self, name: str) -> Any:
        value = object.__getattribute__(self, name)
        theirs = sys._getframe(1).f_globals.get("__name__") not in _OF_THE_VIEW
        if theirs and name.startswith("_") and not name.startswith("__"):
            self.private_reads.append(name)
        mixed = object.__getattribute__(self, "mixed") if theirs else None
        if mixed is None or name.startswith("_"):
            return value
        robot, other = mixed
        elsewhere = getattr(other, name)
        if callable(value):
            return lambda *given, **named: _mix(
                value(*given, **named), elsewhere(*given, **named), robot
            )
        return _mix(value, elsewhere, robot)


def _mix(mine: Any, theirs: Any, robot: int) -> Any:
    if not isinstance(mine, np.ndarray):
        return mine
    rows = np.array(theirs)
    rows[robot] = mine[robot]
    rows.flags.writeable = False
    return rows


def answered(
    policy: DesiredSizePolicy,
    view: RobotsView,
    mixed: tuple[int, RobotsView] | None = None,
    *,
    once: bool = False,
) -> NDArray[np.int64]:
    """A policy's answer, when it keeps to its contract.

    Args:
        policy: whom to ask.
        view: what it shall see.
        mixed: a robot and another view: all rows but the robot's are taken from there.
        once: ask once; otherwise again with another clock and other global randomness.

    Raises:
        PolicyError: what is wrong; the message starts with a verb.
    """
    sizes = _asked(policy, view, mixed, globals_seed=1)
    if once:
        return sizes
    if not np.array_equal(_asked(policy, view, mixed, globals_seed=1), sizes):
        raise PolicyError(
            "is not deterministic: it gave two different answers to the same view; what it may "
            "remember is view.previous"
        )
    if not np.array_equal(_asked(policy, view, mixed, globals_seed=1, later_s=_LATER_S), sizes):
        raise PolicyError("depends on the clock: use view.step")
    if not np.array_equal(_asked(policy, view, mixed, globals_seed=2), sizes):
        raise PolicyError(
            "depends on global randomness: its answer changes with the seed of random or "
            "numpy.random"
        )
    return sizes


def _asked(
    policy: DesiredSizePolicy,
    view: RobotsView,
    mixed: tuple[int, RobotsView] | None,
    *,
    globals_seed: int,
    later_s: float = 0.0,
) -> NDArray[np.int64]:
    shown = _WatchedView(view, mixed)
    seen, itself = _look(view), held_by(policy)
    with seeded_globals(globals_seed), _clocks(later_s):
        before = global_states()
        try:
            answer = policy.desired(shown)
        except Exception as error:
            if _is_change_of_view(error):
                raise PolicyError(
                    f"tries to change its view, which is read-only ({error}); work on a copy"
                ) from error
            raise PolicyError(f"failed: {describe_error(error)}") from error
        drawn = [name for name, state in global_states().items() if state != before[name]]
    if shown.private_reads:
        raise PolicyError(
            f"reads '{shown.private_reads[0]}' of its view, which is private: what is not public "
            "in a view cannot be used"
        )
    if drawn:
        raise PolicyError(
            f"draws from the global generator of {drawn[0]}: a policy draws nothing, since the "
            "same robots in the same place want the same"
        )
    if _look(view) != seen:
        raise PolicyError("changed its view, which is read-only; work on a copy")
    changed = sorted(name for name, value in held_by(policy).items() if itself.get(name) != value)
    if changed:
        raise PolicyError(
            f"changed itself (attribute '{changed[0]}'): a policy is one for all robots; what it "
            "may remember is view.previous"
        )
    return _possible(answer, len(view))


def _possible(answer: Any, robots: int) -> NDArray[np.int64]:
    sizes = checked_sizes(answer, robots)
    wrong = np.flatnonzero((sizes < 1) | (sizes > LARGEST))
    if len(wrong):
        raise PolicyError(
            f"answered {sizes[wrong[0]]} for robot {wrong[0]}: expected 1 to {LARGEST:,}"
        )
    return sizes.copy()


@contextmanager
def _clocks(later_s: float) -> Iterator[None]:
    """Put the clocks forward, and back afterwards."""
    clocks = {name: getattr(time, name) for name in _CLOCKS}
    try:
        for name, clock in clocks.items():
            setattr(time, name, _later(clock, later_s))
        yield
    finally:
        for name, clock in clocks.items():
            setattr(time, name, clock)


def _later(clock: Callable[[], float], by_s: float) -> Callable[[], float]:
    return lambda: clock() + by_s


def _look(view: RobotsView) -> list[Any]:
    minds, knowledge = view._minds, view._knowledge
    held = (minds.own, knowledge.heard, knowledge.still)
    return [fingerprint(array) for array in held]


def _is_change_of_view(error: Exception) -> bool:
    if isinstance(error, AttributeError):
        return "no setter" in str(error)
    return writes_read_only(error)
