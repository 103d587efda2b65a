"""Where missions run: processes of this machine, or a Dask cluster.

An engine opens a ``concurrent.futures.Executor`` for :mod:`swarmscout.studies.scheduler`.
"""

from __future__ import annotations

import logging
import os
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext, SpawnProcess
from types import ModuleType
from typing import Any, Protocol

from swarmscout.core.errors import StudyError
from swarmscout.core.extras import install_command

__all__ = ["DaskEngine", "Engine", "LocalEngine"]

_WIDTH_SECONDS = 2.0
"""How long a scheduler's number of workers is taken as known."""

_CONNECT_SECONDS = 15


class _WorkerProcess(SpawnProcess):
    """A process that does not import the script that started it.

    Missions need nothing of that script. Importing it would run a script without a main guard again
    in every worker.
    """

    def start(self) -> None:
        """Start with an empty main module, which is what the worker would import."""
        main = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            super().start()
        finally:
            sys.modules["__main__"] = main


class _WorkerContext(SpawnContext):
    """Not "fork": a process with threads (Polars, progress bars) must not be forked."""

    Process = _WorkerProcess


class Engine(Protocol):
    """Opens executors, and says how many missions they run at once."""

    @property
    def width(self) -> int:
        """How many missions can run at the same time."""
        ...

    def open(self) -> Any:
        """A context manager that yields an executor; leaving it ends what still runs."""
        ...


class LocalEngine:
    """Processes of this machine.

    The processes end with the one that started them, even when that one is killed: each watches a
    pipe whose other end only the parent holds.

    Args:
        jobs: number of processes, at least 1.

    Raises:
        StudyError: `jobs` is below 1.
    """

    def __init__(self, jobs: int) -> None:
        if jobs < 1:
            raise StudyError(f"--jobs {jobs}: at least 1 is needed")
        self._jobs = jobs

    @property
    def width(self) -> int:
        """How many missions can run at the same time."""
        return self._jobs

    @contextmanager
    def open(self) -> Iterator[Executor]:
        """A pool; leaving it in any way ends its processes at once.

        Raises:
            StudyError: no process of it could start.
        """
        context = _WorkerContext()
        reader, writer = context.Pipe(duplex=False)
        started = context.Event()
        pool = ProcessPoolExecutor(
            self._jobs, mp_context=context, initializer=_begin_worker, initargs=(reader, started)
        )
        try:
            yield pool
            if not started.is_set():
                raise StudyError("no worker process could start; the lines above say why")
        finally:
            writer.close()
            pool.shutdown(wait=True, cancel_futures=True)
            reader.close()


def _begin_worker(reader: Connection, started: Any) -> None:
    """Leave Ctrl-C to the parent, and end when the parent does."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    started.set()

    def watch() -> None:
        try:
            reader.recv()
        except (EOFError, OSError):
            os._exit(1)

    threading.Thread(target=watch, daemon=True, name="watch-parent").start()


class DaskEngine:
    """A Dask cluster; its workers must see the study's folder under the same path.

    Args:
        scheduler: the scheduler's address, for example ``tcp://10.0.0.1:8786``.

    Raises:
        StudyError: Dask is not installed, or no scheduler answers at the address.
    """

    def __init__(self, scheduler: str) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise StudyError(
                f"--engine dask needs dask.distributed: {install_command('cluster')}"
            ) from None
        self._width = 1
        self._width_known_at = float("-inf")
        # Errors are reported here in one line; Dask would log every lost connection as well.
        for name in ("distributed", "distributed.client", "tornado.application", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
        try:
            self._client = Client(scheduler, timeout=_CONNECT_SECONDS, set_as_default=False)
        except (OSError, ValueError) as error:
            raise StudyError(f"no Dask scheduler answers at '{scheduler}': {error}") from None

    @property
    def width(self) -> int:
        """How many missions can run at the same time, by the scheduler's own count.

        Raises:
            StudyError: the scheduler no longer answers.
        """
        if time.monotonic() > self._width_known_at + _WIDTH_SECONDS:
            try:
                threads = self._client.nthreads().values()
            except (OSError, RuntimeError) as error:
                raise StudyError(f"the engine of the study is lost: {error}") from None
            self._width = max(1, sum(int(each) for each in threads))
            self._width_known_at = time.monotonic()
        return self._width

    @contextmanager
    def open(self) -> Iterator[Executor]:
        """The client's executor; leaving it cancels what has not begun."""
        # Impure: a mission that is submitted again runs again, even if the cluster remembers it.
        executor = self._client.get_executor(pure=False)
        try:
            yield executor
        finally:
            executor.shutdown(wait=False)

    def close(self) -> None:
        """Disconnect from the cluster."""
        self._client.close()
