"""A world out of a cave's mesh.

Columns through the mesh become spans of room over a floor; a flood through the spans from the start
finds one floor per cell; what stands out of its ground, is steep, low or cut off is left out.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import WorldError
from swarmscout.core.grid import GridFrame
from swarmscout.worlds.arrays import world_from_array
from swarmscout.worlds.meshes.alignment import Alignment, align, with_ground
from swarmscout.worlds.meshes.cleaning import Cleaned, cleaned
from swarmscout.worlds.meshes.drivable import Drivable, check_not_inside_walls, drivable
from swarmscout.worlds.meshes.files import read_mesh_file
from swarmscout.worlds.meshes.flood_fill import FloodedFloor, flood_fill
from swarmscout.worlds.meshes.level_selection import SelectedLevel, select_level
from swarmscout.worlds.meshes.mesh import Mesh
from swarmscout.worlds.meshes.report import ImportReport, passage_widths_m
from swarmscout.worlds.meshes.span_graph import build_span_graph
from swarmscout.worlds.meshes.span_heightfield import Spans, find_spans
from swarmscout.worlds.meshes.walls import find_walls
from swarmscout.worlds.reachability import reachable
from swarmscout.worlds.resampling import FINEST_CELLS, check_length
from swarmscout.worlds.world import World

__all__ = ["CLEARANCE_M", "import_mesh", "import_mesh_with_report"]

CLEARANCE_M = 0.4
"""A robot needs so much room over the floor."""
STEP_M = 0.15
_RESOLUTION_M = 0.1
_SMALL_M, _LONG_M, _USUAL_M = 2.0, 1000.0, 30.0
"""A place for robots of 0.3 m that is smaller or larger may be given in another unit."""
_ABSURD_M = 1e9
_ROOF_M, _FLAT_M = 1.8, 0.1
"""A level floor so high above everything else may be the top of a building's roof."""
Progress = Callable[[str, float], None]


def import_mesh(
    path: str | Path,
    *,
    up: str | None = None,
    scale: float | None = None,
    start_m: Sequence[float] | None = None,
    roof: bool | None = None,
    resolution_m: float | None = None,
    step_height_m: float | None = None,
    ground_m: float | str | None = None,
    progress: Progress | None = None,
) -> World:
    """Make a world of a cave's mesh.

    The mesh may be open, have holes and several shells, and its triangles may be doubled or face
    any way.

    Args:
        path: an OBJ, STL, PLY, GLB, glTF, DAE or OFF file.
        up: ``"z"``, ``"y"`` or ``"x"``, the axis of the mesh that points up; None: guessed from its
            surfaces.
        scale: metres per unit of the file; None: as the file says, or 1.
        start_m: ``(x, y)`` or ``(x, y, z)`` in metres, in the mesh's frame with z up; None: a roomy
            place of the largest floor.
        roof: whether floor must lie under a ceiling; None: found out.
        resolution_m: edge of a raster cell; None for 0.1.
        step_height_m: most difference in height between neighbouring cells; None for 0.15.
        ground_m: height of a level ground that is added under a mesh without a floor, in metres in
            the mesh's frame with z up; ``"lowest"`` for its lowest point; None: nothing is added.
        progress: called with the present stage and the share of it that is done, 0 to 1.

    Returns:
        The world: rasters of free cells, ground and ceiling, a start, the mesh in the world's
        frame; ``source`` says what was decided.

    Raises:
        WorldError: the file cannot be read, an option is impossible, the mesh has an implausible
            size, or it has no floor that can be driven.

    Example:
        >>> import_mesh("cave.ply", scale=0.001).start_m  # doctest: +SKIP
        (12.35, 3.05)
    """
    return import_mesh_with_report(
        path, up=up, scale=scale, start_m=start_m, roof=roof, resolution_m=resolution_m,
        step_height_m=step_height_m, ground_m=ground_m, progress=progress,
    )[0]  # fmt: skip


