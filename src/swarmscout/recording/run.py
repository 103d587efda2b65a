"""The one reader of runs: finished or killed, on disk or in memory.

What is open is read when it is first asked for, and kept.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import RunError, ScenarioError
from swarmscout.core.grid import GridFrame
from swarmscout.mission.scenario import Scenario
from swarmscout.mission.scenario_files import load_scenario
from swarmscout.recording.archive_world import give_world_back
from swarmscout.recording.attempts import TEXTS
from swarmscout.recording.own_maps import check_robot, own_maps_of
from swarmscout.recording.run_folder import as_path
from swarmscout.recording.table_files import AT_ONCE, read_table, read_whole_table
from swarmscout.recording.tables import FORMAT, LEVELS, OWN_MAPS, empty_table
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
    ) -> None:
        self.path = path
        self.scenario = scenario
        self.facts = facts
        self.summary = summary
        self.finished = summary is not None
        self.level = str(facts["record"])
        self.own_maps = facts.get("maps") == "own"
        self.frame = GridFrame(**facts["frame"])
        self.stations_m = np.asarray(facts["stations_m"], dtype=np.float64).reshape(-1, 2)
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
            RunError: there is no run, or it is damaged, or a newer version wrote it.
        """
        folder = as_path(path)
        facts = _facts_of(folder)
        summary = _object_in(folder / "summary.json")
        try:
            scenario = load_scenario(folder)
        except ScenarioError as error:
            raise RunError(f"run '{folder}' is damaged: {error}") from None
        try:
            return Run(path=folder, scenario=scenario, facts=facts, summary=summary)
        except (KeyError, TypeError, ValueError) as error:
            raise RunError(f"'{folder / 'run.json'}' is damaged: {error}") from None

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
        where = "in memory" if self.path is None else f"'{self.path}'"
        state = "finished" if self.finished else "not finished"
        return f"<Run {where}: {self.scenario.robots} robots, {state}>"

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
            RunError: steps were not recorded, or the world cannot be had back.
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
        """A row per change of who hears whom; without rows where everybody hears everybody."""
        return self.table("links")

    @property
    def decisions(self) -> pl.DataFrame:
        """A row per choice of a destination."""
        return self.table("decisions")

    @property
    def attempts(self) -> pl.DataFrame:
        """A row per question to a language model; without rows where none was asked."""
        return self.table("attempts")

    def text(self, name: str) -> str:
        """A prompt or an answer, by the hash that stands in ``attempts``.

        Raises:
            RunError: the run has no such text.
        """
        if self.path is None:
            if name in self._texts:
                return self._texts[name]
            raise RunError(f"the run has no text '{name}'")
        file = self.path / TEXTS / f"{name}.txt"
        try:
            return file.read_bytes().decode()
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
            raise RunError(f"cannot read '{file}': {reason}") from None

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
        if self.summary is not None and not LEVELS[self.level]:
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
            robot: whose map; None for the swarm's, which under full communication is everybody's.

        Returns:
            int32[rows, cols] log-odds as read (saturated), in 1/1000 nat; 0 where nobody looked.

        Raises:
            RunError: there is no such step or robot, or maps were not recorded.
        """
        last = self.last_step
        wanted = last if step is None else step
        if isinstance(wanted, bool) or not isinstance(wanted, int | np.integer):
            raise RunError(f"step = {step!r}: expected a whole number, 0 to {last}")
        if not 0 <= wanted <= last:
            raise RunError(f"there is no step {wanted}: the run holds steps 0 to {last}")
        if robot is not None:
            check_robot(self, robot)
            if self.own_maps:
                maps = own_maps_of(self, [robot])
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
                f"table '{name}' was not recorded: the run's level is '{self.level}', only "
                "record='full' (explore --record full) keeps every table"
            )
        if self.path is None:
            frames = self._in_memory.get(name, [])
            how: Any = "diagonal" if name == "timing" else "vertical"
            return pl.concat(frames, how=how, rechunk=True) if frames else empty_table(name)
        whole = read_whole_table(self.path, name)
        if name == "attempts" and whole is None and not (self.path / TEXTS).exists():
            return empty_table(name)  # Nobody was asked, or the run is older than the table.
        if name in OWN_MAPS and not self.own_maps:
            return empty_table(name)
        if self.finished and whole is None:
            raise RunError(f"run '{self.path}' is damaged: its table '{name}' is missing")
        frame = read_table(self.path, name) if whole is None else whole
        if self.finished or name == "coverage":
            return frame
        # A part of coverage is written after the others: what lies beyond it is not whole.
        return frame.filter(pl.col("step") <= self.last_step)

    def _read_final_map(self) -> NDArray[np.int32]:
        if self._final_map is None:
            assert self.path is not None
            file, at_once = self.path / "map.npz", self.path / AT_ONCE
            if at_once.exists():
                file = at_once
            try:
                data = file.read_bytes()
            except FileNotFoundError:
                raise RunError(f"'{file}' is missing: the run is damaged") from None
            except OSError as error:
                raise RunError(f"cannot read '{file}': {error.strerror or error}") from None
            try:
                with np.load(io.BytesIO(data)) as arrays:
                    log_odds = np.asarray(arrays["log_odds"], dtype=np.int32)
                self._final_map = log_odds.reshape(self.frame.shape)
            except Exception:  # NumPy raises whatever zipfile, zlib or its own parser do.
                raise RunError(f"'{file}' is damaged: it is no map") from None
        return self._final_map


def _facts_of(folder: Path) -> dict[str, Any]:
    """What ``run.json`` says, checked."""
    if not folder.exists():
        raise RunError(f"run folder '{folder}' does not exist")
    if not folder.is_dir():
        raise RunError(f"'{folder}' is a file, not a run's folder")
    file = folder / "run.json"
    facts = _object_in(file)
    if facts is None:
        raise RunError(f"'{folder}' is no run: it has no run.json")
    if not isinstance(facts.get("format"), int):
        raise RunError(f"'{folder}' is no run: its run.json is something else's")
    if facts["format"] > FORMAT:
        newer = facts.get("version")
        raise RunError(f"'{folder}' was written by a newer swarmscout ({newer}): update this one")
    if facts.get("record") not in LEVELS:
        raise RunError(f"'{file}' is damaged: recording level {facts.get('record')!r} is unknown")
    return facts


def _object_in(file: Path) -> dict[str, Any] | None:
    """The object in a JSON file, or None when there is no such file."""
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except OSError as error:
        raise RunError(f"cannot read '{file}': {error.strerror or error}") from None
    except ValueError:
        raise RunError(f"'{file}' is damaged: it is no JSON") from None
    if not isinstance(data, dict):
        raise RunError(f"'{file}' is damaged: it holds no JSON object")
    return data
