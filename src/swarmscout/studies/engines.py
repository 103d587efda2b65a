"""What missions run on: processes of this machine, or a Dask cluster.

Both are a ``concurrent.futures.Executor``, which is all that
:mod:`swarmscout.studies.scheduler` needs to know.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any, Protocol

from swarmscout.core.errors import StudyError
from swarmscout.core.extras import install_command

__all__ = ["DaskEngine", "Engine", "LocalEngine"]


_ASK_EVERY_S = 2.0
"""So often a scheduler is asked how many workers it has."""


class Engine(Protocol):
    """Opens executors, and says how many missions they run at once."""

    @property
    def width(self) -> int:
        """Missions that can run at the same time."""
        ...

    def open(self) -> Any:
        """A context manager that yields an executor; leaving it ends what still runs."""
        ...


class LocalEngine:
    """Processes of this machine.

    The processes end with the one that started them, even when that is killed: each watches a pipe
    whose other end only the parent holds.

    Args:
        jobs: how many processes.
    """

    def __init__(self, jobs: int) -> None:
        if jobs < 1:
            raise StudyError(f"--jobs {jobs}: at least 1 is needed")
        self._jobs = jobs

    @property
    def width(self) -> int:
        """Missions that can run at the same time."""
        return self._jobs

    @contextmanager
    def open(self) -> Iterator[Executor]:
        """A pool; leaving it in any way ends its processes at once."""
        # Not "fork": a process with threads (Polars, progress bars) must not be forked.
        context = multiprocessing.get_context("spawn")
        reader, writer = context.Pipe(duplex=False)
        pool = ProcessPoolExecutor(
            self._jobs, mp_context=context, initializer=_begin_worker, initargs=(reader,)
        )
        try:
            yield pool
        finally:
            writer.close()
            pool.shutdown(wait=True, cancel_futures=True)
            reader.close()


def _begin_worker(reader: Connection) -> None:
    """Leave Ctrl-C to the parent, and end when the parent does."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)

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
        StudyError: Dask is not installed, or nobody answers at the address.
    """

    def __init__(self, scheduler: str) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise StudyError(
                f"--engine dask needs dask.distributed: {install_command('cluster')}"
            ) from None
        self._width = 1
        self._asked = float("-inf")
        # What goes wrong is said by us, in one line; Dask would log every lost connection.
        for name in ("distributed", "distributed.client", "tornado.application", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
        try:
            self._client = Client(scheduler, timeout=5, set_as_default=False)
        except (OSError, ValueError) as error:
            raise StudyError(f"no Dask scheduler answers at '{scheduler}': {error}") from None

    @property
    def width(self) -> int:
        """Missions that can run at the same time, as the scheduler says now and then.

        Raises:
            StudyError: the scheduler does not answer any more.
        """
        if time.monotonic() > self._asked + _ASK_EVERY_S:
            try:
                threads = self._client.nthreads().values()
            except (OSError, RuntimeError) as error:
                raise StudyError(f"the engine of the study is lost: {error}") from None
            self._width = max(1, sum(int(each) for each in threads))
            self._asked = time.monotonic()
        return self._width

    @contextmanager
    def open(self) -> Iterator[Executor]:
        """The client's executor; leaving it cancels what has not begun."""
        # Impure: a mission is run again when it is asked for again, whatever the cluster remembers.
        executor = self._client.get_executor(pure=False)
        try:
            yield executor
        finally:
            executor.shutdown(wait=False)

    def close(self) -> None:
        """Leave the cluster."""
        self._client.close()