def import_mesh_with_report(
    path: str | Path,
    *,
    up: str | None = None,
    scale: float | None = None,
    start_m: Sequence[float] | None = None,
    roof: bool | None = None,
    resolution_m: float | None = None,
    step_height_m: float | None = None,
    ground_m: float | str | None = None,
    progress: Progress | None = None,
) -> tuple[World, ImportReport]:
    """The same as :func:`import_mesh`, with a report of what was found, decided and left out."""
    began = time.perf_counter()
    path = Path(path)
    say = progress or _silent
    cell_m = _number("resolution_m", resolution_m, _RESOLUTION_M)
    step_m = _number("step_height_m", step_height_m, STEP_M)
    start = _checked(start_m, cell_m, step_m)
    # On coarse cells a slope that can be driven is a high step.
    step_m = max(step_m, math.tan(math.radians(30.0)) * cell_m)

    say("reading", 0.0)
    file = read_mesh_file(path)
    say("cleaning", 0.0)
    clean = cleaned(file.vertices, file.triangles)
    _check_rest(path, len(file.triangles), clean)
    frame_of = align(file, clean.vertices, clean.triangles, up, scale)
    triangles = clean.triangles
    if ground_m is not None:
        frame_of, triangles = with_ground(frame_of, triangles, ground_m)
    sha256, crossing = file.sha256, file.crossing
    del file
    frame, corners = _raster(path, frame_of, cell_m)
    if start is not None:
        start = tuple(part - off for part, off in zip(start, frame_of.offset_m, strict=False))

    try:
        spans, reached, chosen, floor = _find_floor(
            corners, triangles, frame, step_m, roof, start, say
        )
    except WorldError as error:
        raise WorldError(f"mesh '{path}': {error}{_moved(frame_of)}{_hint(frame_of)}") from None
    mesh = Mesh(frame_of.vertices_m.astype(np.float32), triangles)
    origin = reached.frame.origin_x_m, reached.frame.origin_y_m
    source = _source(path, sha256, frame_of, cell_m, step_m, chosen.roof)
    if ground_m is not None:
        source["ground_m"] = ground_m
    notes = _notes(crossing, floor, frame_of)
    if notes:
        source["notes"] = "; ".join(notes)
    world = world_from_array(
        floor.free,
        cell_m,
        name=path.stem or "mesh",
        origin_m=origin,
        start_m=floor.start_m,
        ground_m=_frozen(floor.ground_m),
        ceiling_m=None if floor.ceiling_m is None else _frozen(floor.ceiling_m),
        mesh=mesh,
        source=source,
    )
    say("measuring", 0.0)
    report = _report(path, world, clean, frame_of, spans, reached, chosen, floor, start is None)
    say("measuring", 1.0)
    seconds = time.perf_counter() - began
    return world, dataclasses.replace(report, notes=notes, seconds=seconds)


def _find_floor(
    corners: NDArray[np.float64],
    triangles: NDArray[np.int32],
    frame: GridFrame,
    step_m: float,
    roof: bool | None,
    start: tuple[float, ...] | None,
    say: Progress,
) -> tuple[Spans, FloodedFloor, SelectedLevel, Drivable]:
    """All floors of a mesh, the flooded one, how it was selected, and what of it can be driven.

    Raises:
        WorldError: no floor can be driven, or none that is likely to be meant.
    """
    spans = find_spans(
        corners, triangles, frame, CLEARANCE_M, lambda share: say("cutting columns", share)
    )
    if not len(spans.cell):
        raise WorldError(
            f"no floor that can be driven: {spans.hit:,} columns meet a surface, and none has "
            f"{CLEARANCE_M:g} m of room over a floor; a building without one needs --ground-plane"
        )
    walls = find_walls(
        corners, triangles, frame, CLEARANCE_M, lambda share: say("finding walls", share)
    )
    say("flooding", 0.0)
    graph = build_span_graph(spans, walls, frame, step_m, CLEARANCE_M)
    del walls
    chosen = select_level(spans, graph, frame, roof, start)
    say("flooding", 0.5)
    reached = flood_fill(spans, graph, frame, chosen.members, chosen.start, chosen.roof)
    del graph
    say("finding the ground", 0.0)
    floor = drivable(reached, chosen.roof, start)
    if roof is None and start is None:
        check_not_inside_walls(spans, frame, floor)
    return spans, reached, chosen, floor


