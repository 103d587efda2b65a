"""``swarmscout list``: what can be named in a scenario, with one line each."""

from __future__ import annotations

from collections.abc import Mapping

from cyclopts import App

__all__ = ["app"]

app = App(name="list", help="What there is to choose from, with one line each.")


@app.command
def selectors() -> None:
    """Rules that choose a team's destination (explore --destinations NAME)."""
    from swarmscout.destinations.registry import RECOMMENDED, model_selectors
    from swarmscout.destinations.registry import selectors as known

    _print(known() | model_selectors(), recommended=RECOMMENDED)


@app.command
def policies() -> None:
    """Policies that set the desired team size (explore --set teams.policy=NAME)."""
    from swarmscout.teams.registry import policies as known

    _print(known())


@app.command
def sensors() -> None:
    """Range sensors (explore --set sensor.model=NAME)."""
    from swarmscout.robots.sensors.registry import SENSORS

    _print(SENSORS.names())


@app.command
def radios() -> None:
    """Radios: who hears whom (explore --set radio.model=NAME)."""
    from swarmscout.robots.radio.registry import RADIOS

    _print(RADIOS.names())


@app.command
def tasks() -> None:
    """Tasks: what is worth heading for (explore --set task.model=NAME)."""
    from swarmscout.tasks.registry import TASKS

    _print(TASKS.names())


@app.command
def worlds() -> None:
    """Worlds that come with the package (explore --world NAME)."""
    from swarmscout.worlds.catalogue import named_worlds

    _print(named_worlds())


def _print(lines: Mapping[str, str], recommended: str | None = None) -> None:
    width = max((len(name) for name in lines), default=0)
    for name, line in lines.items():
        mark = " (recommended)" if name == recommended else ""
        print(f"{name:<{width}}  {line}{mark}")
