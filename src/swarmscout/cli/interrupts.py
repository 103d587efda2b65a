"""Ctrl-C and SIGTERM: ending cleanly, at once outside a mission and between two steps inside."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

__all__ = ["Interrupted", "between_steps", "interruptible"]

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


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

    Libraries that are being imported may turn it into an error of their own: once a signal has
    arrived, whatever error follows means that it was heard.
    """
    arrived: list[int] = []

    def stop(number: int, _: FrameType | None) -> None:
        arrived.append(number)
        raise Interrupted(number)

    try:
        with _installed(stop):
            yield
    except Exception:
        if arrived:
            raise Interrupted(arrived[0]) from None
        raise


@contextmanager
def between_steps() -> Iterator[Callable[[], None]]:
    """A first SIGINT or SIGTERM waits until the mission's step is over; a second one does not.

    Yields:
        What is to be called after each step: it raises :class:`Interrupted` when a signal waits.
    """
    waiting: list[int] = []

    def stop(number: int, _: FrameType | None) -> None:
        if waiting:
            raise Interrupted(number)
        waiting.append(number)

    def check() -> None:
        if waiting:
            raise Interrupted(waiting[0])

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
