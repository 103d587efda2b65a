"""The reader of runs: finished or killed, on disk or in memory.

What is asked for is read then, checked, and kept.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import RunError, ScenarioError
from swarmscout.core.grid import GridFrame
from swarmscout.destinations.walking import CELL_BITS
from swarmscout.mission.build import make_model
from swarmscout.mission.scenario import Scenario
from swarmscout.mission.scenario_files import load_scenario
from swarmscout.recording import table_files
from swarmscout.recording.archive_world import give_world_back
from swarmscout.recording.decisions import read_text
from swarmscout.recording.json_files import RUN, SUMMARY, read_json
from swarmscout.recording.own_maps import GatheredEvidence, OwnMaps
from swarmscout.recording.run_folder import SCENARIO, as_path
from swarmscout.recording.table_checks import check_number, fault_of
from swarmscout.recording.tables import FORMAT, LEVELS, empty_table
from swarmscout.worlds.ground_plane import pitch_and_roll, stand

if TYPE_CHECKING:
    import polars as pl

    from swarmscout.worlds.world import World

__all__ = ["Run"]


class Run:
    """One recorded mission; open it with :meth:`Run.open`.

    Attributes:
        path: the run's folder, or None for a run in memory.
        finished: whether the mission came to its end; False for one that was killed.
        summary: the mission's figures, or None when it did not finish.
        scenario: what was run.
        frame: where the map's cells lie.
        stations_m: float64[k, 2], charging stations.
        level: what was recorded: ``full``, ``curves`` or ``summary``.
        own_maps: whether each robot kept a map of its own, because links were limited.
        facts: what ``run.json`` says: versions, robots, where the world is kept.

    Example:
        >>> run = Run.open("runs/lava-tube-nearest-n15-s0")  # doctest: +SKIP
        >>> run.coverage["explored_m2"][-1]  # doctest: +SKIP
    """

    def __init__(
        self,
        *,
        path: Path | None,
        scenario: Scenario,
        facts: Mapping[str, Any],
        summary: dict[str, Any] | None,
        sums: Mapping[str, str] | None = None,
    ) -> None:
        self.path = path
        self.scenario = scenario
        self.facts = facts
        self.summary = summary
        self.finished = summary is not None
        self.level = str(facts["record"])
        self.own_maps = facts["maps"] == "own"
        self.tables = tuple(facts["tables"])
        self.frame = GridFrame(**facts["frame"])
        self.stations_m = np.asarray(facts["stations_m"], dtype=np.float64).reshape(-1, 2)
        self._sums = sums
        self._frames: dict[str, pl.DataFrame] = {}
        self._in_memory: Mapping[str, list[pl.DataFrame]] = {}
        self._world: World | None = None
        self._final_map: NDArray[np.int32] | None = None
        self._texts: dict[str, str] = {}

    @staticmethod
    def open(path: str | Path) -> Run:
        """Open a run's folder, of a finished mission or of a killed one.

        A killed mission's run holds every step of its closed parts: all but the last 50 at most.

        Args:
            path: the folder.

        Raises:
            RunError: the folder is not a run, is damaged, or was written in another format.
        """
        folder = as_path(path)
        facts = _facts_of(folder)
        summary = read_json(folder / SUMMARY)
        sums = None if summary is None else summary.pop("files", None)
        try:
            table_files.checked_bytes(folder / SCENARIO, facts["files"].get(SCENARIO))
            run = Run(
                path=folder,
                scenario=load_scenario(folder),
                facts=facts,
                summary=summary,
                sums=sums,
            )
        except ScenarioError as error:
            raise RunError(f"run '{folder}' is damaged: {error}") from None
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise RunError(f"'{folder / RUN}' is damaged: {error}") from None
        _check_agreement(run)
        return run

    @staticmethod
    def in_memory(
        *,
        scenario: Scenario,
        facts: Mapping[str, Any],
        world: World,
        summary: dict[str, Any] | None,
        tables: Mapping[str, list[pl.DataFrame]],
        final_map: NDArray[np.int32] | None,
        texts: Mapping[str, str] | None = None,
    ) -> Run:
        """A run that is on no disk; :meth:`swarmscout.recording.writer.RunWriter.run` makes it."""
        run = Run(path=None, scenario=scenario, facts=facts, summary=summary)
        run._in_memory = {table: list(frames) for table, frames in tables.items()}
        run._world = world
        run._final_map = final_map
        run._texts = dict(texts or {})
        return run

    def __repr__(self) -> str:
        state = "finished" if self.finished else "not finished"
        return f"<Run {self._where}: {self.scenario.robots} robots, {state}>"

    @property
    def _where(self) -> str:
        return "in memory" if self.path is None else f"'{self.path}'"

    @property
    def steps(self) -> pl.DataFrame:
        """A row per robot and step, from step 0: pose, charge, mode, action, team, destination."""
        return self.table("steps")

    @cached_property
    def poses(self) -> pl.DataFrame:
        """A row per robot and step: where it stands in 3D, on the ground of the run's world.

        Columns ``step, robot, x_m, y_m, z_m, heading_rad, pitch_rad, roll_rad``; angles are those
        of REP 103 (positive pitch is nose down, positive roll is left side up).

        Raises:
            RunError: steps were not recorded, or the world cannot be loaded.
        """
        steps = self.steps.select("step", "robot", "x_m", "y_m", "heading_rad")
        heading = steps["heading_rad"].to_numpy()
        places = steps.select("x_m", "y_m").to_numpy()
        footing = stand(self.world(), places, self.scenario.body.radius_m)
        pitch, roll = pitch_and_roll(footing, heading)
        names = ("z_m", "heading_rad", "pitch_rad", "roll_rad")
        columns = zip(names, (footing[:, 0], heading, pitch, roll), strict=True)
        return steps.drop("heading_rad").with_columns(**dict(columns))

    @property
    def coverage(self) -> pl.DataFrame:
        """A row per step: explored area and what else the mission counts."""
        return self.table("coverage")

    @property
    def map_changes(self) -> pl.DataFrame:
        """A row per changed map cell and step: ``step``, flat ``cell``, ``log_odds`` (1/1000)."""
        return self.table("map_changes")

    @property
    def evidence(self) -> pl.DataFrame:
        """A row per scan and cell: what a robot's log gained; empty where one map serves all."""
        return self.table("evidence")

    @property
    def links(self) -> pl.DataFrame:
        """A row per change of who hears whom; empty where all robots hear each other."""
        return self.table("links")

    @property
    def decisions(self) -> pl.DataFrame:
        """A row per choice of a destination."""
        return self.table("decisions")

    @property
    def attempts(self) -> pl.DataFrame:
        """A row per question to a language model; empty where none was asked."""
        return self.table("attempts")

    def text(self, name: str) -> str:
        """A prompt or an answer, by the hash that stands in ``attempts``.

        Raises:
            RunError: the run has no such text, or it is damaged.
        """
        if self.path is not None:
            return read_text(self.path, name)
        if name not in self._texts:
            raise RunError(f"the run has no text '{name}'")
        return self._texts[name]

    @property
    def events(self) -> pl.DataFrame:
        """A row per event; ``swarmscout.core.enums`` says what ``other`` and ``value`` mean."""
        return self.table("events")

    @property
    def timing(self) -> pl.DataFrame:
        """A row per step: ``<phase>_s`` in seconds. The only table that differs from run to run."""
        return self.table("timing")

    @cached_property
    def last_step(self) -> int:
        """The last recorded step; -1 when none is.

        Raises:
            RunError: the run is not finished and has no ``coverage``.
        """
        if self.summary is not None and "coverage" not in self.tables:
            return int(self.summary["steps"])
        coverage = self.coverage
        return int(coverage["step"][-1]) if coverage.height else -1

    def table(self, name: str) -> pl.DataFrame:
        """A table by its name.

        Raises:
            RunError: the table was not recorded, is missing, or is damaged.
        """
        if name not in self._frames:
            self._frames[name] = self._read(name)
        return self._frames[name]

    def map_at(self, step: int | None = None, *, robot: int | None = None) -> NDArray[np.int32]:
        """The map after a step: what the swarm knew together, or one robot alone.

        Args:
            step: 0 … :attr:`last_step`; None for the last.
            robot: whose map; None for the swarm's, which all share under full communication.

        Returns:
            int32[rows, cols] log-odds as read (saturated), in 1/1000 nat; 0 where no ray passed.

        Raises:
            RunError: the step or robot does not exist, or maps were not recorded.
        """
        last = self.last_step
        wanted = last if step is None else step
        check_number("step", wanted, last)
        if robot is not None:
            self.check_robot(robot)
            if self.own_maps:
                maps = self.robot_maps([robot])
                maps.advance(int(wanted))
                return maps.log_odds(robot)
        if wanted == last and self.finished:
            return self._read_final_map().copy()
        changes = self.map_changes
        end = changes["step"].search_sorted(wanted, side="right")
        # Rows are in order of steps: where a cell changed more than once the last change stays.
        log_odds = np.zeros(self.frame.size, dtype=np.int32)
        log_odds[changes["cell"][:end].to_numpy()] = changes["log_odds"][:end].to_numpy()
        return log_odds.reshape(self.frame.shape)

    def robot_maps(self, robots: Sequence[int]) -> OwnMaps:
        """The maps of some robots before the first step, to be advanced from step to step.

        Raises:
            RunError: a robot does not exist, or the robots' evidence was not recorded.
        """
        for robot in robots:
            self.check_robot(robot)
        gathered = GatheredEvidence.of(
            self.table("evidence"), self.table("links"), self.scenario.robots, self.last_step
        )
        return OwnMaps(gathered, robots, self.frame, make_model(self.scenario))

    def check_robot(self, robot: int) -> None:
        """Check that the run has a robot of this number.

        Raises:
            RunError: the robot does not exist.
        """
        check_number("robot", robot, self.scenario.robots - 1)

    def world(self) -> World:
        """The world that the mission ran in.

        Raises:
            RunError: the kept world is missing or damaged, or can no longer be generated.
        """
        if self._world is None:
            assert self.path is not None
            self._world = give_world_back(self.path, self.facts)
        return self._world

    def _read(self, name: str) -> pl.DataFrame:
        import polars as pl

        if name not in LEVELS["full"]:
            raise RunError(f"a run has no table '{name}': there are {', '.join(LEVELS['full'])}")
        if name not in LEVELS[self.level]:
            raise RunError(
                f"run {self._where}: table '{name}' was not recorded: the run's level is "
                f"'{self.level}', only record='full' (explore --record full) keeps every table"
            )
        if name not in self.tables:
            return empty_table(name)
        if self.path is None:
            frames = self._in_memory.get(name, [])
            return pl.concat(frames, rechunk=True) if frames else empty_table(name)
        frame = table_files.read_table(self.path, name, self._sums)
        fault = fault_of(frame, name, self.scenario.robots, self.frame.size)
        if fault is None and name not in ("coverage", "decisions", "attempts"):
            steps = self.coverage.height
            rows = {"steps": steps * self.scenario.robots, "timing": steps}.get(name, frame.height)
            if frame.height != rows:
                fault = f"it has {frame.height} rows, expected {rows}"
        if fault is not None:
            raise RunError(f"run '{self.path}' is damaged: table '{name}': {fault}")
        return frame

    def _read_final_map(self) -> NDArray[np.int32]:
        if self._final_map is None:
            assert self.path is not None
            file = self.path / table_files.MAP
            if self._sums and file.name in self._sums:
                table_files.checked_bytes(file, self._sums[file.name])
            else:
                file = self.path / table_files.DATA
            log_odds = table_files.read_array(file, "log_odds")
            if log_odds.shape != self.frame.shape or log_odds.dtype.kind not in "iu":
                raise RunError(
                    f"'{file}' is damaged: its map is {log_odds.dtype}{list(log_odds.shape)}, "
                    f"expected integers{list(self.frame.shape)}"
                )
            self._final_map = log_odds.astype(np.int32)
        return self._final_map


