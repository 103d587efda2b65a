"""``swarmscout explore``: run a mission, show its progress, record it."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

if TYPE_CHECKING:
    from swarmscout.cli.live_view import Watching
    from swarmscout.mission.scenario import Scenario
    from swarmscout.recording.run import Run

__all__ = ["explore"]


def explore(
    scenario: str = "default",
    /,
    *,
    world: str | None = None,
    start: Literal["one-place", "spread"] | None = None,
    robots: Annotated[int | None, Parameter(alias="-n")] = None,
    steps: int | None = None,
    seed: Annotated[int | None, Parameter(alias="-s")] = None,
    destinations: Annotated[str | None, Parameter(alias="-d")] = None,
    set_: Annotated[
        tuple[str, ...],
        Parameter(name="--set", negative=(), metavar="KEY=VALUE", show_default=False),
    ] = (),
    out: Annotated[Path | None, Parameter(alias="-o", metavar="DIR")] = None,
    record: Literal["full", "curves", "summary"] = "full",
    picture: bool = True,
    page: Annotated[bool, Parameter(negative=())] = False,
    quiet: Annotated[bool, Parameter(alias="-q", negative=())] = False,
    json: Annotated[bool, Parameter(negative=())] = False,
    record_rrd: Annotated[Path | None, Parameter(metavar="FILE.rrd")] = None,
    view: Annotated[bool, Parameter(negative=())] = False,
    pace: Annotated[float | None, Parameter(metavar="STEPS/S")] = None,
    host: str = "127.0.0.1",
    port: int | None = None,
    browser: bool = True,
    llm: str | None = None,
    llm_model: str | None = None,
    llm_cassette: Annotated[Path | None, Parameter(metavar="FILE")] = None,
    llm_mode: Literal["auto", "record", "replay", "refresh"] | None = None,
) -> int:
    """Run a mission: progress, a summary, a run folder, a picture of the final map.

    Options override the scenario. swarmscout list keys shows every key that --set takes.

    Args:
        scenario: default, paper, paper-literal, a scenario file, or a run's folder, whose mission
            is run again.
        world: a named world, a map file or a world folder; the default scenario has lava-tube.
        start: robots start around the stations, or all over the world; one-place by default.
        robots: number of robots, 1 to 100,000; the default scenario has 15.
        steps: length of the mission, at least 1; the default scenario has 300.
        seed: of starts, noise, charge and decisions, at least 0; the default scenario has 0.
        destinations: a selector's name or FILE.py:NAME; the default scenario has multi-criteria.
        set_: any scenario key, for example teams.desired_size=3; can be repeated.
        out: a new folder for the run; by default one in runs/ that is named after the mission.
        record: full; curves leaves out steps, maps and events; summary leaves out all tables.
        picture: draw the final map as map.png in the run's folder.
        page: write the player with the mission's data as page.html in the run's folder.
        quiet: print errors and warnings only.
        json: print one JSON object with the run's folder and its summary, and nothing else.
        record_rrd: also write the mission as a recording for the Rerun viewer (extra rerun).
        view: show the mission in the browser while it runs, and until Ctrl-C.
        pace: with --view, run at most this many steps per second.
        host: with --view, the address to listen on; the default admits only this machine.
        port: with --view, the port; by default 8642, or any free one if that is taken.
        browser: with --view, open the page in the default browser.
        llm: the language model's provider: openai, azure, embedded, or the address of a compatible
            server; by default taken from environment variables.
        llm_model: the model's name, or Azure's deployment.
        llm_cassette: a file that keeps requests and replies, see --llm-mode.
        llm_mode: replay sends no requests; record sends those that the cassette lacks; refresh
            sends all anew; auto records if a model is configured and replays otherwise.
    """
    from swarmscout.cli.llm_options import llm_overrides
    from swarmscout.core.errors import ViewError
    from swarmscout.mission.scenario_files import load_scenario
    from swarmscout.recording.rerun import check_rerun, run_behind
    from swarmscout.recording.run_folder import release_folder

    options = {
        "world": world, "start": start, "robots": robots, "steps": steps, "seed": seed,
        "destinations": destinations,
    }  # fmt: skip
    given = {key: value for key, value in options.items() if value is not None}
    given |= llm_overrides(llm, llm_model, llm_cassette, llm_mode)
    overrides, origins = _with_set(given, set_)
    recorded = run_behind(scenario)
    if recorded is not None:
        for line in check_rerun(recorded, overrides):
            print(f"note: {line}", file=sys.stderr)
    chosen = load_scenario(scenario, overrides, origins=origins)
    if record_rrd is not None:
        _check_rrd(record_rrd, record)
    if page and record != "full":
        raise ViewError(f"--page needs steps and maps: leave out --record {record}")
    folder = _claim(chosen, out)
    live = None
    try:
        with _printing(quiet=quiet, json=json):
            if view:
                live = _live(folder.name, host=host, port=port, browser=browser, pace=pace)
            run = _run(chosen, folder, record, live)
            code = _report(run, folder, picture=picture, page=page, record_rrd=record_rrd)
    finally:
        release_folder(folder)  # Only if nothing was written into it.
        if live is not None:
            live.close_unless_over()
    if json:
        _print_json(run, folder)
    if live is not None:
        live.stay()
    return code


def _with_set(
    given: Mapping[str, Any], set_: Sequence[str]
) -> tuple[dict[str, Any], dict[str, str]]:
    """All overrides of the scenario, and by which option each was given."""
    from swarmscout.core.errors import ScenarioError

    overrides = dict(given)
    origins = {key: f"--{key.replace('.', '-').replace('_', '-')}" for key in given}
    for text in set_:
        key, value = _key_value(text)
        if key in origins:
            other = f"another --set {key}=…" if origins[key] == "--set" else origins[key]
            raise ScenarioError(f"--set {text} and {other} are both given: leave one of them out")
        overrides[key], origins[key] = value, "--set"
    return overrides, origins


@contextmanager
def _printing(*, quiet: bool, json: bool) -> Iterator[None]:
    """Print nothing with --quiet; with --json print to stderr, so that stdout is JSON alone."""
    if quiet:
        with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
            yield
    elif json:
        with redirect_stdout(sys.stderr):
            yield
    else:
        yield


def _live(name: str, *, host: str, port: int | None, browser: bool, pace: float | None) -> Watching:
    from swarmscout.cli.live_view import watching

    return watching(name, host=host, port=port, browser=browser, pace=pace)


def _run(chosen: Scenario, folder: Path, record: str, live: Watching | None) -> Run:
    """Run the mission; if it is broken off, say which steps are kept."""
    from swarmscout.api import record_mission
    from swarmscout.cli.compiling import say_if_compiling
    from swarmscout.cli.interrupts import Interrupted, between_steps
    from swarmscout.cli.llm_options import decision_lines
    from swarmscout.cli.progress import Progress
    from swarmscout.core.errors import SwarmscoutError
    from swarmscout.worlds.catalogue import named_worlds

    try:
        say_if_compiling()
        if chosen.sensor.sensing == "mesh" and chosen.world in named_worlds():
            print("making the cave's mesh: some seconds per 100 m of tube", flush=True)
        with between_steps() as check, Progress(chosen.steps) as progress:

            def on_step(mission: Any) -> None:
                for line in decision_lines(mission):
                    progress.say(line)
                progress.show(mission)
                check()
                if live is not None:
                    live.keep_pace()

            return record_mission(
                chosen, out=folder, record=record, on_step=on_step,
                watchers=[] if live is None else [live.live],
            )  # fmt: skip
    except Interrupted as stopped:
        raise Interrupted(stopped.signal, f"{stopped}{_kept(folder)}") from None
    except SwarmscoutError as error:
        raise type(error)(f"{error}{_kept(folder)}") from error


def _report(run: Run, folder: Path, *, picture: bool, page: bool, record_rrd: Path | None) -> int:
    """Print the summary and which files were written; return the exit code."""
    from swarmscout.cli.llm_options import say_others, say_trouble
    from swarmscout.cli.summary import summary_lines

    for line in summary_lines(run):
        print(line)
    code = say_trouble(run.summary)
    print(f"run: {folder}")
    if picture:
        from swarmscout.viewing.map_picture import map_picture

        print(f"picture: {map_picture(run, folder / 'map.png')}")
    if record_rrd is not None:
        from swarmscout.viewing.rerun_recording import record_rrd as write_rrd

        print(f"recording: {write_rrd(run, record_rrd)}")
    if page:
        from swarmscout.viewing.player.export import export_page

        print(f"page: {export_page([run], folder / 'page.html')} (open it in a browser)")
    else:
        print(f"to watch it: swarmscout view {folder}")
    say_others(run.scenario)
    return code


def _print_json(run: Run, folder: Path) -> None:
    from json import dumps

    print(dumps({"run": str(folder), "summary": run.summary}, indent=2, ensure_ascii=False))


def _check_rrd(file: Path, record: str) -> None:
    """Refuse, before the mission runs, a Rerun recording that could not be written."""
    from swarmscout.core.errors import ViewError
    from swarmscout.viewing.rerun_recording import check_rrd

    if record != "full":
        raise ViewError(f"--record-rrd needs steps and maps: leave out --record {record}")
    check_rrd(file)


def _key_value(text: str) -> tuple[str, Any]:
    """``teams.desired_size=3`` as a key and a value; the value is TOML, or else a string."""
    from swarmscout.core.errors import ScenarioError
    from swarmscout.mission.scenario_files import parse_toml

    key, equals, value = (part.strip() for part in text.partition("="))
    if not key or not equals:
        raise ScenarioError(f"--set '{text}': write KEY=VALUE, for example teams.desired_size=3")
    try:
        parsed = parse_toml(f"value = {value}", "--set")
    except ScenarioError:
        return key, value
    return key, parsed["value"] if len(parsed) == 1 else value


def _claim(scenario: Scenario, out: Path | None) -> Path:
    """Claim the run's folder, before anything slow happens."""
    from swarmscout.recording.run_folder import claim_folder, claim_next_free, default_name

    if out is not None:
        return claim_folder(out)
    return claim_next_free(Path("runs") / default_name(scenario))


def _kept(folder: Path) -> str:
    """Which steps of a mission that was broken off are in its folder."""
    from swarmscout.core.errors import SwarmscoutError
    from swarmscout.recording.run import Run

    try:
        last = Run.open(folder).last_step
    except SwarmscoutError:
        return ""
    return f": steps 0 to {last} are kept in {folder}" if last >= 0 else ""
