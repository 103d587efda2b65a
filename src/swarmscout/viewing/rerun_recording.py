"""A run for the Rerun viewer (extra ``rerun``), laid out like the player.

A ``.rrd`` file is an export and not an archive: only the minor version of Rerun that wrote it reads
it, and everything in it comes from the run.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import RunError, ViewError
from swarmscout.core.extras import install_command
from swarmscout.viewing.map_image import map_image
from swarmscout.viewing.palette import DARK, rgb
from swarmscout.viewing.relief import Relief, relief_of
from swarmscout.viewing.replay import Moment, Replay

if TYPE_CHECKING:
    from swarmscout.recording.run import Run

__all__ = ["check_rrd", "record_rrd", "show_rrd"]

DESTINATION, STATION = rgb(DARK.destination), rgb(DARK.charge)
SEEN, UNSEEN = rgb(DARK.ground_high), rgb(DARK.cut)
MOST_CELLS = 30_000
LIGHT_EVERY = 5
"""Steps between updates of the cave's lights, which are most of the file."""


def check_rrd(file: str | Path) -> Path:
    """Check that a recording can be written, before the mission runs.

    Returns:
        The file.

    Raises:
        ViewError: Rerun is not installed, or the file's name does not end in ``.rrd``.
        RunError: the file's folder is missing.
    """
    path = Path(file)
    if path.suffix != ".rrd":
        raise ViewError(f"'{path}': a Rerun recording's name ends in .rrd")
    try:
        import rerun  # noqa: F401
    except ImportError:
        raise ViewError(f"Rerun is not installed: {install_command('rerun')}") from None
    if not path.parent.is_dir():
        raise RunError(f"cannot write '{path}': folder '{path.parent}' does not exist")
    return path


def record_rrd(run: Run, file: str | Path) -> Path:
    """Write a run as a Rerun recording.

    Args:
        run: recorded with ``record="full"``.
        file: the recording; its name ends in ``.rrd``.

    Returns:
        The file.

    Raises:
        ViewError: Rerun is not installed, or the file's name does not end in ``.rrd``.
        RunError: the run cannot be shown, or the file cannot be written.
    """
    path = check_rrd(file)
    import rerun as rr

    replay = Replay(run)
    name = path.stem if run.path is None else run.path.resolve().name
    recording = rr.RecordingStream("swarmscout", recording_id=name, send_properties=False)
    try:
        path.touch()
    except OSError as error:
        raise RunError(f"cannot write '{path}': {error.strerror or error}") from None
    relief = relief_of(run.world(), MOST_CELLS)
    recording.save(path, default_blueprint=_layout(replay, relief))
    cells = _mesh(rr, recording, relief)
    frame = run.frame
    at = frame.cells_of(relief.frame.centres_of(cells))
    at = np.clip(at, 0, np.array(frame.shape) - 1)
    recording.log("cave", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    stations = _raised(run.stations_m, relief, 0.3)
    recording.log("cave/stations", rr.Points3D(stations, colors=STATION, radii=0.5), static=True)
    height = frame.rows * frame.cell_m
    for step in range(replay.last + 1):
        moment = replay.moment(step)
        recording.set_time("step", sequence=step)
        if step % LIGHT_EVERY == 0 or step == replay.last:
            known = moment.labels[at[:, 0], at[:, 1]] != 0
            lights = np.where(known[:, None], SEEN, UNSEEN).astype(np.uint8)
            recording.log("cave/ground", rr.Mesh3D.from_fields(vertex_colors=lights))
        _log_swarm(rr, recording, moment, relief)
        recording.log("cave/robots", rr.AnyValues(False, **_recorded(run, step)))
        image = map_image(moment.labels, run.scenario.map.frontier_neighbours, DARK)
        # Rerun's 2D views have y downward: the highest row comes first.
        recording.log("map/grid", rr.Image(image[::-1]))
        places = (moment.place_m - (frame.origin_x_m, frame.origin_y_m)) / frame.cell_m
        places[:, 1] = height / frame.cell_m - places[:, 1]
        recording.log("map/robots", rr.Points2D(places, colors=_colours(moment), radii=0.6))
        recording.log("curves/explored_m2", rr.Scalars(moment.explored_m2))
        teams = sum(len(team.members) > 0 for team in moment.teams)
        recording.log("curves/teams", rr.Scalars(float(teams)))
    for row in run.decisions.iter_rows(named=True):
        recording.set_time("step", sequence=row["step"])
        words = f"robot {row['leader']}: {row['cause']}, {row['reason'][:2000]}"
        recording.log("decisions", rr.TextLog(words))
    recording.flush()
    recording.disconnect()
    return path


def show_rrd(file: Path) -> int:
    """Open a recording in Rerun's window, and wait until it is closed.

    The native window is used, with its server bound to loopback: Rerun's server listens on every
    interface by default, and its web page makes the browser call other hosts.

    Returns:
        The viewer's exit code.
    """
    address = ["--bind", "127.0.0.1", "--port", "auto"]
    return subprocess.call([sys.executable, "-m", "rerun", *address, str(file)])


def _layout(replay: Replay, relief: Relief) -> Any:
    """The cave large, seen from above; the map, curves and decisions beside it."""
    import rerun.blueprint as rrb

    left, right, bottom, top = replay.window()
    middle = _raised(np.array([[(left + right) / 2, (bottom + top) / 2]]), relief, 0.0)[0]
    far = max(12.0, right - left, 1.4 * (top - bottom))
    above = middle + np.array([0.0, -0.6 * far, 0.9 * far])
    eye = rrb.EyeControls3D(position=above, look_target=middle, eye_up=(0.0, 0.0, 1.0))
    frame = replay.run.frame
    x = (np.array([left, right]) - frame.origin_x_m) / frame.cell_m
    y = frame.rows - (np.array([top, bottom]) - frame.origin_y_m) / frame.cell_m
    bounds = rrb.VisualBounds2D(x_range=x, y_range=y)
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Spatial3DView(
                origin="cave",
                name="Cave",
                eye_controls=eye,
                line_grid=rrb.LineGrid3D(visible=False),
            ),
            rrb.Vertical(
                rrb.Spatial2DView(origin="map", name="Map", visual_bounds=bounds),
                rrb.TimeSeriesView(origin="curves", name="Explored area (m²), teams"),
                rrb.TextLogView(origin="decisions", name="Decisions"),
            ),
            column_shares=[2, 1],
        ),
        rrb.TimePanel(timeline="step", state="collapsed"),
        collapse_panels=True,
    )


