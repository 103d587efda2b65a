"""The writer of runs: a recorder that keeps a mission in a folder, or in memory.

Rows gather in a ``row_buffer.Chunk``, which is written as a part every fifty steps. ``run.json``
appears when a mission has begun, ``summary.json`` when it has finished; each is put in place after
all files whose checksums it holds.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from swarmscout.core.errors import RunError
from swarmscout.core.recorder import StepRecord
from swarmscout.mission.scenario_files import scenario_toml
from swarmscout.recording import table_files
from swarmscout.recording.archive_rules import keep_rules
from swarmscout.recording.archive_world import keep_world
from swarmscout.recording.decisions import Texts, plain
from swarmscout.recording.json_files import RUN, SUMMARY, write_json
from swarmscout.recording.row_buffer import Chunk
from swarmscout.recording.run_folder import SCENARIO, as_path, claim_for_writing
from swarmscout.recording.tables import FORMAT, LEVELS, OWN_MAPS, PART_STEPS, check_level

if TYPE_CHECKING:
    import polars as pl

    from swarmscout.mission.mission import Mission
    from swarmscout.mission.scenario import Scenario
    from swarmscout.recording.run import Run
    from swarmscout.worlds.world import World

__all__ = ["RunWriter", "written_by"]

# A chunk of a huge swarm is closed sooner than after fifty steps: it stays below 100 MB or so.
_CHUNK_ROWS = 1_000_000


class RunWriter:
    """Keeps one mission.

    Args:
        folder: where to; it is created if need be and must be empty. None keeps all in memory.
        level: ``full``, ``curves`` or ``summary``: see :data:`swarmscout.recording.tables.LEVELS`.
        whole_world: keep the world's rasters even if the scenario names a world that it could be;
            for a mission that was given a world which differs in its start only.
        parts: write a part of all tables every fifty steps. Without, tables and final map are
            written at the end into one file: quicker, for missions that are run again when they
            are killed.

    Raises:
        RunError: the level is unknown.

    Example:
        >>> writer = RunWriter(None)
        >>> mission = Mission(Scenario(robots=3, steps=20), recorder=writer)  # doctest: +SKIP
        >>> summary = mission.run()  # doctest: +SKIP
        >>> writer.run().coverage["explored_m2"][-1]  # doctest: +SKIP
    """

    def __init__(
        self,
        folder: str | Path | None = None,
        *,
        level: str = "full",
        whole_world: bool = False,
        parts: bool = True,
    ) -> None:
        self.folder = None if folder is None else as_path(folder)
        self.level = check_level(level)
        self.last_step = -1
        """The last step that :meth:`record` has taken; -1 before the first."""
        self._whole_world = whole_world
        self._parts = parts
        self._scenario: Scenario | None = None
        self._world: World | None = None
        self._mission: Mission | None = None
        self._facts: dict[str, Any] = {}
        self._chunk: Chunk | None = None
        self._part = 0
        self._kept: dict[str, list[pl.DataFrame]] = {}
        self._final_map: dict[str, Any] | None = None
        self._summary: dict[str, Any] | None = None
        self._texts = Texts(self.folder)

    def begin(self, mission: Mission) -> None:
        """Make the folder and write what is known before the first step.

        Raises:
            RunError: the folder is not empty or cannot be written, or the writer was used before.
        """
        if self._scenario is not None:
            raise RunError("a RunWriter keeps one mission: make a new one for the next mission")
        robots = mission.scenario.robots
        lacking = {*(() if mission.asker else ("attempts",))}
        lacking |= {*(() if mission.own_maps else OWN_MAPS)}
        tables = [table for table in LEVELS[self.level] if table not in lacking]
        self._facts = {
            "format": FORMAT,
            **written_by(),
            "record": self.level,
            "tables": tables,
            "maps": "own" if mission.own_maps else "one",
            "by_hand": list(mission.by_hand),
            "robots": robots,
            "frame": plain(asdict(mission.frame)),
            "stations_m": plain(mission.stations_m),
        }
        if tables:
            every = mission.scenario.steps + 1
            most = PART_STEPS if self._parts else every
            steps = max(1, min(most, _CHUNK_ROWS // robots, every))
            self._parts = self._parts or steps < every
            self._chunk = Chunk(robots, steps, mission.frame.columns, tables)
        if self.folder is not None:
            self._begin_folder(self.folder, mission)
        self._scenario, self._world, self._mission = mission.scenario, mission.world, mission

    def _begin_folder(self, folder: Path, mission: Mission) -> None:
        claim_for_writing(folder)
        first = folder / SCENARIO
        try:
            scenario, world = keep_world(
                mission.world, mission.scenario, folder, whole=self._whole_world
            )
            scenario = keep_rules(scenario, mission.base, folder)
            text = scenario_toml(scenario, written_by()).encode()
            table_files.write_whole(first, text, sweep=False)
        except BaseException:
            if not first.stat().st_size:  # The claim alone: the folder is free again.
                first.unlink()
            raise
        sums = {SCENARIO: table_files.checksum(text)}
        if len(os.listdir(folder)) > 1:  # The world or a user's rules.
            for file in sorted(folder.rglob("*")):
                if file.is_file():
                    name = file.relative_to(folder).as_posix()
                    sums[name] = table_files.checksum(file.read_bytes())
        write_json(folder / RUN, {**self._facts, "world": world, "files": sums})

    def record(self, record: StepRecord) -> None:
        """Keep one step.

        Raises:
            RunError: a part cannot be written (the steps of earlier parts are kept).
        """
        chunk = self._chunk
        if chunk is not None:
            if record.decisions and "attempts" in self._facts["tables"]:
                self._texts.keep_all(record.decisions)
            if chunk.full:  # An earlier flush did not succeed.
                self._flush()
            chunk.add(record)
        self.last_step = record.step
        if chunk is not None and chunk.full:
            self._flush()

    def end(self, summary: Mapping[str, Any]) -> None:
        """Finish the run: the last part, the tables, the final map, and last the summary.

        Raises:
            RunError: something cannot be written; the run stays readable, as not finished.
        """
        assert self._mission is not None, "end() comes after begin()"
        self._flush()
        grid, frame = self._mission.map, self._mission.frame
        self._final_map = {"labels": grid.labels.copy(), "log_odds": grid.log_odds.copy()}
        self._summary = plain(summary)
        if self.folder is not None:
            origin = np.array([frame.origin_x_m, frame.origin_y_m])
            arrays = {**self._final_map, "origin_m": origin, "cell_m": np.array(frame.cell_m)}
            sums = self._write_data(self.folder, arrays)
            write_json(self.folder / SUMMARY, {**self._summary, "files": sums})
            if self._parts:
                table_files.remove_parts(self.folder)
        # Mission and writer hold each other: let go, so that many megabytes need no collector.
        self._mission = None

    def close(self) -> None:
        """Keep what was recorded of a mission that was broken off; harmless after :meth:`end`.

        The run is readable up to the last recorded step, and not finished.

        Raises:
            RunError: the last part cannot be written.
        """
        if self._mission is None or self._summary is not None:
            return
        self._flush()
        if self.folder is not None and not self._parts:
            self._write_data(self.folder, {})

    def run(self) -> Run:
        """The run, as far as it is recorded.

        Raises:
            RunError: no mission has begun yet.
        """
        from swarmscout.recording.run import Run

        if self._scenario is None or self._world is None:
            raise RunError("nothing is recorded yet: no mission has begun")
        if self.folder is not None:
            return Run.open(self.folder)
        self._flush()
        return Run.in_memory(
            scenario=self._scenario,
            facts=self._facts,
            world=self._world,
            summary=self._summary,
            tables=self._kept,
            texts=self._texts.kept,
            final_map=None if self._final_map is None else self._final_map["log_odds"],
        )

    def _flush(self) -> None:
        """Turn the chunk into a part. Repeating an interrupted flush is harmless."""
        if self._chunk is None or not self._chunk.length:
            return
        frames = self._chunk.frames()
        if self.folder is not None and self._parts:
            file = self.folder / "parts" / f"{self._part:06d}.zip"
            with contextlib.suppress(OSError):  # If it cannot be made, the next line says why.
                file.parent.mkdir(exist_ok=True)
            table_files.write_archive(file, frames, durable=False)
        else:
            for table, frame in frames.items():
                self._kept.setdefault(table, [])[self._part :] = [frame]
        self._part += 1
        self._chunk.clear()

    def _write_data(self, folder: Path, arrays: Mapping[str, Any]) -> dict[str, str]:
        """Give the tables and the final map the files in which they stay; returns checksums."""
        if self._parts:
            sums: dict[str, str] = {}
            for table in self._facts["tables"]:
                joined = table_files.join_parts(folder, table)
                sums |= table_files.write_tables(folder, {table: joined})
            sums[table_files.MAP] = table_files.write_archive(folder / table_files.MAP, {}, arrays)
            return sums
        frames = {table: frames[0] for table, frames in self._kept.items()}
        measured = frames.pop("timing", None)
        if measured is not None:
            table_files.write_archive(folder / table_files.TIMING, {"timing": measured})
        table_files.write_archive(folder / table_files.DATA, frames, arrays)
        return {}  # Archives hold their own.


def written_by() -> dict[str, Any]:
    """Version of the package and of the rules."""
    from swarmscout.core.version import package_version
    from swarmscout.mission.mission import RULES_VERSION

    return {"version": package_version(), "rules_version": RULES_VERSION}
