"""``swarmscout view``: a recorded mission in the browser, or as one file to share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

if TYPE_CHECKING:
    from swarmscout.recording.run import Run

__all__ = ["view"]


def view(
    run: Path,
    other: Path | None = None,
    /,
    *,
    export: Annotated[Path | None, Parameter(metavar="FILE.html")] = None,
    own_maps: Annotated[str | None, Parameter(metavar="all|none|0,3,7")] = None,
    record_rrd: Annotated[Path | None, Parameter(metavar="FILE.rrd")] = None,
    rerun: bool = False,
    host: str = "127.0.0.1",
    port: int | None = None,
    browser: bool = True,
) -> int:
    """Show a mission in the browser, two side by side, or write it into one HTML file.

    Args:
        run: a run's folder, of a finished mission or of a killed one.
        other: another run's folder, to show beside it, in step.
        export: write the page and all its data into this one file instead of serving it.
        own_maps: with --export, the robots whose own maps the file holds, where robots know
            different things; default: all robots, or none of more than 100.
        record_rrd: write the run as a recording for the Rerun viewer (extra rerun).
        rerun: open the run in the Rerun viewer instead (extra rerun).
        host: the address to listen on; the default admits this machine only, 0.0.0.0 opens the
            page to the network, without a password.
        port: the port to listen on; default: 8642, or any free one if that is taken.
        browser: open the page in the default browser.
    """
    from swarmscout.core.errors import ViewError
    from swarmscout.recording.run import Run
    from swarmscout.viewing.player.recorded import player_data

    runs = [Run.open(folder) for folder in (run, other) if folder is not None]
    if export is not None:
        return _export(runs, export, own_maps)
    if own_maps is not None:
        raise ViewError("--own-maps needs --export: a served page has all own maps")
    if record_rrd is not None or rerun:
        return _rerun(runs, record_rrd, show=rerun)
    from swarmscout.cli.serving import serve_until_interrupted
    from swarmscout.viewing.player.server import PlayerServer, Recorded

    sources = [Recorded(player_data(one), one) for one in runs]
    with PlayerServer(sources, host, port) as server:
        serve_until_interrupted(server, browser=browser)
    return 0


def _export(runs: list[Run], file: Path, own_maps: str | None) -> int:
    from swarmscout.viewing.player.beliefs import MOST_ROBOTS
    from swarmscout.viewing.player.export import export_page

    size = export_page(runs, file, own_maps).stat().st_size
    print(f"page: {file} ({size / 1e6:.1f} MB; complete in one file)")
    large = any(run.own_maps and run.scenario.robots > MOST_ROBOTS for run in runs)
    if large and own_maps is None:
        print("robots' own maps are left out: --own-maps 0,3,7 includes some")
    return 0


def _rerun(runs: list[Run], file: Path | None, *, show: bool) -> int:
    from tempfile import TemporaryDirectory

    from swarmscout.core.errors import ViewError
    from swarmscout.viewing.rerun_recording import record_rrd, show_rrd

    if len(runs) > 1:
        raise ViewError("Rerun shows one run at a time")
    with TemporaryDirectory() as folder:
        path = record_rrd(runs[0], Path(folder) / "mission.rrd" if file is None else file)
        if file is not None:
            print(f"recording: {path} ({path.stat().st_size / 1e6:.1f} MB)")
        return show_rrd(path) if show else 0