def _facts_of(folder: Path) -> dict[str, Any]:
    """The content of ``run.json``, checked."""
    if not folder.exists():
        raise RunError(f"run folder '{folder}' does not exist")
    if not folder.is_dir():
        raise RunError(f"'{folder}' is a file, not a run's folder")
    file = folder / RUN
    facts = read_json(file, check=False)
    if facts is None:
        raise RunError(f"'{folder}' is not a run: it has no run.json")
    written = facts.get("format")
    if not isinstance(written, int):
        raise RunError(f"'{folder}' is not a run: its run.json has another format")
    if written != FORMAT:
        age = "a newer" if written > FORMAT else "an older"
        raise RunError(
            f"run '{folder}' was written by {age} swarmscout ({facts.get('version')}) in format "
            f"{written}; this one reads format {FORMAT}"
        )
    facts = read_json(file) or {}
    if facts.get("record") not in LEVELS:
        raise RunError(f"'{file}' is damaged: recording level {facts.get('record')!r} is unknown")
    return facts


def _check_agreement(run: Run) -> None:
    """Check that the files of a run speak of the same mission.

    Raises:
        RunError: they do not.
    """
    facts, frame, fault = run.facts, run.frame, None
    if facts.get("robots") != run.scenario.robots:
        fault = f"it has {facts.get('robots')} robots, the scenario {run.scenario.robots}"
    elif not set(run.tables) <= set(LEVELS[run.level]):
        fault = f"tables {', '.join(map(str, run.tables))} are not those of level '{run.level}'"
    elif not all(isinstance(facts["frame"][key], int) for key in ("rows", "columns")) or not (
        min(frame.rows, frame.columns) > 0 and frame.size < 1 << CELL_BITS and frame.cell_m > 0
    ):
        fault = f"the map has {frame.rows} rows and {frame.columns} columns of {frame.cell_m} m"
    elif run.summary is not None:
        for key in ("rules_version", "robots"):
            if run.summary.get(key) != facts.get(key):
                fault = f"{key} is {facts.get(key)}, in summary.json {run.summary.get(key)}"
        if not isinstance(run.summary.get("steps"), int):
            fault = "summary.json does not say how many steps there are"
    if fault is not None:
        raise RunError(f"run '{run.path}' is damaged: run.json: {fault}")