def _notes(crossing: int, floor: Drivable, at: Alignment) -> tuple[str, ...]:
    """Properties of the mesh that may be unintended, one line each."""
    notes = []
    if crossing:
        notes.append(f"{crossing:,} polygons cross themselves: their surface is ambiguous")
    heights = floor.ground_m[floor.free]
    above = float(np.median(heights)) - float(at.vertices_m[:, 2].min())
    if floor.ceiling_m is None and above > _ROOF_M and float(np.std(heights)) < _FLAT_M:
        notes.append(
            f"the floor is level and {above:.1f} m above the lowest point of the mesh: if it is "
            "the top of a roof, add the ground under it (--ground-plane)"
        )
    return tuple(notes)


def _silent(_: str, __: float) -> None:
    pass


def _frozen(heights: NDArray[np.float32]) -> NDArray[np.float32]:
    heights.setflags(write=False)
    return heights


def _number(name: str, given: float | None, default: float) -> float:
    try:
        return default if given is None else float(given)
    except (TypeError, ValueError):
        raise WorldError(f"{name} = {given!r}: expected metres, as {default:g}") from None


def _checked(
    start_m: Sequence[float] | None, cell_m: float, step_m: float
) -> tuple[float, ...] | None:
    """The start as a tuple; impossible options are refused."""
    check_length("resolution_m", cell_m)
    if not 0.0 < step_m < CLEARANCE_M:
        raise WorldError(
            f"step_height_m = {step_m:g}: expected metres above 0 and below {CLEARANCE_M:g}, the "
            "room that a robot needs over the floor"
        )
    if start_m is None:
        return None
    try:
        start = tuple(float(part) for part in start_m)
    except (TypeError, ValueError):
        start = ()
    if len(start) not in (2, 3) or not all(math.isfinite(part) for part in start):
        raise WorldError(f"start_m = {start_m!r}: expected x, y or x, y, z in metres")
    return start


def _check_rest(path: Path, count: int, clean: Cleaned) -> None:
    if len(clean.triangles):
        return
    raise WorldError(
        f"mesh '{path}' has no usable triangle: of {count:,} triangles {clean.not_finite:,} "
        f"have a corner that is not a finite number, and {clean.degenerate:,} have no area"
    )


def _raster(path: Path, at: Alignment, cell_m: float) -> tuple[GridFrame, NDArray[np.float64]]:
    """A raster round the mesh, and its vertices in cells: a cell's centre is a whole number."""
    low, high = at.vertices_m.min(axis=0), at.vertices_m.max(axis=0)
    size = high - low
    if max(size[0], size[1]) < 2.0 * cell_m or not np.isfinite(size).all():
        raise WorldError(f"mesh '{path}' is {_size(size)} large: nothing to explore{_hint(at)}")
    # Lines between cells lie on multiples of the cell's edge, wherever the mesh begins.
    first = np.floor(low[:2] / cell_m) - 2.0
    count = np.ceil(high[:2] / cell_m) + 2.0 - first
    cells = float(np.sqrt(count).prod()) ** 2 if size.max() < _ABSURD_M else math.inf
    if cells > FINEST_CELLS:
        square_m = min(float(np.sqrt(size[:2]).prod()), _ABSURD_M)
        coarse = math.ceil(square_m / math.sqrt(FINEST_CELLS) * 1.02 * 100.0) / 100.0
        remedy = f"take cells of {coarse:g} m or more (resolution_m)" if coarse <= 1.0 else ""
        raise WorldError(
            f"mesh '{path}' is {_size(size)} large: at {cell_m:g} m a raster of {count[1]:,.6g} × "
            f"{count[0]:,.6g} cells is too large (limit {FINEST_CELLS:,} cells): "
            f"{remedy or 'cut the mesh'}{_hint(at)}"
        )
    columns, rows = (int(part) for part in count)
    frame = GridFrame(
        round(float(first[0]) * cell_m, 9),
        round(float(first[1]) * cell_m, 9),
        cell_m,
        rows,
        columns,
    )
    corners = at.vertices_m.copy()
    corners[:, :2] = corners[:, :2] / cell_m - first - 0.5
    return frame, corners


