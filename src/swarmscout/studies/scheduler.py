"""Running a study: every mission that has not been run, over any executor.

Nothing is lost: a mission that has finished stands in its folder before anybody is told, so a study
can be killed at any time and goes on where it was. When a worker dies the pool breaks as a whole;
a new one is opened, and the missions that were under way are tried one at a time, so that the one
that kills its worker is found and the others are not blamed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future
from concurrent.futures import wait as wait_for

from swarmscout.core.errors import StudyError
from swarmscout.studies.engines import Engine
from swarmscout.studies.plan import Planned
from swarmscout.studies.study import Study
from swarmscout.studies.study_folder import Failure
from swarmscout.studies.worker import Outcome, Task, carry_out

__all__ = ["Listener", "run_study"]

Listener = Callable[[Planned, Outcome], None]
"""Called with every mission that has come to an end, in the order in which they do."""

_DIED = "its worker process died (killed, or out of memory)"


def run_study(
    study: Study,
    engine: Engine,
    *,
    retry: bool = False,
    listener: Listener | None = None,
) -> int:
    """Run what is left of a study.

    Args:
        study: the study.
        engine: what to run it on.
        retry: also run the missions again that failed before.
        listener: is told of every mission that ends.

    Returns:
        How many missions were run.

    Raises:
        StudyError: the folder cannot be used, or the engine is lost; what has finished is kept.
    """
    study.claim()
    with study.folder.locked():
        study.folder.sweep()
        todo = study.todo(retry=retry)
        return _Run(study, engine, listener).run(deque(todo))


class _Run:
    def __init__(self, study: Study, engine: Engine, listener: Listener | None) -> None:
        self._study = study
        self._engine = engine
        self._listener = listener
        self._waiting: dict[Future[Outcome], Planned] = {}
        self._suspects: deque[Planned] = deque()
        self._suspected: set[str] = set()
        self._ended = 0

    def run(self, todo: deque[Planned]) -> int:
        """Run all; returns how many came to an end."""
        while todo or self._suspects:
            with self._engine.open() as executor:
                self._until_broken(executor, todo)
        return self._ended

    def _until_broken(self, executor: Executor, todo: deque[Planned]) -> None:
        """Run until all is done, or until the executor breaks."""
        while True:
            # Twice as many as can run are handed in, so that no worker waits for the next.
            alone = self._suspects or any(m.name in self._suspected for m in self._waiting.values())
            room = 1 if alone else 2 * self._engine.width
            source = self._suspects or todo
            try:
                while source and len(self._waiting) < room:
                    self._waiting[executor.submit(carry_out, self._task(source[0]))] = source[0]
                    source.popleft()
            except BrokenExecutor:
                return self._sort_out()
            except RuntimeError as error:
                raise StudyError(f"the engine of the study is lost: {error}") from None
            if not self._waiting:
                return None
            done, _ = wait_for(self._waiting, return_when=FIRST_COMPLETED)
            if any(_is_broken(future) for future in done):
                return self._sort_out()
            for future in done:
                self._take(future)

    def _sort_out(self) -> None:
        """A worker died: take what has finished, and suspect what has not."""
        broken = []
        wait_for(self._waiting)
        for future in list(self._waiting):
            if _is_broken(future):
                broken.append(self._waiting.pop(future))
            else:
                self._take(future)
        for mission in broken:
            if len(broken) == 1 and mission.name in self._suspected:
                self._tell(mission, Outcome(mission.name, _DIED))
            else:
                self._suspected.add(mission.name)
                self._suspects.append(mission)

    def _take(self, future: Future[Outcome]) -> None:
        mission = self._waiting.pop(future)
        try:
            outcome = future.result()
        except CancelledError:
            raise StudyError("the engine of the study is lost") from None
        except Exception as error:  # Dask's KilledWorker, or whatever else an engine raises.
            outcome = Outcome(mission.name, f"{type(error).__name__}: {error}")
        self._tell(mission, outcome)

    def _tell(self, mission: Planned, outcome: Outcome) -> None:
        if outcome.error is None:
            self._study.folder.forget_failure(mission.name)
        else:
            self._study.folder.note_failure(Failure(mission.name, outcome.error, outcome.traceback))
        self._ended += 1
        if self._listener is not None:
            self._listener(mission, outcome)

    def _task(self, mission: Planned) -> Task:
        study = self._study
        folder = str(study.folder.run(mission.name).resolve())
        return Task(mission.name, study.scenario(mission), folder, study.declared.record)


def _is_broken(future: Future[Outcome]) -> bool:
    return not future.cancelled() and isinstance(future.exception(), BrokenExecutor)
