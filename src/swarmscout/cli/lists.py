"""``swarmscout list``: names that a scenario can use, and its keys."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from cyclopts import App, Parameter

__all__ = ["app", "print_names"]

app = App(
    name="list", help="List selectors, policies, sensors, radios, tasks, worlds, scenario keys."
)

Json = Annotated[bool, Parameter(negative=(), help="Print a JSON object instead of a table.")]


@app.command
def selectors(*, json: Json = False) -> None:
    """Rules that choose a team's destination (explore --destinations NAME)."""
    from swarmscout.destinations.registry import RECOMMENDED, model_selectors
    from swarmscout.destinations.registry import selectors as known

    print_names(known() | model_selectors(), json=json, recommended=RECOMMENDED)


@app.command
def policies(*, json: Json = False) -> None:
    """Policies that set the desired team size (explore --set teams.policy=NAME)."""
    from swarmscout.teams.registry import policies as known

    print_names(known(), json=json)


@app.command
def sensors(*, json: Json = False) -> None:
    """Range sensors (explore --set sensor.model=NAME)."""
    from swarmscout.robots.sensors.registry import SENSORS

    print_names(SENSORS.names(), json=json)


@app.command
def radios(*, json: Json = False) -> None:
    """Radios: who hears whom (explore --set radio.model=NAME)."""
    from swarmscout.robots.radio.registry import RADIOS

    print_names(RADIOS.names(), json=json)


@app.command
def tasks(*, json: Json = False) -> None:
    """Tasks: what is worth heading for (explore --set task.model=NAME)."""
    from swarmscout.tasks.registry import TASKS

    print_names(TASKS.names(), json=json)


@app.command
def worlds(*, json: Json = False) -> None:
    """Worlds of the package (explore --world NAME)."""
    from swarmscout.worlds.catalogue import named_worlds

    print_names(named_worlds(), json=json)


@app.command
def keys(part: str = "", /, *, json: Json = False) -> None:
    """All scenario keys: default, range, meaning (explore --set KEY=VALUE).

    Args:
        part: list only keys that contain this, for example teams.
    """
    from swarmscout.core.errors import ScenarioError, did_you_mean
    from swarmscout.mission.scenario_keys import scenario_keys

    known = scenario_keys()
    found = [key for key in known if part in key.key]
    if not found:
        names = [key.key for key in known] + [key.key.split(".")[0] for key in known]
        raise ScenarioError(f"no scenario key contains '{part}': {did_you_mean(part, names)}")
    if json:
        _print_json([key._asdict() for key in found])
        return
    import shutil
    import textwrap

    columns = min(100, shutil.get_terminal_size().columns)
    for key in found:
        print(f"{key.key} = {key.default}" + (f"  ({key.range})" if key.range else ""))
        indent = "    "
        print(textwrap.fill(key.meaning, columns, initial_indent=indent, subsequent_indent=indent))


def print_names(
    lines: Mapping[str, str], *, json: bool = False, recommended: str | None = None
) -> None:
    """Print names and what they mean as a table, or as a JSON object.

    Args:
        lines: name → one line.
        json: print JSON.
        recommended: the name that gets a mark in the table.
    """
    if json:
        _print_json(dict(lines))
        return
    width = max((len(name) for name in lines), default=0)
    for name, line in lines.items():
        mark = " (recommended)" if name == recommended else ""
        print(f"{name:<{width}}  {line}{mark}")


def _print_json(value: object) -> None:
    from json import dumps

    print(dumps(value, indent=2, ensure_ascii=False))