def _size(size: NDArray[np.float64]) -> str:
    few = (f"{x:,.0f}" if 10 <= x < _ABSURD_M else f"{x:,.4g}" for x in size.tolist())
    return " × ".join(few) + " m"


def _moved(at: Alignment) -> str:
    """The frame of the coordinates in an error, where it is not the mesh's own."""
    if not any(at.offset_m):
        return ""
    x, y, z = at.offset_m
    return f" (all of these in the world's frame: the mesh's less {x:.0f}, {y:.0f}, {z:.0f} m)"


def _hint(at: Alignment) -> str:
    """What may be wrong with the unit, where the size is not that of a place for robots."""
    longest = float(np.ptp(at.vertices_m, axis=0).max())
    if _SMALL_M <= longest <= _LONG_M:
        return ""
    units = {"millimetres": 0.001, "centimetres": 0.01, "kilometres": 1000.0}
    sizes = {name: longest * unit / at.scale for name, unit in units.items()}
    likely = min(sizes, key=lambda name: abs(math.log(max(sizes[name], 1e-300) / _USUAL_M)))
    if units[likely] == at.scale or not _SMALL_M <= sizes[likely] <= _LONG_M:
        return ""
    return f"; if the file is in {likely}, say so with scale {units[likely]:g}"


def _source(
    path: Path, sha256: str, at: Alignment, cell_m: float, step_m: float, roof: bool
) -> dict[str, Any]:
    facts: dict[str, Any] = {
        "file": path.name, "sha256": sha256, "up": at.up, "scale": at.scale, "roof": roof,
        "resolution_m": cell_m, "step_height_m": step_m, "clearance_m": CLEARANCE_M,
    }  # fmt: skip
    if any(at.offset_m):
        facts |= {f"offset_{axis}_m": off for axis, off in zip("xyz", at.offset_m, strict=True)}
    return facts


def _report(
    path: Path,
    world: World,
    clean: Cleaned,
    at: Alignment,
    spans: Spans,
    reached: FloodedFloor,
    chosen: SelectedLevel,
    floor: Drivable,
    proposed: bool,
) -> ImportReport:
    cell_m2 = world.resolution_m**2
    meant = np.isfinite(spans.ceiling_m) if chosen.roof else slice(None)
    ordered = spans.cell[meant]
    cells = int(np.count_nonzero(np.diff(ordered))) + min(len(ordered), 1)
    taken = int(np.count_nonzero(~np.isnan(reached.floor_m)))
    decisions = {
        "up axis": f"{at.up} ({at.up_because})",
        "unit": f"{at.scale:g} m ({at.scale_because})",
        "roof": f"{'yes' if chosen.roof else 'no'} ({chosen.roof_because})",
    }
    if any(at.offset_m):
        x, y, z = at.offset_m
        decisions["shifted"] = (
            f"by {-x:,.0f}, {-y:,.0f}, {-z:,.0f} m: so far from its origin a mesh loses exactness"
        )
    left_out = {
        **floor.left_out_m2,
        "on another level": reached.other_level * cell_m2,
        "not connected with the start": max(cells - taken, 0) * cell_m2,
        "too low": len(spans.low) * cell_m2 if chosen.roof else 0.0,
    }
    low, high = at.vertices_m.min(axis=0), at.vertices_m.max(axis=0)
    x_m, y_m, z_m = (high - low).tolist()
    return ImportReport(
        file=path.name,
        size_m=(x_m, y_m, z_m),
        triangles=len(clean.triangles),
        cleaned={
            "with a corner that is not finite": clean.not_finite,
            "without an area": clean.degenerate,
            "doubled": clean.doubled,
        },
        decisions=decisions,
        floor_m2=cells * cell_m2,
        free_m2=float(np.count_nonzero(world.free)) * cell_m2,
        reachable_m2=float(np.count_nonzero(reachable(world))) * cell_m2,
        passages_m=passage_widths_m(world.free != 0, world.resolution_m),
        left_out_m2=left_out,
        start_m=(*floor.start_m, float(floor.ground_m[world.frame.cell_of(*floor.start_m)])),
        start_proposed=proposed,
    )
