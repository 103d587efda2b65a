"""``swarmscout worlds``: list, show, generate and import worlds."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

from swarmscout.cli.numbers import WholeNumber

if TYPE_CHECKING:
    from swarmscout.worlds.tube_parameters import TubeParameters
    from swarmscout.worlds.world import World

__all__ = ["app"]

_MOST_ROBOTS = 100_000

app = App(name="worlds", help="List, show, import and generate worlds.", help_format="plaintext")

_Place = Annotated[str | None, Parameter(metavar="X,Y[,Z]")]
_Points = Annotated[tuple[str, ...], Parameter(metavar="X,Y", negative=(), show_default=False)]
_Folder = Annotated[Path | None, Parameter(metavar="FOLDER")]
_MeshFile = Annotated[Path | None, Parameter(metavar="MESH.ply")]
_Picture = Annotated[Path | None, Parameter(metavar="PICTURE.png")]


@app.command(name="list")
def list_worlds() -> None:
    """Worlds that come with the package."""
    from swarmscout.worlds.catalogue import named_worlds

    lines = named_worlds()
    for name, line in lines.items():
        print(f"{name:<{max(map(len, lines))}}  {line}")


@app.command
def show(
    world: str,
    /,
    *,
    seed: WholeNumber | None = None,
    robots: WholeNumber = 15,
    metres_per_cell: float | None = None,
    resolution: float | None = None,
    out: _Picture = None,
) -> None:
    """Draw a world into a picture, and say how large it is.

    Args:
        world: a named world, a map's file, or a world folder.
        seed: which of all worlds of that name.
        robots: for how many robots stations and starting places are shown.
        metres_per_cell: edge of a file's cell or pixel, in metres.
        resolution: edge of a raster cell, in metres.
        out: the picture; by default one in the working directory that is named after the world.
    """
    from swarmscout.worlds.catalogue import NAMED_TUBES, load_world

    _check_robots(robots)
    loaded = load_world(world, seed=seed, cell_m=metres_per_cell, resolution_m=resolution)
    suffix = "" if seed is None else f"-{seed}"
    if world not in NAMED_TUBES:
        suffix = "-world"  # Beside my_map.png or my_map.yaml there is an image that is the map.
        _spare(out, Path(world))
    _report(loaded, robots)
    _draw(loaded, robots, out or Path(f"{loaded.name}{suffix}.png"))


@app.command
def generate(
    name: str = "tube",
    /,
    *,
    seed: WholeNumber = 0,
    like: str = "lava-tube",
    layout: Literal["tube", "maze"] | None = None,
    size: float | None = None,
    length: float | None = None,
    width: float | None = None,
    narrowest: float | None = None,
    widest: float | None = None,
    winding: float | None = None,
    braids: WholeNumber | None = None,
    branches: WholeNumber | None = None,
    branch_length: float | None = None,
    pillars: WholeNumber | None = None,
    piles: WholeNumber | None = None,
    roughness: float | None = None,
    resolution: float | None = None,
    mesh: _MeshFile = None,
    mesh_resolution: float | None = None,
    skylights: WholeNumber | None = None,
    robots: WholeNumber = 15,
    out: _Folder = None,
) -> None:
    """Generate a lava tube, and keep it in a folder with a picture.

    Args:
        name: what to call it.
        seed: which of all tubes with these parameters.
        like: the named world whose parameters hold where no other is given.
        layout: a trunk with braids and branches, or a maze of small tubes.
        size: centre lines stay in a square with this side, in metres.
        length: length of the trunk, in metres.
        width: mean width of the trunk, in metres.
        narrowest: least planned width, in metres.
        widest: greatest planned width, in metres.
        winding: 0 (straight) to 2.
        braids: arms that leave the trunk and rejoin it.
        branches: blind side tubes.
        branch_length: their mean length, in metres.
        pillars: rock left standing in wide places.
        piles: breakdown from the ceiling.
        roughness: how far walls stray from a smooth outline, in metres.
        resolution: edge of a raster cell, in metres.
        mesh: a new file for the tube in 3D (.ply, .obj, .stl, .glb or .off), which the world's
            folder keeps as well; none by default.
        mesh_resolution: distance of the points that its surface is found on, in metres; 0.2.
        skylights: holes in its roof.
        robots: for how many robots it is checked and drawn.
        out: a new folder; by default one in the working directory with the world's name.
    """
    import dataclasses

    from swarmscout.core.errors import WorldError, did_you_mean
    from swarmscout.worlds.catalogue import NAMED_TUBES
    from swarmscout.worlds.tube import generate_tube

    if like not in NAMED_TUBES:
        raise WorldError(f"--like '{like}' is no named world: {did_you_mean(like, NAMED_TUBES)}")
    given: dict[str, Any] = {
        "layout": layout, "size_m": size, "length_m": length, "width_m": width,
        "narrowest_m": narrowest, "widest_m": widest, "winding": winding, "braids": braids,
        "branches": branches, "branch_length_m": branch_length, "pillars": pillars, "piles": piles,
        "roughness_m": roughness, "resolution_m": resolution,
    }  # fmt: skip
    chosen = {key: value for key, value in given.items() if value is not None}
    parameters = dataclasses.replace(NAMED_TUBES[like][1], seed=seed, **chosen)
    options = {"mesh_resolution_m": mesh_resolution, "skylights": skylights}
    wanted = {key: value for key, value in options.items() if value is not None}
    if mesh is None and wanted:
        option = "--skylights" if skylights is not None else "--mesh-resolution"
        raise WorldError(f"{option} has no meaning without --mesh FILE")
    if mesh is None:
        _keep(generate_tube(parameters, name), robots, out)
        return
    _keep_with_mesh(parameters, name, wanted, robots, out, mesh)


@app.command(name="import")
def import_world(
    file: str,
    /,
    *,
    metres_per_cell: float | None = None,
    up: Literal["z", "y"] | None = None,
    scale: float | None = None,
    roof: bool | None = None,
    step_height: float | None = None,
    resolution: float | None = None,
    start: _Place = None,
    station: _Points = (),
    robots: WholeNumber = 15,
    out: _Folder = None,
) -> None:
    """Make a world of a map or a cave's mesh; report and picture.

    Maps are nav2 YAML, MovingAI .map, images and .npy; meshes are OBJ, STL, PLY, GLB, glTF, DAE
    and OFF.

    Args:
        file: the map or the mesh.
        metres_per_cell: edge of a map's cell or pixel, in metres; nav2 maps say it themselves.
        up: the mesh's axis that points up; by default guessed from its surfaces.
        scale: metres per unit of the mesh, as 0.001; by default as its file says, or else 1.
        roof: only floor of the mesh under a ceiling counts, or any; by default found out.
        step_height: most height between neighbouring cells of a mesh's floor; by default 0.15.
        resolution: edge of a raster cell, in metres; by default a map's own, or at most 0.1.
        start: where missions start, in metres; by default a roomy place in the largest region.
        station: a charging station, in metres; may be repeated; by default near the start.
        robots: for how many robots it is checked and drawn.
        out: a new folder; by default one in the working directory with the map's name.
    """
    from swarmscout.core.errors import WorldError
    from swarmscout.worlds.arrays import with_places
    from swarmscout.worlds.catalogue import load_world
    from swarmscout.worlds.meshes.files import MESH_SUFFIXES

    is_mesh = Path(file).suffix.lower() in MESH_SUFFIXES
    stations = [_point("--station", text) for text in station] or None
    if not is_mesh:
        _refuse(f"'{file}' is no mesh", up=up, scale=scale, roof=roof, step_height=step_height)
        place = None if start is None else _point("--start", start)
        loaded = load_world(
            Path(file), cell_m=metres_per_cell, resolution_m=resolution, start_m=place,
            stations_m=stations,
        )  # fmt: skip
        _keep(loaded, robots, out)
        return
    from swarmscout.cli.mesh_import import world_of_mesh

    _refuse(f"'{file}' is a mesh (use --scale)", metres_per_cell=metres_per_cell)
    if not Path(file).exists():
        raise WorldError(f"mesh '{file}' does not exist: looked for '{Path(file).absolute()}'")
    _check_robots(robots)
    _new_folder(out or Path(Path(file).stem))  # Before the work, not after it.
    world = world_of_mesh(
        Path(file), up=up, scale=scale, roof=roof, resolution_m=resolution,
        step_height_m=step_height,
        start_m=None if start is None else _point("--start", start, most=3),
    )  # fmt: skip
    _keep(with_places(world, None, stations), robots, out, reported=True)


def _refuse(what: str, **options: object) -> None:
    """Complain about options that would have no effect."""
    from swarmscout.core.errors import WorldError

    for name, value in options.items():
        if value is not None:
            raise WorldError(f"{what}: --{name.replace('_', '-')} has no meaning: leave it out")


def _check_robots(robots: int) -> None:
    from swarmscout.core.errors import WorldError

    if not 1 <= robots <= _MOST_ROBOTS:
        raise WorldError(f"--robots {robots}: expected 1 to {_MOST_ROBOTS:,}")


def _spare(out: Path | None, world: Path) -> None:
    """Refuse to draw over the map itself, or over the image that a nav2 map consists of."""
    from swarmscout.core.errors import WorldError

    if out is None or not out.exists():
        return
    images = [world, *(world.with_suffix(suffix) for suffix in (".png", ".pgm", ".pdf", ".svg"))]
    if any(image.exists() and image.samefile(out) for image in images):
        raise WorldError(f"--out '{out}' is the map itself: choose another name for the picture")


def _keep_with_mesh(
    parameters: TubeParameters,
    name: str,
    wanted: dict[str, Any],
    robots: int,
    out: Path | None,
    file: Path,
) -> None:
    """Generate a tube with its mesh, and keep both; what is wrong is said before the work."""
    import dataclasses

    from swarmscout.cli.counting import counting
    from swarmscout.viewing.mesh_picture import mesh_picture
    from swarmscout.worlds.meshes.tube_mesh import check_tube_mesh, tube_mesh
    from swarmscout.worlds.meshes.writing import check_mesh_file, write_mesh
    from swarmscout.worlds.tube import generate_tube

    _check_robots(robots)
    folder = _new_folder(out or Path(name))
    check_mesh_file(file)
    check_tube_mesh(**wanted)
    world = generate_tube(parameters, name)
    print("making the mesh: some seconds for each 100 m of tube", flush=True)
    with counting("mesh") as on_progress:
        mesh = tube_mesh(parameters, on_progress=on_progress, **wanted)
    world = dataclasses.replace(world, mesh=mesh, source={**world.source, **wanted})
    _keep(world, robots, folder)
    size_mb = write_mesh(mesh, file).stat().st_size / 1e6
    print(f"mesh: {file}, {len(mesh.triangles):,} triangles, {size_mb:.1f} MB")
    print(f"picture: {mesh_picture(world, folder / 'mesh.png')}")


def _new_folder(folder: Path) -> Path:
    from swarmscout.core.errors import WorldError

    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise WorldError(f"'{folder}' is there already: choose another with --out FOLDER")
    # Said before the work: what is there already of the way to it must be a folder to write into.
    there = next(home for home in (folder, *folder.absolute().parents) if home.exists())
    if not there.is_dir() or not os.access(there, os.W_OK):
        raise WorldError(f"cannot make the folder '{folder}': '{there}' is no folder to write into")
    return folder


def _keep(world: World, robots: int, out: Path | None, *, reported: bool = False) -> None:
    """Check a world, write it into a new folder with a picture, and say so."""
    from swarmscout.core.errors import WorldError
    from swarmscout.worlds.checks import check_world
    from swarmscout.worlds.folder import save_world

    _check_robots(robots)
    folder = _new_folder(out or Path(world.name))
    check_world(world, robots)
    if not reported:
        _report(world, robots)
    try:
        save_world(world, folder)
    except OSError as error:
        raise WorldError(f"cannot write '{folder}': {error.strerror or error}") from None
    print(f"world: {folder}")
    _draw(world, robots, folder / "world.png")


def _report(world: World, robots: int) -> None:
    """Area, size, start and stations in a few lines."""
    import numpy as np

    from swarmscout.worlds.placement import place_stations
    from swarmscout.worlds.reachability import reachable
    from swarmscout.worlds.starts import start_of

    left, right, bottom, top = world.extent
    cell_m2 = world.resolution_m**2
    free = float(np.count_nonzero(world.free)) * cell_m2
    reached = float(np.count_nonzero(reachable(world))) * cell_m2
    x, y = start_of(world)
    count = len(place_stations(world, robots))
    print(f"{world.name}: {right - left:.1f} m x {top - bottom:.1f} m at {world.resolution_m:g} m")
    print(f"free: {free:,.1f} m², reachable from the start: {reached:,.1f} m²")
    print(f"start: {x:.2f},{y:.2f} m; charging stations for {robots} robots: {count}")


def _draw(world: World, robots: int, path: Path) -> None:
    from swarmscout.viewing.world_picture import world_picture

    print(f"picture: {world_picture(world, path, robots)}")


def _point(option: str, text: str, most: int = 2) -> tuple[float, ...]:
    """``12.5,3`` as x, y in metres; where that is allowed ``12.5,3,-1`` as x, y, z."""
    from swarmscout.core.errors import WorldError

    try:
        point = tuple(float(part) for part in text.split(","))
    except ValueError:
        point = ()
    if not 2 <= len(point) <= most:
        expected = "X,Y" if most == 2 else "X,Y or X,Y,Z"
        raise WorldError(f"{option} '{text}': expected {expected} in metres, e.g. 12.5,3")
    return point
