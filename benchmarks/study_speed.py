"""What running a study costs besides its missions.

    python benchmarks/study_speed.py [--missions 1000] [--jobs 2] [--memory 10000]

1. A worker's share (recording curves, writing files), for a sample of missions: least CPU time of
   repeats, in one process.
2. A study of N = 15 and 300 steps: wall time, and CPU time of all processes, starts included.
3. The report of that study: wall time.
4. The parent's memory while 10,000 results arrive from an engine that runs nothing.
"""

from __future__ import annotations

import argparse
import os
import resource
import tempfile
import time
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from pathlib import Path

from swarmscout import Mission, load_world
from swarmscout.studies.engines import LocalEngine
from swarmscout.studies.report import write_report
from swarmscout.studies.scheduler import run_study
from swarmscout.studies.study import Study
from swarmscout.studies.worker import Outcome, Task, run_task

STUDY = """
name = "speed"
question = "How fast is the machinery?"
trials = {trials}
compare = {{ axis = "destinations", baseline = "quantile" }}

[scenario]
world = "lava-tube"

[axes]
destinations = ["quantile", "nearest"]
world_seed = [0, 1, 2, 3, 4]
"""


def cpu_s() -> float:
    """CPU time of this process and of its children that have ended."""
    own, children = (
        resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


def per_mission_s(study: Study, folder: Path, sample: int, repeats: int) -> tuple[float, float]:
    """CPU seconds of a mission, bare and in a worker; each the least of repeats."""
    chosen = study.missions[:: max(1, len(study.missions) // sample)][:sample]
    scenarios = [study.scenario(mission) for mission in chosen]
    worlds = {s.world_seed: load_world(s.world, s.world_seed) for s in scenarios}
    bare, whole = [float("inf")] * len(chosen), [float("inf")] * len(chosen)
    for repeat in range(repeats + 1):
        for at, (mission, scenario) in enumerate(zip(chosen, scenarios, strict=True)):
            began = time.process_time()
            Mission(scenario, world=worlds[scenario.world_seed]).run()
            bare[at] = min(bare[at], time.process_time() - began)
            task = Task(mission.name, scenario, str(folder / f"{mission.name}-{repeat}"), "curves")
            began = time.process_time()
            outcome = run_task(task)
            if repeat:  # The first loads the world.
                whole[at] = min(whole[at], time.process_time() - began)
            if outcome.error is not None:
                raise SystemExit(outcome.error)
    return sum(bare) / len(bare), sum(whole) / len(whole)


class Instant(Executor):
    """An executor that runs nothing: every task has already succeeded."""

    def submit(self, function, task):  # type: ignore[no-untyped-def, override]
        """A future that is done."""
        future: Future[Outcome] = Future()
        future.set_result(Outcome(task.name, explored_m2=1.0))
        return future


class InstantEngine:
    """An engine whose time is all the parent's."""

    width = 2

    @contextmanager
    def open(self):  # type: ignore[no-untyped-def]
        """The executor."""
        yield Instant()


def memory_mb() -> float:
    """Resident memory of this process."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def make(folder: Path, trials: int, name: str) -> Study:
    """A study of ten missions a trial."""
    file = folder / f"{name}.toml"
    file.write_text(STUDY.format(trials=trials), encoding="utf-8")
    return Study.load(file, folder / name)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--missions", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--memory", type=int, default=10_000)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "one").mkdir()
        study = make(folder, max(1, arguments.missions // 10), "speed")
        n = len(study.missions)
        bare, whole = per_mission_s(study, folder / "one", 20, 8)
        print(
            f"a mission bare {1e3 * bare:.1f} ms, in a worker {1e3 * whole:.1f} ms of CPU", end=""
        )
        print(f" (least of 8, mean of 20 missions): {whole / bare - 1:.0%} more", flush=True)
        began, cpu = time.perf_counter(), cpu_s()
        run_study(study, LocalEngine(arguments.jobs))
        wall, cpu = time.perf_counter() - began, cpu_s() - cpu
        print(
            f"{n} missions on {arguments.jobs} processes: {wall:.1f} s, {n / wall:.1f} per second"
        )
        print(f"CPU of all processes: {cpu:.1f} s, {1e3 * cpu / n:.1f} ms a mission")
        began = time.perf_counter()
        write_report(study)
        print(f"report: {time.perf_counter() - began:.1f} s", flush=True)

        study = make(folder, arguments.memory // 10, "memory")
        seen: list[tuple[int, float]] = []
        ended = 0

        def watch(mission: object, outcome: Outcome) -> None:
            nonlocal ended
            ended += 1
            if ended % 1000 == 0:
                seen.append((ended, memory_mb()))

        began = time.perf_counter()
        run_study(study, InstantEngine(), listener=watch)
        each = (time.perf_counter() - began) / ended
        print(f"{ended} results: {1e3 * each:.2f} ms of the parent each; memory in MB:", end=" ")
        print(", ".join(f"{count}: {mb:.1f}" for count, mb in seen))


if __name__ == "__main__":
    main()
