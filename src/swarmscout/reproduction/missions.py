"""Missions as the paper shows them: teams, the baseline over time, 50 and 100 robots."""

from __future__ import annotations

import numpy as np
import polars as pl
from matplotlib.figure import Figure
from numpy.typing import NDArray

from swarmscout.core.enums import FREE
from swarmscout.recording.run import Run
from swarmscout.reproduction.drawing import draw_map, draw_robots, known_window, robots_at
from swarmscout.reproduction.options import Options, run_mission, said_of
from swarmscout.studies.report_elements import Block, Picture, Table, Text
from swarmscout.viewing.map_picture import labels_at

__all__ = ["baseline", "scale_50", "scale_100", "team_formation"]


# Far from the stations a charge must last longer than in the small: three times the default.
_WIDE = {"world": "lava-tube-wide", "start": "spread", "battery.capacity_steps": 1200}


def team_formation(options: Options) -> list[Block]:
    """Self-organized teams, and a robot that leaves its team to charge."""
    small = {"robots": 8, "steps": 120, "battery.start_min": 0.3} if options.quick else {}
    run = run_mission(options, "run", {"robots": 15, "steps": 300, "seed": 0, **small})
    robot, left = _first_to_charge(run)
    before, after = max(0, left - 10), min(run.last_step, left + 10)
    figure = Figure(figsize=(9.6, 5.0), layout="constrained")
    windows = [known_window(run, step) for step in (before, after)]
    window = (
        min(w[0] for w in windows), max(w[1] for w in windows),
        min(w[2] for w in windows), max(w[3] for w in windows),
    )  # fmt: skip
    for at, step in enumerate((before, after)):
        axes = figure.add_subplot(1, 2, at + 1)
        draw_map(axes, run, step, window)
        draw_robots(axes, run, step, teams=True, destinations=False)
        axes.set_title(f"step {step}", fontsize="small")
    sizes = _sizes(run, after)
    joins = run.events.filter(pl.col("kind") == "join").height
    return [
        Text(
            "**The paper:** 15 robots form teams by themselves; a robot in CHR mode leaves its "
            f"team and goes to the station. **Here:** {run.scenario.robots} robots with desired "
            f"size {run.scenario.teams.desired_size}; robot {robot} leaves its team at step "
            f"{left}. At step {after} there are teams of {', '.join(map(str, sizes))}."
        ),
        Picture(
            "team-formation", figure,
            f"Teams (red circles) before and after robot {robot}, then green, leaves to charge at "
            "the green station. Robots without a circle are on their own.",
        ),
        Table(
            ["over the whole mission", ""],
            [
                ["robots that changed team by joining", str(joins)],
                ["robots that left a team", str(_summary(run)["leaves"])],
                ["robots back from charging", str(_summary(run)["charges"])],
                ["robots stranded", str(_summary(run)["stranded"])],
            ],
        ),
    ]  # fmt: skip


