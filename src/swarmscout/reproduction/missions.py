"""Missions as the paper shows them: teams, the baseline over time, 50 and 100 robots."""

from __future__ import annotations

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from swarmscout.core.enums import FREE
from swarmscout.recording.run import Run
from swarmscout.reproduction.options import Options, run_mission, said_of
from swarmscout.studies.report_elements import Block, Picture, Table, Text
from swarmscout.viewing.drawing import add_legend, draw_map, draw_swarm, show_image
from swarmscout.viewing.palette import DARK, LIGHT, rgb
from swarmscout.viewing.replay import Moment, Replay

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
    replay = Replay(run)
    for at, step in enumerate((before, after)):
        axes = figure.add_subplot(1, 2, at + 1)
        draw_map(axes, replay, replay.moment(step), size=6.0, destinations=False)
        axes.set_title(f"step {step}", fontsize="small")
    add_legend(figure, axes, 6)
    sizes = sorted((len(team.members) for team in replay.moment(after).teams), reverse=True)
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
            f"Teams (circles) before and after robot {robot}, then green, leaves to charge at the "
            "green station. Robots without a circle are alone.",
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
    replay = Replay(run)
    area = replay.explored_m2
    for at, step in enumerate(moments):
        axes = figure.add_subplot(2, 2, at + 1)
        draw_map(axes, replay, replay.moment(step), size=4.0, teams=False)
        axes.set_title(f"step {step}: {area[step]:.0f} m² explored", fontsize="small")
    add_legend(figure, axes, 7)
    areas = ", ".join(f"{area[step]:.0f} m² at step {step}" for step in moments)
    return [
        Text(
            "**The paper:** with the baseline the explored free area grows while teams form and "
            f"dissolve. **Here:** {areas}: {_summary(run)['explored_fraction']:.1%} of what is "
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
    replay = Replay(run)
    _draw_truth(figure.add_subplot(), replay, replay.moment(replay.last))
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
    replay = Replay(run)
    moment = replay.moment(replay.last)
    _draw_truth(figure.add_subplot(1, 2, 1), replay, moment)
    axes = figure.add_subplot(1, 2, 2)
    draw_map(axes, replay, moment, size=2.5, teams=False)
    add_legend(figure, axes, 7)
    figure.suptitle(f"N = {robots}, {said_of(options)}", fontsize="medium", parse_math=False)
    teams = len(moment.teams)
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


def _draw_truth(axes: Axes, replay: Replay, moment: Moment) -> None:
    """The tube in black, the part of it that the swarm has mapped bright, and the robots."""
    run, world = replay.run, replay.run.world()
    rows, columns = np.nonzero(world.free)
    cells = run.frame.cells_of(world.frame.centres_of(np.column_stack([rows, columns])))
    mapped = moment.labels[cells[:, 0], cells[:, 1]] == FREE
    image = np.full((*world.free.shape, 3), rgb(LIGHT.unknown), dtype=np.uint8)
    image[rows, columns] = rgb(LIGHT.occupied)
    image[rows[mapped], columns[mapped]] = rgb(DARK.ground_high)
    show_image(axes, world.frame, image)
    draw_swarm(axes, moment, run.stations_m, size=3.0, teams=False, destinations=False)


def _first_to_charge(run: Run) -> tuple[int, int]:
    """The first robot that leaves a team in order to charge, and when; else the last step."""
    leaves = run.events.filter((pl.col("kind") == "leave") & (pl.col("step") > 10))
    modes = run.events.filter((pl.col("kind") == "mode") & (pl.col("other") == 1))
    both = leaves.join(modes.select("robot", "step"), on=["robot", "step"])
    chosen = both if both.height else modes
    if not chosen.height:
        return 0, run.last_step
    return int(chosen["robot"][0]), int(chosen["step"][0])


def _summary(run: Run) -> dict[str, float]:
    assert run.summary is not None
    return run.summary


def _explored(run: Run) -> str:
    summary = _summary(run)
    return f"{summary['explored_m2']:.0f} m², {summary['explored_fraction']:.0%} of the reachable"
