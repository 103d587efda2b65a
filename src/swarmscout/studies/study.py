"""A study: what its file declares, what it plans, and what its folder holds."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from swarmscout.core.errors import ScenarioError, StudyError
from swarmscout.core.version import package_version
from swarmscout.mission.mission import RULES_VERSION
from swarmscout.mission.scenario import Scenario
from swarmscout.studies.plan import Planned, base_scenario, expand, scenario_of
from swarmscout.studies.study_file import (
    Axis,
    StudyFile,
    checked,
    read_study_file,
    study_toml,
)
from swarmscout.studies.study_folder import Failure, StudyFolder

if TYPE_CHECKING:
    import polars as pl

__all__ = ["Study"]


class Study:
    """Many missions that answer one question; open it with :meth:`Study.load`.

    Attributes:
        declared: what the file says.
        axes: its axes.
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
            trials: instead of the file's.

        Raises:
            StudyError: the file is wrong, or there is none.
        """
        declared, axes, base = read_study_file(path)
        if trials is not None:
            declared = declared.model_copy(update={"trials": trials})
        if out is None:
            is_folder = Path(path).is_dir()
            out = Path(path) if is_folder else Path("runs") / f"study-{declared.name}"
        return Study(declared, axes, base, StudyFolder(Path(out)))

    def changed(self, changes: Mapping[str, Any]) -> Study:
        """The same study with other declarations, in the same folder.

        Args:
            changes: of the file's keys.

        Raises:
            StudyError: a change is impossible.
        """
        return Study(*checked({**self.declared.model_dump(), **changes}, self._base), self.folder)

    def __repr__(self) -> str:
        return f"<Study '{self.declared.name}' in '{self.folder.path}'>"

    @cached_property
    def missions(self) -> list[Planned]:
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
        """Axes that say how missions are set up, besides what is compared and where it is run."""
        return [axis for axis in self.axes if axis is not self.compared and not axis.is_place]

    @property
    def versions(self) -> dict[str, Any]:
        """Of the package, and of the rules."""
        return {"version": package_version(), "rules_version": RULES_VERSION}

    def scenario(self, mission: Planned) -> Scenario:
        """The resolved scenario of a mission."""
        return scenario_of(self.axes, self._scenario, self._base, mission.values, mission.seed)

    def claim(self) -> None:
        """Make the study's folder, or take the one there is, and keep the file in it.

        Raises:
            StudyError: the folder holds something else, or the study is impossible.
        """
        self.missions  # noqa: B018 - a study that cannot be run leaves no folder behind.
        self.folder.claim(self.declared.name, self.text)

    @property
    def text(self) -> str:
        """The study's file as it is kept in the folder: it means the same wherever it lies."""
        return study_toml(self.declared, self._base, self.versions)

    def todo(self, *, retry: bool = False) -> list[Planned]:
        """Missions that are neither finished nor, unless they are to be tried again, failed."""
        finished = self.folder.finished()
        failed = set() if retry else set(self.folder.failed())
        left = {m.name: m for m in self.missions if m.name not in finished | failed}
        return list(left.values())

    def failures(self) -> list[Failure]:
        """The missions of this study that failed and have not succeeded since."""
        finished, failed = self.folder.finished(), self.folder.failed()
        names = dict.fromkeys(m.name for m in self.missions)
        return [failed[name] for name in names if name in failed and name not in finished]

    def frame(self) -> pl.DataFrame:
        """One tidy table: a row per mission, a column per axis and per measured number.

        Raises:
            StudyError: a finished run is damaged.
        """
        from swarmscout.studies.table import missions_table

        return missions_table(self)
