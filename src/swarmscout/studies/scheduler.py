"""Running a study: every mission that has not been run, over any executor.

A mission that has finished lies in its folder before its outcome is reported, so a study can be
killed at any time and resumed. When a worker dies, the whole pool breaks. Each mission that was
under way then runs alone in a pool of its own, and only a mission that breaks that pool fails.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future
from concurrent.futures import wait as wait_for

from swarmscout.core.errors import StudyError
from swarmscout.studies.engines import Engine
from swarmscout.studies.plan import PlannedMission
from swarmscout.studies.study import Study
from swarmscout.studies.study_folder import Failure
from swarmscout.studies.worker import Outcome, Task, run_task

__all__ = ["Listener", "run_study"]

Listener = Callable[[PlannedMission, Outcome], None]
"""Called with every mission that has ended, in the order in which they end."""

_DIED = "its worker process died (killed, or out of memory)"


def run_study(
    study: Study,
    engine: Engine,
    *,
    retry: bool = False,
    listener: Listener | None = None,
) -> int:
    """Run the missions of a study that have not been run.

    Args:
        study: the study.
        engine: what to run it on.
        retry: also run missions that failed before.
        listener: called with every mission that ends.

    Returns:
        How many missions were run.

    Raises:
        StudyError: the folder cannot be used, no worker can start, or the engine is lost. Finished
            missions are kept.
    """
    with study.claimed():
        return _StudyRun(study, engine, listener).run(deque(study.todo(retry=retry)))


class _StudyRun:
    def __init__(self, study: Study, engine: Engine, listener: Listener | None) -> None:
        self._study = study
        self._engine = engine
        self._listener = listener
        self._waiting: dict[Future[Outcome], PlannedMission] = {}
        self._suspects: deque[PlannedMission] = deque()
        self._ended = 0

    def run(self, todo: deque[PlannedMission]) -> int:
        """Run all; returns how many ended."""
        while todo or self._suspects:
            with self._engine.open() as executor:
                if self._suspects:
                    self._run_alone(executor, self._suspects.popleft())
                else:
                    self._run_until_broken(executor, todo)
        return self._ended

    def _run_alone(self, executor: Executor, mission: PlannedMission) -> None:
        """Run one mission with nothing beside it, so that a dead worker is its own doing."""
        try:
            future = executor.submit(run_task, self._task(mission))
            wait_for([future])
        except RuntimeError as error:
            raise StudyError(f"the engine of the study is lost: {error}") from None
        if _is_broken(future):
            self._report(mission, Outcome(mission.name, _DIED))
        else:
            self._report(mission, self._outcome(mission, future))

    def _run_until_broken(self, executor: Executor, todo: deque[PlannedMission]) -> None:
        """Run until all is done, or until the executor breaks."""
        while True:
            # Twice as many as can run are submitted, so that no worker waits for the next.
            room = 2 * self._engine.width
            try:
                while todo and len(self._waiting) < room:
                    self._waiting[executor.submit(run_task, self._task(todo[0]))] = todo[0]
                    todo.popleft()
            except BrokenExecutor:
                wait_for(self._waiting)
                self._take(set(self._waiting))
                return
            except RuntimeError as error:
                raise StudyError(f"the engine of the study is lost: {error}") from None
            if not self._waiting:
                return
            done, _ = wait_for(self._waiting, return_when=FIRST_COMPLETED)
            self._take(done)

    def _take(self, done: set[Future[Outcome]]) -> None:
        """Report what has ended; missions whose worker died are to be run alone."""
        for future in [future for future in self._waiting if future in done]:
            mission = self._waiting.pop(future)
            if _is_broken(future):
                self._suspects.append(mission)
            else:
                self._report(mission, self._outcome(mission, future))

    def _outcome(self, mission: PlannedMission, future: Future[Outcome]) -> Outcome:
        try:
            return future.result()
        except CancelledError:
            raise StudyError("the engine of the study is lost") from None
        except Exception as error:  # Anything that an engine raises.
            return Outcome(mission.name, f"{type(error).__name__}: {error}")

    def _report(self, mission: PlannedMission, outcome: Outcome) -> None:
        if outcome.error is None:
            self._study.folder.forget_failure(mission.name)
        else:
            failure = Failure(mission.name, outcome.error, outcome.traceback)
            self._study.folder.note_failure(failure)
        self._ended += 1
        if self._listener is not None:
            self._listener(mission, outcome)

    def _task(self, mission: PlannedMission) -> Task:
        study = self._study
        folder = str(study.folder.run(mission.name).resolve())
        return Task(mission.name, study.scenario(mission), folder, study.declared.record)


def _is_broken(future: Future[Outcome]) -> bool:
    """Whether a worker died; Dask says so for every mission that the worker held."""
    if future.cancelled():
        return False
    error = future.exception()
    return isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker"
