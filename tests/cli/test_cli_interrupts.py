"""Ctrl-C and SIGTERM end a mission cleanly: what was recorded is kept, and it is said where."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from swarmscout import Run, explore
from swarmscout.cli.app import main
from swarmscout.cli.interrupts import Interrupted, between_steps, interruptible


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_keeps_the_run(
    start: Callable[..., Any], here: Path, number: signal.Signals, code: int
) -> None:
    words = ("--robots", "4", "--steps", "1000000", "--destinations", "nearest", "--out", "x")
    child = start("explore", *words, "--set", "battery.enabled=false")
    deadline = time.monotonic() + 120
    while not (here / "x" / "parts" / "000000.zip").exists():
        assert child.poll() is None, child.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.005)
    child.send_signal(number)
    out, err = child.communicate(timeout=60)
    run = Run.open("x")
    assert (child.returncode, err.count("\n")) == (code, 1), (out, err)
    assert f"steps 0 to {run.last_step} are kept in x" in err
    assert not run.finished
    assert run.last_step >= 49
    whole = explore(
        robots=4, steps=run.last_step, destinations="nearest", battery={"enabled": False}
    )
    assert run.steps.equals(whole.steps)
    assert run.coverage.equals(whole.coverage.filter(pl.col("step") <= run.last_step))


WORDS = {signal.SIGINT: "interrupted\n", signal.SIGTERM: "terminated\n"}


def test_outside_a_mission_signals_end_at_once() -> None:
    for number in (signal.SIGINT, signal.SIGTERM):
        with pytest.raises(Interrupted) as caught, interruptible():
            signal.raise_signal(number)
        assert caught.value.signal == number


def test_inside_a_mission_a_signal_waits_and_a_second_does_not() -> None:
    before = signal.getsignal(signal.SIGINT)
    with between_steps() as check:
        check()
        signal.raise_signal(signal.SIGINT)  # The step goes on.
        with pytest.raises(Interrupted) as waited:
            check()
        with pytest.raises(Interrupted) as at_once:
            signal.raise_signal(signal.SIGTERM)
    assert (waited.value.signal, at_once.value.signal) == (signal.SIGINT, signal.SIGTERM)
    assert signal.getsignal(signal.SIGINT) is before


def test_a_signal_that_is_sent_twice_at_once_is_one() -> None:
    with between_steps() as check:
        check()
        signal.raise_signal(signal.SIGTERM)  # ``timeout`` signals the process,
        signal.raise_signal(signal.SIGTERM)  # and then its group.
        with pytest.raises(Interrupted):
            check()
    closed = []

    def mission() -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        finally:
            signal.raise_signal(signal.SIGINT)
            closed.append("a file")

    with pytest.raises(Interrupted), interruptible():
        mission()
    assert closed


def test_a_library_may_turn_an_interrupt_into_its_own_error() -> None:
    def half_an_import() -> None:
        try:
            signal.raise_signal(signal.SIGTERM)
        except BaseException:
            raise ImportError("half an import") from None

    with pytest.raises(Interrupted) as caught, interruptible():
        half_an_import()
    assert caught.value.signal == signal.SIGTERM
    with pytest.raises(ImportError), interruptible():
        raise ImportError("no signal has arrived")


def test_an_interrupt_that_a_library_swallows_is_remembered() -> None:
    def half_an_import() -> None:
        with contextlib.suppress(BaseException):
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(Interrupted), interruptible():
        half_an_import()
    begun = []

    def mission() -> None:
        half_an_import()
        with between_steps():
            begun.append("a mission")

    with pytest.raises(Interrupted), interruptible():
        mission()
    assert not begun
    with interruptible(), between_steps() as check:
        check()  # What was heard before is over.


def test_an_interrupt_that_python_drops_is_remembered_without_a_report(
    capsys: pytest.CaptureFixture[str],
) -> None:
    class Dropped:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGTERM)

    with pytest.raises(Interrupted) as caught, interruptible():
        Dropped()
    assert caught.value.signal == signal.SIGTERM
    assert capsys.readouterr().err == ""


@pytest.mark.slow
@pytest.mark.parametrize("delay_s", [0.15, 0.3, 0.5, 0.8, 1.1, 1.4])
def test_an_interrupt_while_loading_is_one_line(
    start: Callable[..., Any], here: Path, delay_s: float
) -> None:
    words = ("--steps", "100000", "--set", "battery.enabled=false", "--out", "x")
    child = start("explore", *words)
    time.sleep(delay_s)
    child.send_signal(signal.SIGINT)
    _, err = child.communicate(timeout=60)
    assert child.returncode == 130
    assert err.startswith("interrupted")
    assert err.count("\n") == 1


def test_before_the_first_step_is_over_a_signal_does_not_wait() -> None:
    with pytest.raises(Interrupted), between_steps():
        signal.raise_signal(signal.SIGTERM)  # A kernel is being compiled, for example.


def test_a_step_that_goes_on_is_broken_off() -> None:
    began = time.monotonic()
    with between_steps() as check:
        check()
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(Interrupted) as caught:
            time.sleep(60)  # A model thinks, for example.
    assert caught.value.signal == signal.SIGINT
    assert time.monotonic() - began < 30
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


# A mutex that is locked twice: compiled code that does not return, so Python runs no handler.
STUCK = """
import ctypes, sys
import swarmscout.__main__, swarmscout.cli.app
def stuck(*_, **__):
    mutex, library = ctypes.create_string_buffer(64), ctypes.CDLL(None)
    library.pthread_mutex_lock(mutex)
    print("stuck", flush=True)
    library.pthread_mutex_lock(mutex)
swarmscout.cli.app.app = stuck
sys.exit(swarmscout.__main__.main())
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("signals", [1, 2])
def test_compiled_code_that_does_not_return_is_ended(
    here: Path, number: signal.Signals, signals: int
) -> None:
    child = subprocess.Popen(
        [sys.executable, "-c", STUCK], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "stuck\n"
    for _ in range(signals):
        child.send_signal(number)
        time.sleep(0.5)
    _, err = child.communicate(timeout=60)
    assert (child.returncode, err) == (128 + number, WORDS[number])


def test_a_map_that_never_comes(start: Callable[..., Any], here: Path) -> None:
    os.mkfifo("f.npy")
    child = start("explore", "--world", "f.npy", "--out", "x")
    _, err = child.communicate(timeout=60)
    assert child.returncode == 2
    assert err.count("\n") == 1
    assert not (here / "x").exists()


def test_an_interrupt_before_the_mission_leaves_nothing(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(
        "swarmscout.cli.compiling.say_if_compiling", lambda: signal.raise_signal(signal.SIGINT)
    )
    assert main(["explore", "--out", "x"]) == 130
    assert capsys.readouterr().err == "interrupted\n"
    assert not (here / "x").exists()
