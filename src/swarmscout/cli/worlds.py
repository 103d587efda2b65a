"""``swarmscout worlds``: list, show, generate and import worlds."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

from swarmscout.cli.values import convert_value
from swarmscout.cli.world_report import draw, print_hints, report, with_inverted_hint

if TYPE_CHECKING:
    from swarmscout.worlds.tube_parameters import TubeParameters
    from swarmscout.worlds.world import World

__all__ = ["app"]

_MOST_ROBOTS = 100_000

app = App(
    name="worlds",
    help="List, show, import and generate worlds.",
    help_format="plaintext",
    default_parameter=Parameter(converter=convert_value),
)

_Place = Annotated[str | None, Parameter(metavar="X,Y[,Z]", allow_leading_hyphen=True)]
_Points = Annotated[
    tuple[str, ...],
    Parameter(metavar="X,Y", negative=(), show_default=False, allow_leading_hyphen=True),
]
_Height = Annotated[float | None, Parameter(metavar="Z", allow_leading_hyphen=True)]
_Values = Annotated[str | None, Parameter(metavar="VALUES", allow_leading_hyphen=True)]
_Folder = Annotated[Path | None, Parameter(metavar="FOLDER")]
_MeshFile = Annotated[Path | None, Parameter(metavar="MESH.ply")]
_Picture = Annotated[Path | None, Parameter(metavar="PICTURE.png")]


@app.command(name="list")
def list_worlds() -> None:
    """Worlds that come with the package, and world readers of other packages."""
    from swarmscout.cli.lists import print_names
    from swarmscout.worlds.catalogue import named_worlds
    from swarmscout.worlds.readers import READERS

    print_names(named_worlds() | READERS.names())


@app.command
def show(
    world: str,
    /,
    *,
    seed: int | None = None,
    robots: int = 15,
    metres_per_cell: float | None = None,
    free: _Values = None,
    occupied: _Values = None,
    resolution: float | None = None,
    out: _Picture = None,
) -> None:
    """Draw a world into a picture, and say how large it is.

    Args:
        world: a named world, a map file, a world folder, or a world reader (FILE.py:Name).
        seed: which of the worlds of that name.
        robots: the number of robots for which stations and starting places are shown.
        metres_per_cell: edge of a file's cell or pixel, in metres.
        free: values of an image or array that are free, as 0, 0..49 or 0,205.
        occupied: values of an image or array that are not free, in the same form.
        resolution: edge of a raster cell, in metres.
        out: the picture; by default one in the working directory that is named after the world.
    """
    from swarmscout.core.errors import WorldError
    from swarmscout.worlds.catalogue import NAMED_TUBES, load_world

    _check_robots(robots)
    loaded = load_world(
        world, seed=seed, cell_m=metres_per_cell, resolution_m=resolution, free=free,
        occupied=occupied,
    )  # fmt: skip
    suffix = "" if seed is None else f"-{seed}"
    if world not in NAMED_TUBES:
        suffix = "-world"  # my_map.png, or the image beside my_map.yaml, is the map itself.
        _spare(out, Path(world))
    picture = out or Path(f"{loaded.name}{suffix}.png")
    try:
        report(loaded, robots)
    except WorldError as error:
        raise WorldError(with_inverted_hint(loaded, error)) from None
    draw(loaded, robots, picture)
    if world not in NAMED_TUBES:
        inside = picture.with_name(f"{picture.stem}-inside{picture.suffix}")
        print_hints(loaded, robots, inside, start_given=loaded.start_m is not None)


@app.command
def generate(
    name: str = "tube",
    /,
    *,
    seed: int = 0,
    like: str = "lava-tube",
    layout: Literal["tube", "maze"] | None = None,
    size: float | None = None,
    length: float | None = None,
    width: float | None = None,
    narrowest: float | None = None,
    widest: float | None = None,
    winding: float | None = None,
    braids: int | None = None,
    branches: int | None = None,
    branch_length: float | None = None,
    pillars: int | None = None,
    piles: int | None = None,
    roughness: float | None = None,
    resolution: float | None = None,
    mesh: _MeshFile = None,
    mesh_resolution: float | None = None,
    skylights: int | None = None,
    robots: int = 15,
    out: _Folder = None,
) -> None:
    """Generate a lava tube and write it into a folder with a picture.

    Args:
        name: the name of the world.
        seed: which of the tubes with these parameters.
        like: the named world whose parameters are the defaults.
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
        mesh: a new file for the tube in 3D (.ply, .obj, .stl, .glb or .off), which is also kept in
            the world folder; none by default.
        mesh_resolution: grid spacing on which its surface is found, in metres; 0.2.
        skylights: holes in its roof.
        robots: the number of robots for which it is checked and drawn.
        out: a new folder; by default one in the working directory with the name of the world.
    """
    import dataclasses

    from swarmscout.core.errors import WorldError, did_you_mean
    from swarmscout.worlds.catalogue import NAMED_TUBES
    from swarmscout.worlds.tube import generate_tube

    if like not in NAMED_TUBES:
        near = did_you_mean(like, NAMED_TUBES)
        raise WorldError(f"--like '{like}' is not a named world: {near}")
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
    free: _Values = None,
    occupied: _Values = None,
    seed: int | None = None,
    up: Literal["z", "y", "x"] | None = None,
    scale: float | None = None,
    roof: bool | None = None,
    ground: _Height = None,
    ground_plane: Annotated[bool, Parameter(negative=())] = False,
    step_height: float | None = None,
    resolution: float | None = None,
    start: _Place = None,
    station: _Points = (),
    robots: int = 15,
    out: _Folder = None,
) -> None:
    """Import a map or a mesh as a world; print a report and draw a picture.

    Maps are nav2 YAML, MovingAI .map, images and .npy; meshes are OBJ, STL, PLY, GLB, glTF, DAE
    and OFF.

    Args:
        file: the map, the mesh, or a world reader (FILE.py:Name or FILE.py:Name:DATA).
        metres_per_cell: edge of a map's cell or pixel, in metres; nav2 maps name it themselves.
        free: values of an image or array that are free, as 0, 0..49 or 0,205.
        occupied: values of an image or array that are not free, in the same form.
        seed: which of several worlds of a world reader.
        up: the axis of the mesh that points up; by default guessed from its surfaces.
        scale: metres per unit of the mesh, as 0.001; by default the unit that its file names, or 1.
        roof: only floor of the mesh under a ceiling counts, or any; by default found out.
        ground: add level ground at this height under a mesh without a floor, in metres.
        ground_plane: add level ground at the lowest point of a mesh without a floor.
        step_height: largest height difference between neighbouring cells of a mesh's floor, in
            metres; by default 0.15.
        resolution: edge of a raster cell, in metres; by default the map's own, or at most 0.1.
        start: where missions start, in metres; by default a roomy place in the largest region.
        station: a charging station, in metres; may be repeated; by default near the start.
        robots: the number of robots for which it is checked and drawn.
        out: a new folder; by default one in the working directory with the name of the map.
    """
    from swarmscout.core.errors import WorldError
    from swarmscout.core.paths import expanded
    from swarmscout.worlds.arrays import with_places
    from swarmscout.worlds.catalogue import load_world
    from swarmscout.worlds.meshes.files import MESH_SUFFIXES

    source = expanded(file)
    is_mesh = source.suffix.lower() in MESH_SUFFIXES and ".py:" not in file
    stations = [_point("--station", text) for text in station] or None
    if not is_mesh:
        _refuse(
            f"'{file}' is not a mesh", up=up, scale=scale, roof=roof, ground=ground,
            ground_plane=ground_plane or None, step_height=step_height,
        )  # fmt: skip
        place = None if start is None else _point("--start", start)
        loaded = load_world(
            file, seed=seed, cell_m=metres_per_cell, resolution_m=resolution, free=free,
            occupied=occupied, start_m=place, stations_m=stations,
        )  # fmt: skip
        folder = _keep(loaded, robots, out)
        inside = folder / "inside.png"
        print_hints(loaded, robots, inside, start_given=loaded.start_m is not None)
        return
    from swarmscout.cli.mesh_import import world_of_mesh

    _refuse(f"'{file}' is a mesh (use --scale)", metres_per_cell=metres_per_cell)
    _refuse(f"'{file}' is a mesh", free=free, occupied=occupied, seed=seed)
    if ground_plane and ground is not None:
        raise WorldError("--ground and --ground-plane exclude each other: give one of them")
    if not source.exists():
        raise WorldError(f"mesh '{file}' does not exist: looked for '{source.absolute()}'")
    _check_robots(robots)
    _new_folder(out or Path(source.stem))  # Before the work, not after it.
    world = world_of_mesh(
        source, up=up, scale=scale, roof=roof, resolution_m=resolution,
        step_height_m=step_height, ground_m="lowest" if ground_plane else ground,
        start_m=None if start is None else _point("--start", start, most=3),
    )  # fmt: skip
    _keep(with_places(world, None, stations), robots, out, reported=True)


def _refuse(what: str, **options: object) -> None:
    """Refuse options that would have no effect."""
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
    """Generate a tube with its mesh and write both; impossible options are reported first."""
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
        raise WorldError(f"'{folder}' exists and is not empty: choose another with --out FOLDER")
    # Before the work: the part of the path that exists must be a folder to write into.
    there = next(home for home in (folder, *folder.absolute().parents) if home.exists())
    if not there.is_dir() or not os.access(there, os.W_OK):
        raise WorldError(
            f"cannot make the folder '{folder}': '{there}' is not a folder to write into"
        )
    return folder


def _keep(world: World, robots: int, out: Path | None, *, reported: bool = False) -> Path:
    """Check a world, write it into a new folder with a picture, and print where."""
    from swarmscout.core.errors import WorldError
    from swarmscout.worlds.checks import check_world
    from swarmscout.worlds.folder import save_world

    _check_robots(robots)
    folder = _new_folder(out or Path(world.name))
    try:
        check_world(world, robots)
    except WorldError as error:
        raise WorldError(with_inverted_hint(world, error)) from None
    if not reported:
        report(world, robots)
    try:
        save_world(world, folder)
    except OSError as error:
        raise WorldError(f"cannot write '{folder}': {error.strerror or error}") from None
    print(f"world: {folder}")
    draw(world, robots, folder / "world.png")
    return folder


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
