"""Every key of a scenario, with its default and meaning, read from the model itself."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from swarmscout.mission.scenario import Scenario
from swarmscout.robots.sensors.parameters import RECORDS

__all__ = ["scenario_keys", "scenario_page"]


def scenario_keys() -> list[tuple[str, str, str]]:
    """Dotted key, default as TOML would write it, and meaning, in the model's order."""
    return list(_keys(Scenario, ""))


def _keys(model: type[BaseModel], prefix: str) -> Iterator[tuple[str, str, str]]:
    for name, info in model.model_fields.items():
        default = info.default
        if isinstance(default, BaseModel):
            yield from _keys(type(default), f"{prefix}{name}.")
        else:
            default = info.get_default(call_default_factory=True)
            yield f"{prefix}{name}", _toml(default), _meaning(info)


def _meaning(info: FieldInfo) -> str:
    text = info.description or ""
    if get_origin(info.annotation) is Literal:
        choices = ", ".join(_toml(choice) for choice in get_args(info.annotation))
        text = f"{text} (one of {choices})"
    return text


def _toml(value: Any) -> str:
    if value is None:
        return "not set"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{}"
    return f'"{value}"' if isinstance(value, str) else f"{value:g}"


def _rows(keys: Iterable[tuple[str, str, str]]) -> list[str]:
    return [f"| `{key}` | `{default}` | {text} |" for key, default, text in keys]


def scenario_page() -> str:
    """The reference page ``docs/scenario.md``."""
    lines = [
        "# Scenario",
        "",
        "Every key, with its default: the scenario `paper`. In a TOML file `teams.desired_size`",
        "stands as `desired_size` in the section `[teams]`; on the command line it is",
        "`--set teams.desired_size=3`. `docs/paper.md` says which of them the paper leaves open.",
        "",
        "This page is made by `python -m swarmscout.mission.scenario_keys > docs/scenario.md`.",
        "",
        "| key | default | meaning |",
        "|---|---|---|",
    ]
    lines += _rows(scenario_keys())
    for name, record in RECORDS.items():
        if name not in ("fan", "own"):
            lines += [
                "",
                f'With `sensor.model = "{name}"` the section `[sensor]` has these keys:',
                "",
            ]
            lines += ["| key | default | meaning |", "|---|---|---|"]
            lines += _rows(_keys(record, "sensor."))
    lines += ["", "A sensor of another package or file takes its own parameters there: see"]
    lines += ["[sensors](sensors.md)."]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(scenario_page(), end="")
