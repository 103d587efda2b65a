"""Scenarios in TOML files: reading, overriding keys, and saying clearly what is wrong.

The package ships two: ``paper`` (our defaults) and ``paper-literal`` (the paper to the letter).
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import BaseModel, ValidationError

from swarmscout.core.errors import ScenarioError, did_you_mean
from swarmscout.mission.scenario import Scenario

__all__ = ["load_scenario", "make_scenario", "named_scenarios", "scenario_toml"]


def named_scenarios() -> tuple[str, ...]:
    """Names of the scenarios that come with the package."""
    folder = resources.files("swarmscout.mission") / "scenarios"
    return tuple(
        sorted(f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml"))
    )


def load_scenario(what: str | Path, overrides: Mapping[str, Any] | None = None) -> Scenario:
    """Read a scenario and override some of its keys.

    Args:
        what: a name (``paper``), a TOML file, or a run's folder (its ``scenario.toml``).
        overrides: dotted keys to values, as ``{"teams.desired_size": 3}``.

    Returns:
        The scenario; a world given as a path relative to the file is made absolute.

    Raises:
        ScenarioError: the file cannot be read, or a key is unknown or has a bad value.
    """
    text, folder, where = _read(what)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{where} is not valid TOML: {error}") from None
    data.pop("swarmscout", None)  # A run's scenario.toml says here which version wrote it.
    world = data.get("world")
    if folder is not None and isinstance(world, str) and (folder / world).exists():
        data["world"] = str((folder / world).resolve())
    return make_scenario(data, overrides, where=where)


def make_scenario(
    data: Mapping[str, Any] | None = None,
    overrides: Mapping[str, Any] | None = None,
    *,
    where: str = "the scenario",
) -> Scenario:
    """Build a scenario from nested data, with dotted keys on top.

    Raises:
        ScenarioError: in one line, which key is wrong, what it was, and what would be right.
    """
    merged = {key: dict(v) if isinstance(v, Mapping) else v for key, v in (data or {}).items()}
    for dotted, value in (overrides or {}).items():
        _put(merged, dotted, value)
    try:
        return Scenario.model_validate(merged)
    except ValidationError as error:
        raise ScenarioError(f"{where}: {_explain(error)}") from None


def scenario_toml(scenario: Scenario, header: Mapping[str, Any] | None = None) -> str:
    """A scenario as TOML that runs again as it stands.

    Args:
        scenario: what to write.
        header: facts on who wrote it, kept in a table ``swarmscout`` that readers skip.
    """
    data = scenario.model_dump(exclude_none=True)
    if header:
        data = {**data, "swarmscout": dict(header)}
    return tomli_w.dumps(data)


def _read(what: str | Path) -> tuple[str, Path | None, str]:
    if isinstance(what, str) and what in named_scenarios():
        resource = resources.files("swarmscout.mission") / "scenarios" / f"{what}.toml"
        return resource.read_text(encoding="utf-8"), None, f"scenario '{what}'"
    path = Path(what)
    if path.is_dir():
        path = path / "scenario.toml"
    if not path.exists():
        if isinstance(what, Path) or path.suffix or len(path.parts) > 1:
            raise ScenarioError(f"scenario file '{path}' does not exist")
        raise ScenarioError(
            f"unknown scenario '{what}': {did_you_mean(str(what), named_scenarios())} "
            "(or give a .toml file)"
        )
    try:
        return path.read_text(encoding="utf-8"), path.resolve().parent, f"scenario file '{path}'"
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
        raise ScenarioError(f"scenario file '{path}' cannot be read: {reason}") from None


def _put(data: dict[str, Any], dotted: str, value: Any) -> None:
    *sections, key = dotted.split(".")
    if not key or not all(sections):
        raise ScenarioError(f"'{dotted}' is no scenario key: write KEY=VALUE or SECTION.KEY=VALUE")
    for section in sections:
        inner = data.setdefault(section, {})
        if isinstance(inner, BaseModel):
            inner = data[section] = inner.model_dump()
        if not isinstance(inner, dict):
            raise ScenarioError(f"scenario key '{dotted}': '{section}' is not a section")
        data = inner
    data[key] = value


def _explain(error: ValidationError) -> str:
    """The first thing that is wrong, in one line."""
    problems = error.errors(include_url=False)
    first = problems[0]
    key = ".".join(str(part) for part in first["loc"])
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    if first["type"] == "extra_forbidden":
        section: type[BaseModel] = Scenario
        for part in first["loc"][:-1]:
            annotation = section.model_fields[str(part)].annotation
            assert isinstance(annotation, type)
            section = annotation
        name = str(first["loc"][-1])
        return f"unknown key '{key}': {did_you_mean(name, section.model_fields)}{more}"
    message = first["msg"].removeprefix("Value error, ").removeprefix("Input ")
    given = first["input"]
    if isinstance(given, dict | BaseModel):
        return f"section '{key}': {message}{more}"
    return f"key '{key}' = {given!r}: {message}{more}"