def _mesh(rr: Any, recording: Any, relief: Relief) -> NDArray[np.int64]:
    """Log the cave's shape; returns the relief's cell [n, 2] at each corner."""
    cells = np.argwhere(relief.shown)
    number = np.full(relief.shown.shape, -1, dtype=np.int64)
    number[relief.shown] = np.arange(len(cells))
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    whole = (a >= 0) & (b >= 0) & (c >= 0) & (d >= 0)
    a, b, c, d = a[whole], b[whole], c[whole], d[whole]
    corners = relief.frame.centres_of(cells)
    heights = relief.height_m()[cells[:, 0], cells[:, 1]]
    slope_y, slope_x = np.gradient(relief.height_m(), relief.frame.cell_m)
    normals = np.stack([-slope_x, -slope_y, np.ones_like(slope_x)], axis=-1)
    normals = normals[cells[:, 0], cells[:, 1]]
    recording.log(
        "cave/ground",
        rr.Mesh3D(
            vertex_positions=np.column_stack([corners, heights]),
            vertex_normals=normals / np.linalg.norm(normals, axis=1, keepdims=True),
            triangle_indices=np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)]),
        ),
        static=True,
    )
    return cells


def _recorded(run: Run, step: int) -> dict[str, list[Any]]:
    """What is recorded of each robot in a step: the viewer shows it for a selected robot."""
    robots = run.scenario.robots
    rows = run.steps.slice(step * robots, robots).drop("step", "robot")
    return {name: rows[name].to_list() for name in rows.columns}


def _log_swarm(rr: Any, recording: Any, moment: Moment, relief: Relief) -> None:
    places = _raised(moment.place_m, relief, 0.15)
    recording.log("cave/robots", rr.Points3D(places, colors=_colours(moment), radii=0.3))
    facing = np.column_stack([np.cos(moment.heading_rad), np.sin(moment.heading_rad)])
    ahead = _raised(moment.place_m + 0.6 * facing, relief, 0.15) - places
    recording.log(
        "cave/headings",
        rr.Arrows3D(origins=places, vectors=ahead, colors=_colours(moment), radii=0.08),
    )
    goals = [team for team in moment.teams if team.destination_m is not None]
    ends = np.array([team.destination_m for team in goals]).reshape(-1, 2)
    starts = moment.place_m[[team.leader for team in goals]]
    lines = np.stack([_raised(starts, relief, 0.3), _raised(ends, relief, 0.3)], axis=1)
    recording.log("cave/links", rr.LineStrips3D(lines, colors=DESTINATION, radii=0.05))
    recording.log("cave/destinations", rr.Points3D(lines[:, 1], colors=DESTINATION, radii=0.35))


def _colours(moment: Moment) -> NDArray[np.uint8]:
    return np.array([rgb(colour) for colour in DARK.robots], dtype=np.uint8)[moment.robot_kinds]


def _raised(points_m: NDArray[np.float64], relief: Relief, rise_m: float) -> NDArray[np.float64]:
    """Points [n, 2] on the floor as points [n, 3] a little above it."""
    return np.column_stack([points_m, relief.ground_at(points_m) + rise_m])
