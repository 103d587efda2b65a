"""``swarmscout explore``: run a mission, show how it goes, keep it."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from swarmscout.cli.numbers import WholeNumber

if TYPE_CHECKING:
    from swarmscout.mission.scenario import Scenario
    from swarmscout.recording.run import Run

__all__ = ["explore"]


def explore(
    scenario: str = "default",
    /,
    *,
    world: str | None = None,
    start: Literal["one-place", "spread"] | None = None,
    robots: WholeNumber | None = None,
    steps: WholeNumber | None = None,
    seed: WholeNumber | None = None,
    destinations: str | None = None,
    set_: Annotated[
        tuple[str, ...],
        Parameter(name="--set", negative=(), metavar="KEY=VALUE", show_default=False),
    ] = (),
    out: Annotated[Path | None, Parameter(metavar="DIR")] = None,
    record: Literal["full", "curves", "summary"] = "full",
    picture: bool = True,
    record_rrd: Annotated[Path | None, Parameter(metavar="FILE.rrd")] = None,
    view: bool = False,
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

    Args:
        scenario: a scenario file, default, paper, paper-literal, or a run's folder (runs it again).
        world: a named world, a map's file, or a world folder.
        start: robots start round the stations, or all over the world.
        robots: number of robots.
        steps: length of the mission.
        seed: starts, noise, charge, characters and decisions.
        destinations: a selector's name, or FILE.py:NAME.
        set_: any other scenario key, for example teams.desired_size=3; may be repeated.
        out: a new folder for the run; by default one in runs/ that is named after the mission.
        record: full; curves leaves out steps, maps and events; summary leaves out all tables.
        picture: draw the final map into the run's folder as map.png.
        record_rrd: write the mission as a recording for the Rerun viewer too (extra rerun).
        view: show the mission in the browser while it runs, and until Ctrl-C.
        pace: with --view, run no faster than so many steps per second.
        host: with --view, the address to listen on; the default lets nobody in but this machine.
        port: with --view, the port; by default 8642, or any free one if that is taken.
        browser: with --view, open the page in the default browser.
        llm: who answers a selector that asks a language model: openai, azure, embedded, or the
            address of a compatible server; by default whoever the environment names.
        llm_model: the model's name, or Azure's deployment.
        llm_cassette: a file that keeps requests and replies, see --llm-mode.
        llm_mode: replay asks nobody, record asks for what is missing, refresh asks anew; auto
            records with a model at hand and replays without one.
    """
    from swarmscout.cli.compiling import say_if_compiling
    from swarmscout.cli.interrupts import Interrupted, between_steps
    from swarmscout.cli.live_view import watching
    from swarmscout.cli.llm_options import decision_lines, llm_overrides, say_others, say_trouble
    from swarmscout.cli.progress import Progress
    from swarmscout.cli.summary import summary_lines
    from swarmscout.core.errors import ScenarioError, SwarmscoutError
    from swarmscout.mission.scenario_files import load_scenario
    from swarmscout.recording.rerun import check_rerun, run_behind
    from swarmscout.recording.run_folder import release_folder

    options = {
        "world": world,
        "start": start,
        "robots": robots,
        "steps": steps,
        "seed": seed,
        "destinations": destinations,
    }
    overrides = {key: value for key, value in options.items() if value is not None}
    origins = {key: f"--{key}" for key in overrides}
    told = llm_overrides(llm, llm_model, llm_cassette, llm_mode)
    overrides |= told
    origins |= {key: f"--{key.replace('.', '-').replace('_', '-')}" for key in told}
    for text in set_:
        key, value = _key_value(text)
        if key in origins:
            other = f"another --set {key}=…" if origins[key] == "--set" else origins[key]
            raise ScenarioError(f"--set {text} and {other} are both given: leave one of them out")
        overrides[key], origins[key] = value, "--set"
    recorded = run_behind(scenario)
    if recorded is not None:
        for line in check_rerun(recorded, overrides):
            print(f"note: {line}", file=sys.stderr)
    chosen = load_scenario(scenario, overrides, origins=origins)
    if record_rrd is not None:
        _check_rrd(record_rrd, record)
    folder = _claim(chosen, out)
    page = None
    try:
        if view:
            page = watching(folder.name, host=host, port=port, browser=browser, pace=pace)
        from swarmscout.api import record_mission
        from swarmscout.worlds.catalogue import named_worlds

        say_if_compiling()
        if chosen.sensor.sensing == "mesh" and chosen.world in named_worlds():
            print("making the cave's mesh first: some seconds for each 100 m of tube", flush=True)
        with between_steps() as check, Progress(chosen.steps) as progress:

            def on_step(mission: Any) -> None:
                for line in decision_lines(mission):
                    progress.say(line)
                progress.show(mission)
                check()
                if page is not None:
                    page.keep_pace()

            run = record_mission(
                chosen, out=folder, record=record, on_step=on_step,
                watchers=[] if page is None else [page.live],
            )  # fmt: skip
    except Interrupted as stopped:
        raise Interrupted(stopped.signal, f"{stopped}{_kept(folder)}") from None
    except SwarmscoutError as error:
        raise type(error)(f"{error}{_kept(folder)}") from error
    finally:
        release_folder(folder)  # Only if nothing was written into it.
        if page is not None:
            page.close_unless_over()
    for line in summary_lines(run):
        print(line)
    code = say_trouble(run.summary)
    print(f"run: {folder}")
    if picture:
        print(f"picture: {_draw(run, folder)}")
    if record_rrd is not None:
        from swarmscout.viewing.rerun_recording import record_rrd as write_rrd

        print(f"recording: {write_rrd(run, record_rrd)}")
    say_others(run.scenario)
    if page is not None:
        page.stay()
    return code


def _check_rrd(file: Path, record: str) -> None:
    """Say before the mission runs that no Rerun recording could be made of it."""
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
    """Where the beginning of a mission that broke off can be found."""
    from swarmscout.core.errors import SwarmscoutError
    from swarmscout.recording.run import Run

    try:
        last = Run.open(folder).last_step
    except SwarmscoutError:
        return ""
    return f": steps 0 to {last} are kept in {folder}" if last >= 0 else ""


def _draw(run: Run, folder: Path) -> Path:
    from swarmscout.viewing.map_picture import map_picture

    return map_picture(run, folder / "map.png")
