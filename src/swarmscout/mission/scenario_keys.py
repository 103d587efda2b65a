"""Every key of a scenario: its default, range and meaning, read from the model itself."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal, NamedTuple, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from swarmscout.mission.scenario import Scenario

__all__ = ["ScenarioKey", "scenario_keys", "scenario_page"]

_BOUNDS = {"ge": "from {}", "gt": "above {}", "le": "to {}", "lt": "below {}"}


class ScenarioKey(NamedTuple):
    """One key.

    Attributes:
        key: its dotted name.
        default: as TOML would write it.
        range: the values that it takes; empty where its type says it all.
        meaning: what it is, with its unit.
    """

    key: str
    default: str
    range: str
    meaning: str


def scenario_keys() -> list[ScenarioKey]:
    """All keys, in the model's order."""
    return list(_keys(Scenario, ""))


def _keys(model: type[BaseModel], prefix: str) -> Iterator[ScenarioKey]:
    for name, info in model.model_fields.items():
        if isinstance(info.annotation, type) and issubclass(info.annotation, BaseModel):
            yield from _keys(info.annotation, f"{prefix}{name}.")
        else:
            default = info.get_default(call_default_factory=True)
            meaning = info.description or ""
            yield ScenarioKey(f"{prefix}{name}", _toml(default), _range(info), meaning)


def _range(info: FieldInfo) -> str:
    if get_origin(info.annotation) is Literal:
        return ", ".join(_toml(choice) for choice in get_args(info.annotation))
    if info.annotation is bool:
        return "true, false"
    words = [
        pattern.format(_number(getattr(bound, name)))
        for name, pattern in _BOUNDS.items()
        for bound in info.metadata
        if getattr(bound, name, None) is not None
    ]
    return " ".join(words)


def _number(value: float) -> str:
    return f"{value:,}" if isinstance(value, int) else f"{value:g}"


def _toml(value: Any) -> str:
    if value is None:
        return "not set"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{}"
    return f'"{value}"' if isinstance(value, str) else f"{value:g}"


def scenario_page() -> str:
    """The reference page ``docs/scenario.md``."""
    lines = [
        "# Scenario",
        "",
        "All keys; the defaults are those of the scenario `paper`. In a TOML file, the key",
        "`teams.desired_size` is `desired_size` in the section `[teams]`; on the command line,",
        "`--set teams.desired_size=3`. [The paper](paper.md) lists the keys that the paper leaves",
        "open. `swarmscout list keys` prints this table, `swarmscout schema` a JSON schema for",
        "editors. In keys that hold a path, `~` and environment variables are replaced.",
        "",
        "This page is made by `python -m swarmscout.mission.scenario_keys > docs/scenario.md`.",
        "",
        "| key | default | range | meaning |",
        "|---|---|---|---|",
    ]
    lines += [
        f"| `{key.key}` | `{key.default}` | {key.range} | {key.meaning} |"
        for key in scenario_keys()
    ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(scenario_page(), end="")