def baseline(options: Options) -> list[Block]:
    """The explored area grows over time, by the baseline: four moments."""
    last = 60 if options.quick else 300
    robots = 6 if options.quick else 15
    run = run_mission(options, "run", {"robots": robots, "steps": last, "seed": 0})
    moments = [last // 15, last // 3, 2 * last // 3, last]
    figure = Figure(figsize=(9.6, 7.6), layout="constrained")
    window = known_window(run, last)
    area = run.coverage["explored_m2"]
    for at, step in enumerate(moments):
        axes = figure.add_subplot(2, 2, at + 1)
        draw_map(axes, run, step, window)
        draw_robots(axes, run, step)
        axes.set_title(f"step {step}: {area[step]:.0f} m² explored", fontsize="small")
    told = ", ".join(f"{area[step]:.0f} m² at step {step}" for step in moments)
    return [
        Text(
            "**The paper:** with the baseline the explored free area grows while teams form and "
            f"dissolve. **Here:** {told}: {_summary(run)['explored_fraction']:.1%} of what is "
            f"reachable in `{run.scenario.world}`. From one place the baseline is slow: the "
            "comparison with other rules says how slow."
        ),
        Picture(
            "baseline", figure,
            f"One mission of {run.scenario.robots} robots by the baseline (`quantile`) at four "
            "moments: white is explored, gray unknown, black obstacles, green frontiers.",
        ),
    ]  # fmt: skip


def scale_50(options: Options) -> list[Block]:
    """Fifty robots by the baseline."""
    robots, steps = (12, 60) if options.quick else (50, 400)
    run = run_mission(options, "run", {"robots": robots, "steps": steps, **_WIDE})
    figure = Figure(figsize=(8.4, 7.0), layout="constrained")
    _draw_truth(figure.add_subplot(), run, run.last_step)
    return [
        Text(
            "**The paper:** 50 robots explore a wide area by the baseline; black is the lava tube, "
            f"bright what was explored. **Here:** {robots} robots, {run.last_step} steps, from a "
            f"spread start, with charge for {_WIDE['battery.capacity_steps']}: {_explored(run)}."
        ),
        Picture(
            "scale-50", figure,
            f"{robots} robots (red dots) after {run.last_step} steps: black is the tube as it is, "
            "bright what they explored of it.",
        ),
    ]  # fmt: skip


def scale_100(options: Options) -> list[Block]:
    """A hundred robots with the paper's language model, or what stands in its place."""
    robots, steps = (16, 50) if options.quick else (100, 400)
    run = run_mission(options, "run", {"robots": robots, "steps": steps, **options.keys, **_WIDE})
    figure = Figure(figsize=(11.0, 5.6), layout="constrained")
    _draw_truth(figure.add_subplot(1, 2, 1), run, run.last_step)
    axes = figure.add_subplot(1, 2, 2)
    draw_map(axes, run, run.last_step, known_window(run, run.last_step))
    draw_robots(axes, run, run.last_step, size=2.5)
    figure.suptitle(f"N = {robots}, {said_of(options)}", fontsize="medium")
    robots_now = robots_at(run, run.last_step)
    teams = len(np.unique(robots_now["team"][robots_now["mode"] == "EXP"]))
    return [
        Text(
            "**The paper:** 100 robots, teams led by a language model; the simulator, and beside "
            f"it the map with the teams' targets. **Here:** {robots} robots {said_of(options)}; "
            f"{run.last_step} steps from a spread start: {_explored(run)}, {teams} teams at the "
            "end."
        ),
        Picture(
            "scale-100", figure,
            f"{robots} robots after {run.last_step} steps, {said_of(options)}. Left the tube as it "
            "is (black) and what was explored (bright); right the swarm's own map, with purple "
            "rings round the teams' targets.",
        ),
    ]  # fmt: skip


def _draw_truth(axes, run: Run, step: int) -> None:  # type: ignore[no-untyped-def]
    """The tube in black, what the swarm knows to be free of it bright, robots as red dots."""
    world = run.world()
    known = labels_at(run, step) == FREE
    centres = world.frame.centres_of(np.argwhere(world.free > 0))
    cells = run.frame.cells_of(centres)
    picture = np.full((*world.free.shape, 3), 0.55)
    rows, columns = np.nonzero(world.free)
    picture[rows, columns] = 0.0
    bright = known[cells[:, 0], cells[:, 1]]
    picture[rows[bright], columns[bright]] = (0.93, 0.9, 0.78)
    axes.imshow(picture, origin="lower", extent=world.extent, interpolation="nearest")
    axes.tick_params(labelsize="x-small")
    draw_robots(axes, run, step, destinations=False, size=3.0)


def _first_to_charge(run: Run) -> tuple[int, int]:
    """The first robot that leaves a team in order to charge, and when; else the last step."""
    leaves = run.events.filter((pl.col("kind") == "leave") & (pl.col("step") > 10))
    modes = run.events.filter((pl.col("kind") == "mode") & (pl.col("other") == 1))
    both = leaves.join(modes.select("robot", "step"), on=["robot", "step"])
    chosen = both if both.height else modes
    if not chosen.height:
        return 0, run.last_step
    return int(chosen["robot"][0]), int(chosen["step"][0])


def _sizes(run: Run, step: int) -> list[int]:
    robots = robots_at(run, step)
    exploring: NDArray[np.int64] = robots["team"][robots["mode"] == "EXP"]
    return sorted(np.unique(exploring, return_counts=True)[1].tolist(), reverse=True)


def _summary(run: Run) -> dict[str, float]:
    assert run.summary is not None
    return run.summary


def _explored(run: Run) -> str:
    summary = _summary(run)
    return f"{summary['explored_m2']:.0f} m², {summary['explored_fraction']:.0%} of the reachable"
