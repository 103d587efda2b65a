"""Ctrl-C and SIGTERM: ending cleanly, at once outside a mission and between two steps inside."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

__all__ = ["Interrupted", "between_steps", "interruptible"]

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
# Signals that arrived inside the outermost `interruptible`, each of which raised where it arrived.
_arrived: list[int] = []


class Interrupted(BaseException):
    """A signal asked the program to end.

    Attributes:
        signal: the signal's number.
    """

    def __init__(self, signal_number: int, message: str = "") -> None:
        name = "interrupted" if signal_number == signal.SIGINT else "terminated"
        super().__init__(message or name)
        self.signal = signal_number


@contextmanager
def interruptible() -> Iterator[None]:
    """SIGINT and SIGTERM raise :class:`Interrupted` at once.

    What is raised may get lost on its way: a library that is being imported turns it into an error
    of its own or catches it, Python drops it where a callback of the garbage collector ran. So the
    signal is remembered: whatever ends the block then means that it was heard, and
    :func:`between_steps` does not begin.
    """

    def stop(number: int, _: FrameType | None) -> None:
        _arrived.append(number)
        raise Interrupted(number)

    earlier = len(_arrived)
    report = sys.unraisablehook
    sys.unraisablehook = _unless_interrupted(report)
    try:
        with _installed(stop):
            yield
        _raise_if_any(_arrived[earlier:])
    except Exception:
        _raise_if_any(_arrived[earlier:])
        raise
    finally:
        sys.unraisablehook = report
        del _arrived[earlier:]


def _raise_if_any(signals: list[int]) -> None:
    if signals:
        raise Interrupted(signals[0]) from None


def _unless_interrupted(report: Callable[[Any], Any]) -> Callable[[Any], None]:
    """Python's report of errors that it drops, without the interrupts, which are remembered."""

    def only_others(dropped: Any) -> None:
        if not isinstance(dropped.exc_value, Interrupted):
            report(dropped)

    return only_others


@contextmanager
def between_steps() -> Iterator[Callable[[], None]]:
    """A first SIGINT or SIGTERM waits until the mission's step is over; a second one does not.

    Yields:
        What is to be called after each step: it raises :class:`Interrupted` when a signal waits.
    """
    waiting: list[int] = _arrived[:1]

    def stop(number: int, _: FrameType | None) -> None:
        if waiting:
            raise Interrupted(number)
        waiting.append(number)

    def check() -> None:
        _raise_if_any(waiting)

    check()
    with _installed(stop):
        yield check


@contextmanager
def _installed(action: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield  # Python lets only the main thread set what signals do.
        return
    before: dict[signal.Signals, Any] = {number: signal.getsignal(number) for number in _SIGNALS}
    try:
        for number in _SIGNALS:
            # A signal that is ignored (nohup, a job in the background) stays ignored.
            if before[number] is not signal.SIG_IGN:
                signal.signal(number, action)
        yield
    finally:
        for number, previous in before.items():
            signal.signal(number, previous if previous is not None else signal.SIG_DFL)
