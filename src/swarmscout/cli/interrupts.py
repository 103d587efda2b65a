"""Ctrl-C and SIGTERM: end at once outside a mission, after the current step inside one.

A step that takes longer than a second is broken off; a second signal, or three seconds in which
compiled code does not return, end the process.
"""

from __future__ import annotations

import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

__all__ = ["Interrupted", "between_steps", "ending_in_time", "interruptible"]

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_STEP_S = 1.0  # How long a step may go on after a signal.
_STUCK_S = 2.7  # How long compiled code may keep Python from hearing it.
_CLEANUP_S = 10.0  # How long files may be closed after it was heard.
_SECOND_S = 0.3  # How long they may be closed after a second one.
_ECHO_S = 0.25  # ``timeout`` and schedulers signal a process and its group: one signal, sent twice.
# Signals that arrived inside the outermost `interruptible`, each of which raised where it arrived.
_arrived: list[int] = []
_last_s: dict[int, float] = {}  # When each signal arrived last.


class Interrupted(BaseException):
    """A signal asked the program to end.

    Attributes:
        signal: the signal's number.
    """

    heard = False
    """Whether Python has heard any signal in this process."""

    def __init__(self, signal_number: int, message: str = "") -> None:
        super().__init__(message or _name(signal_number))
        self.signal = signal_number
        Interrupted.heard = True


@contextmanager
def interruptible() -> Iterator[None]:
    """SIGINT and SIGTERM raise :class:`Interrupted` at once.

    The exception can get lost: a library that is being imported may catch it or turn it into an
    error of its own, and Python drops it in a callback of the garbage collector. So the signal is
    remembered: at the end of the block, :class:`Interrupted` is raised in any case, and
    :func:`between_steps` does not begin.
    """

    def stop(number: int, _: FrameType | None) -> None:
        if not _is_echo(number):
            _arrived.append(number)
            raise Interrupted(number)

    _last_s.clear()
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


def _is_echo(number: int) -> bool:
    now = time.monotonic()
    echo = now - _last_s.get(number, -1.0) < _ECHO_S
    _last_s[number] = now
    return echo


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
    """A SIGINT or SIGTERM waits until the mission's step is over, but for one second at most.

    It does not wait before the first step is over, when kernels are compiled and maps are read and
    nothing has been recorded yet; and a second signal does not wait.

    Yields:
        To be called after each step: it raises :class:`Interrupted` when a signal waits.
    """
    waiting: list[int] = _arrived[:1]
    begun = False

    def stop(number: int, _: FrameType | None) -> None:
        if _is_echo(number):
            return
        waiting.append(number)
        if len(waiting) > 1 or not begun:
            raise Interrupted(number)
        if hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, _STEP_S)

    def check() -> None:
        nonlocal begun
        begun = True
        _raise_if_any(waiting)

    _raise_if_any(waiting)
    _last_s.clear()
    alarm = signal.SIGALRM if hasattr(signal, "SIGALRM") else None
    alarms = () if alarm is None else (alarm,)
    with _installed(stop), _installed(lambda *_: _raise_if_any(waiting), alarms):
        try:
            yield check
        finally:
            if alarm is not None and threading.current_thread() is threading.main_thread():
                signal.setitimer(signal.ITIMER_REAL, 0.0)


@contextmanager
def ending_in_time() -> Iterator[None]:
    """End the process when Python cannot hear a signal, and at once after a second one.

    While compiled code runs, or a library waits for its threads, no handler is called; a thread
    hears signals then. Files of a run appear whole or not at all, so ending is safe at any time.
    For the outermost block of the process.
    """
    if sys.platform == "win32":
        yield
        return
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    os.register_at_fork(after_in_child=lambda: signal.set_wakeup_fd(-1))
    threading.Thread(target=_watch, args=(reader,), daemon=True, name="signals").start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(-1)


def _watch(reader: int) -> None:
    """End the process in time; the first signal starts the clock."""
    number = _next_signal(reader, None)
    arrived_s = time.monotonic()
    time.sleep(_ECHO_S)
    while _next_signal(reader, 0.0) == number:
        pass
    while True:
        if _next_signal(reader, 0.1):
            time.sleep(_SECOND_S)
            break
        allowed_s = _CLEANUP_S if Interrupted.heard else _STUCK_S
        if time.monotonic() > arrived_s + allowed_s:
            break
    os.write(2, f"{_name(number)}\n".encode())
    os._exit(128 + number)


def _next_signal(reader: int, timeout_s: float | None) -> int:
    """The number of the next SIGINT or SIGTERM, or 0 when none arrives in time."""
    while select.select([reader], [], [], timeout_s)[0]:
        number = os.read(reader, 1)[0]
        handled = signal.getsignal(number) not in (signal.SIG_IGN, signal.SIG_DFL, None)
        if number in _SIGNALS and handled:
            return number
    return 0


def _name(signal_number: int) -> str:
    return "interrupted" if signal_number == signal.SIGINT else "terminated"


@contextmanager
def _installed(
    action: Callable[[int, FrameType | None], None], signals: tuple[signal.Signals, ...] = _SIGNALS
) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield  # Python lets only the main thread set what signals do.
        return
    before: dict[signal.Signals, Any] = {number: signal.getsignal(number) for number in signals}
    try:
        for number in signals:
            # A signal that is ignored (nohup, a job in the background) stays ignored.
            if before[number] is not signal.SIG_IGN:
                signal.signal(number, action)
        yield
    finally:
        for number, previous in before.items():
            signal.signal(number, previous if previous is not None else signal.SIG_DFL)
