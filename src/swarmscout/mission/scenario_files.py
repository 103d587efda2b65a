"""Scenarios in TOML files: reading them, overriding keys, and clear errors.

Two scenarios come with the package: ``paper`` (the defaults) and ``paper-literal``.
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
from swarmscout.core.parameters import describe_invalid_keys, key_of
from swarmscout.core.paths import expanded
from swarmscout.mission.scenario import Scenario

__all__ = ["load_scenario", "make_scenario", "named_scenarios", "parse_toml", "scenario_toml"]


_PLUG_IN_KEYS = (("teams", "policy"), ("sensor", "model"), ("radio", "model"), ("task", "model"))


def named_scenarios() -> tuple[str, ...]:
    """Names of the scenarios that come with the package."""
    folder = resources.files("swarmscout.mission") / "scenarios"
    return tuple(
        sorted(f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml"))
    )


def load_scenario(
    what: str | Path,
    overrides: Mapping[str, Any] | None = None,
    *,
    origins: Mapping[str, str] | None = None,
) -> Scenario:
    """Read a scenario and override some of its keys.

    Args:
        what: a name (``paper``), a TOML file, or a run's folder (its ``scenario.toml``).
        overrides: values by dotted key, as ``{"teams.desired_size": 3}``.
        origins: where each override was given, for errors, as ``{"robots": "--robots"}``.

    Returns:
        The scenario. Paths of a world or of a plug-in's file that are relative to the scenario's
        file are made absolute.

    Raises:
        ScenarioError: the file cannot be read, or a key is unknown or has a bad value.
    """
    text, folder, where = _read(what)
    data = parse_toml(text, where)
    data.pop("swarmscout", None)  # The version that wrote a run's scenario.toml.
    world = data.get("world")
    if folder is not None:
        if isinstance(world, str) and _is_there(folder / world):
            data["world"] = str((folder / world).resolve())
        _find_rule(data, "destinations", folder)
        for section, key in _PLUG_IN_KEYS:
            if isinstance(data.get(section), dict):
                _find_rule(data[section], key, folder)
    return make_scenario(data, overrides, where=where, origins=origins)


def make_scenario(
    data: Mapping[str, Any] | None = None,
    overrides: Mapping[str, Any] | None = None,
    *,
    where: str = "the scenario",
    origins: Mapping[str, str] | None = None,
) -> Scenario:
    """Make a scenario of nested data and overrides.

    Args:
        data: sections as mappings.
        overrides: values by dotted key.
        where: name of the data in errors.
        origins: name of each override in errors.

    Raises:
        ScenarioError: a key is unknown or has a bad value.
    """
    merged = {key: dict(v) if isinstance(v, Mapping) else v for key, v in (data or {}).items()}
    named = {key: (origins or {}).get(key, "override") for key in overrides or {}}
    for dotted, value in (overrides or {}).items():
        try:
            _put(merged, dotted, value)
        except ScenarioError as error:
            raise ScenarioError(f"{named[dotted]}: {error}") from None
    try:
        return Scenario.model_validate(merged)
    except ValidationError as error:
        wrong, _ = key_of(error.errors(include_url=False)[0], Scenario)
        blamed = next((n for key, n in named.items() if _concerns(key, wrong)), where)
        raise ScenarioError(f"{blamed}: {describe_invalid_keys(error, Scenario)}") from None


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Parse a text in TOML.

    Args:
        text: the text; a byte order mark at its start is ignored.
        where: name of the text in errors.

    Raises:
        ScenarioError: it is not valid TOML.
    """
    try:
        return tomllib.loads(text.removeprefix("\ufeff"))
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{where} is not valid TOML: {error}") from None
    except RecursionError:
        raise ScenarioError(f"{where} is not valid TOML: too many nested brackets") from None


def scenario_toml(scenario: Scenario, header: Mapping[str, Any] | None = None) -> str:
    """A scenario as TOML that can be run again.

    Args:
        scenario: the scenario.
        header: facts on its origin, written to a table ``swarmscout`` that readers skip.
    """
    data = scenario.model_dump(exclude_none=True)
    if header:
        data = {**data, "swarmscout": dict(header)}
    return tomli_w.dumps(data)


def _read(what: str | Path) -> tuple[str, Path | None, str]:
    if isinstance(what, str) and what in named_scenarios():
        resource = resources.files("swarmscout.mission") / "scenarios" / f"{what}.toml"
        return resource.read_text(encoding="utf-8"), None, f"scenario '{what}'"
    if not isinstance(what, str | Path):
        raise ScenarioError(
            f"a scenario is given by its name, a TOML file or a run's folder, not by a "
            f"{type(what).__name__}"
        )
    path = expanded(what)
    if _is_there(path) and path.is_dir():
        path = path / "scenario.toml"
    if not _is_there(path):
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


def _find_rule(data: dict[str, Any], key: str, folder: Path) -> None:
    """Make the file of a plug-in absolute if it lies in the scenario's folder."""
    rule = data.get(key)
    if isinstance(rule, str):
        file, colon, name = rule.rpartition(":")
        if colon and file.endswith(".py") and _is_there(folder / file):
            data[key] = f"{(folder / file).resolve()}:{name}"


def _concerns(given: str, wrong: str) -> bool:
    """Whether one dotted key equals the other or contains it."""
    return f"{given}.".startswith(f"{wrong}.") or f"{wrong}.".startswith(f"{given}.")


def _is_there(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # Not a path: too long, or with a NUL in it.
        return False


def _put(data: dict[str, Any], dotted: str, value: Any) -> None:
    *sections, key = dotted.split(".")
    if not key or not all(sections):
        raise ScenarioError(
            f"'{dotted}' is not a scenario key: write KEY=VALUE or SECTION.KEY=VALUE"
        )
    for section in sections:
        inner = data.setdefault(section, {})
        if isinstance(inner, BaseModel):
            inner = data[section] = inner.model_dump()
        if not isinstance(inner, dict):
            raise ScenarioError(f"scenario key '{dotted}': '{section}' is not a section")
        data = inner
    data[key] = value
