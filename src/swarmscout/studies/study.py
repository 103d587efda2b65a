"""A study: what its file declares, what it plans, and what its folder holds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmscout.core.errors import ScenarioError, StudyError
from swarmscout.mission.scenario import Scenario
from swarmscout.recording.writer import written_by
from swarmscout.studies.plan import PlannedMission, base_scenario, expand, scenario_of
from swarmscout.studies.study_file import (
    Axis,
    StudyFile,
    checked,
    read_study_file,
    study_toml,
)
from swarmscout.studies.study_folder import Failure, StudyFolder

if TYPE_CHECKING:
    import numpy as np
    import polars as pl
    from numpy.typing import NDArray

__all__ = ["Study"]


class Study:
    """Many missions that answer one question; open one with :meth:`Study.load`.

    Attributes:
        declared: the contents of the study's file.
        axes: the axes of the sweep, in the file's order.
        folder: where results go.

    Example:
        >>> study = Study.load("runs/study-quick")  # doctest: +SKIP
        >>> study.frame().select("destinations", "seed", "explored_m2")  # doctest: +SKIP
    """

    def __init__(
        self, declared: StudyFile, axes: list[Axis], base: Path, folder: StudyFolder
    ) -> None:
        self.declared = declared
        self.axes = axes
        self.folder = folder
        self._base = base

    @staticmethod
    def load(
        path: str | Path, out: str | Path | None = None, *, trials: int | None = None
    ) -> Study:
        """Read a study.

        Args:
            path: its file, or the folder of a study that was run.
            out: where results go; by default ``runs/study-<name>``, or the folder itself.
            trials: overrides the file's number of trials.

        Raises:
            StudyError: the file is missing or wrong.
        """
        declared, axes, base = read_study_file(path)
        if out is None:
            is_folder = Path(path).is_dir()
            out = Path(path) if is_folder else Path("runs") / f"study-{declared.name}"
        study = Study(declared, axes, base, StudyFolder(Path(out)))
        return study if trials is None else study.changed({"trials": trials})

    def changed(self, changes: Mapping[str, Any]) -> Study:
        """The same study with some keys of its file changed, in the same folder.

        Args:
            changes: top-level keys of the file and their new values.

        Raises:
            StudyError: a change is impossible.
        """
        return Study(*checked({**self.declared.model_dump(), **changes}, self._base), self.folder)

    def __repr__(self) -> str:
        return f"<Study '{self.declared.name}' in '{self.folder.path}'>"

    @cached_property
    def missions(self) -> list[PlannedMission]:
        """Every mission, in the order in which they are run.

        Raises:
            StudyError: a combination of values is impossible.
        """
        return expand(self.declared, self.axes, self._scenario, self._base)

    @cached_property
    def _scenario(self) -> Scenario:
        try:
            return base_scenario(self.declared, self._base)
        except ScenarioError as error:
            raise StudyError(f"study '{self.declared.name}': {error}") from None

    @property
    def compared(self) -> Axis:
        """The axis whose values are compared."""
        return next(axis for axis in self.axes if axis.name == self.declared.compare.axis)

    @property
    def settings(self) -> list[Axis]:
        """The axes that are neither compared nor a place (world, world seed)."""
        return [axis for axis in self.axes if axis is not self.compared and not axis.is_place]

    @property
    def setting_names(self) -> list[str]:
        """Names of :attr:`settings`."""
        return [axis.name for axis in self.settings]

    @property
    def versions(self) -> dict[str, Any]:
        """Version of the package and of the rules."""
        return written_by()

    def scenario(self, mission: PlannedMission) -> Scenario:
        """The resolved scenario of a mission."""
        return scenario_of(self.axes, self._scenario, self._base, mission.values, mission.seed)

    @contextmanager
    def claimed(self) -> Iterator[None]:
        """Hold the study's folder for this process, with the study's file in it.

        Raises:
            StudyError: the study is impossible, or its folder cannot be used; then nothing in the
                folder has changed.
        """
        self.missions  # noqa: B018 - a study that cannot be run leaves no folder behind.
        with self.folder.claimed(self.declared.name, self.text):
            yield

    @property
    def text(self) -> str:
        """The study's file as kept in the folder, with absolute paths."""
        return study_toml(self.declared, self._base, self.versions)

    def todo(self, *, retry: bool = False) -> list[PlannedMission]:
        """Missions that have not finished, and have not failed unless `retry` is set."""
        finished = self.folder.finished()
        failed = set() if retry else set(self.folder.failed())
        over = finished | failed
        return list({m.name: m for m in self.missions if m.name not in over}.values())

    def failures(self) -> list[Failure]:
        """The missions of this study that failed and have not succeeded since."""
        finished, failed = self.folder.finished(), self.folder.failed()
        names = dict.fromkeys(m.name for m in self.missions)
        return [failed[name] for name in names if name in failed and name not in finished]

    def frame(self) -> pl.DataFrame:
        """One tidy table: a row per mission, a column per axis and per measured number.

        The column ``status`` is ``finished``, ``failed`` or ``not run``.

        Raises:
            StudyError: a finished run is damaged.
        """
        from swarmscout.studies.table import missions_table

        record = self.declared.record
        return missions_table(self.missions, self.axes, self.folder, record, self.scenario)

    def curves(self) -> NDArray[np.float32]:
        """float32[missions, steps + 1]: explored m² after each step, in the rows' order.

        NaN for missions that have not finished, and after the end of those shorter than others.

        Raises:
            StudyError: a finished run is damaged.
        """
        from swarmscout.studies.table import area_curves

        return area_curves(self.missions, self.folder, self.declared.record)
