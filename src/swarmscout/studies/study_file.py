"""A study's file: the question, the metric and the comparison, declared before anything runs.

A study runs a base scenario with some keys changed, for every combination of the axes' values and
with the same seeds for each combination.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import tomli_w
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from swarmscout.core.errors import StudyError, did_you_mean
from swarmscout.mission.scenario_files import named_scenarios
from swarmscout.mission.scenario_keys import scenario_keys
from swarmscout.studies.metrics import METRICS

__all__ = [
    "PATH_KEYS",
    "PLACE_KEYS",
    "Axis",
    "AxisValue",
    "Comparison",
    "StudyFile",
    "absolute",
    "base_of",
    "changes_of",
    "checked",
    "dotted",
    "read_study_file",
    "refuse_fifo",
    "study_toml",
]

_PARAMETERS = ("selector.", "policy.", "sensor.")
"""Sections with the parameters of the selector, of the policy for team sizes, of the sensor."""

PLACE_KEYS = ("world", "world_seed", "seed")
"""Keys that set the world and the random streams: the two missions of a pair agree in them."""

MOST_MISSIONS = 1_000_000


class Comparison(BaseModel):
    """What is compared with what."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    axis: str = Field(min_length=1, description="the axis whose values are compared")
    baseline: str | bool | int | float = Field(
        description="the value that the others are compared with"
    )


class StudyFile(BaseModel):
    """The keys of a study's file."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: str = Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100, description="names the folder"
    )
    title: str = Field("", description="the report's title; by default the name")
    question: str = Field(min_length=1, description="the question, in one sentence")
    metric: str = Field("explored_m2", description="the measure that answers the question")
    base: str = Field("paper", description="the scenario that all missions start from")
    trials: int = Field(20, ge=1, le=MOST_MISSIONS, description="missions of each combination")
    first_seed: int = Field(
        0, ge=0, le=2**62, description="seed of the first mission; others count up from it"
    )
    record: Literal["full", "curves", "summary"] = Field("curves", description="what runs record")
    compare: Comparison
    scenario: dict[str, Any] = Field(
        default_factory=dict, description="keys of the base that change"
    )
    axes: dict[str, list[Any]] = Field(min_length=1, description="keys and their values")

    @model_validator(mode="before")
    @classmethod
    def _dotted_axes(cls, data: Any) -> Any:
        """Join nested TOML tables: ``teams.desired_size = [1, 5]`` is one axis."""
        if isinstance(data, dict) and isinstance(data.get("axes"), dict):
            data = {**data, "axes": dict(dotted(data["axes"]))}
        return data


class AxisValue:
    """One value of an axis: its label, and the scenario keys that it sets.

    Attributes:
        label: its name in tables and figures; a number for an axis of numbers.
        keys: dotted scenario keys and their values.
    """

    def __init__(self, label: str | int | float | bool, keys: Mapping[str, Any]) -> None:
        self.label = label
        self.keys = dict(keys)


class Axis:
    """A name and its values.

    Attributes:
        name: a scenario key, or any name when its values are tables.
        values: in the file's order.
    """

    def __init__(self, name: str, values: list[AxisValue]) -> None:
        self.name = name
        self.values = values

    @property
    def keys(self) -> set[str]:
        """Every scenario key that some value sets."""
        return {key for value in self.values for key in value.keys}

    @property
    def labels(self) -> list[str | int | float | bool]:
        """The values' labels."""
        return [value.label for value in self.values]

    @property
    def is_place(self) -> bool:
        """Whether it sets only the world or its seed."""
        return self.keys <= set(PLACE_KEYS)

    @property
    def is_number(self) -> bool:
        """Whether its labels are numbers."""
        return all(
            isinstance(label, int | float) and not isinstance(label, bool) for label in self.labels
        )


def read_study_file(path: str | Path) -> tuple[StudyFile, list[Axis], Path]:
    """Read and check a study's file.

    Args:
        path: the file, or a study's folder that holds one.

    Returns:
        Its keys, its axes, and the folder that relative paths in it are relative to.

    Raises:
        StudyError: the file is missing, unreadable or wrong.
    """
    file = Path(path)
    if file.is_dir():
        if not (file / "study.toml").exists():
            raise StudyError(f"'{file}' is not a study's folder: it has no study.toml")
        file = file / "study.toml"
    where = f"study file '{file}'"
    refuse_fifo(file, where)
    try:
        data = tomllib.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise StudyError(f"{where} does not exist") from None
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
        raise StudyError(f"{where} cannot be read: {reason}") from None
    except RecursionError:
        raise StudyError(f"{where} cannot be read: its brackets are nested too deeply") from None
    except ValueError as error:  # TOMLDecodeError, or an integer of thousands of digits.
        raise StudyError(f"{where} is not valid TOML: {error}") from None
    data.pop("swarmscout", None)  # The version that wrote a kept file.
    try:
        return checked(data, file.resolve().parent)
    except StudyError as error:
        raise StudyError(f"{where}: {error}") from None


def checked(data: Mapping[str, Any], folder: Path) -> tuple[StudyFile, list[Axis], Path]:
    """Check the data of a study's file.

    Args:
        data: the file's keys and values.
        folder: what relative paths are relative to.

    Returns:
        The declared study, its axes, and `folder`.

    Raises:
        StudyError: a key is unknown, missing or has an impossible value.
    """
    try:
        declared = StudyFile.model_validate(data)
    except ValidationError as error:
        raise StudyError(_explain(error)) from None
    axes = [_axis(name, values) for name, values in declared.axes.items()]
    _check(declared, axes)
    return declared, axes, folder


def study_toml(declared: StudyFile, folder: Path, header: Mapping[str, Any]) -> str:
    """The text of a study's file that can be moved to another folder.

    Args:
        declared: the study.
        folder: what relative paths are relative to; paths of existing files become absolute.
        header: versions, kept in a table that readers skip.
    """
    data = declared.model_dump()
    data["base"] = absolute(data["base"], folder)
    _make_absolute(data["scenario"], folder)
    for name, values in data["axes"].items():
        for at, value in enumerate(values):
            if isinstance(value, dict):
                _make_absolute(value, folder)
            elif name in PATH_KEYS:
                values[at] = absolute(value, folder)
    return tomli_w.dumps({**data, "swarmscout": dict(header)})


PATH_KEYS = (
    "world", "destinations", "teams.policy", "sensor.model", "radio.model", "task.model",
    "llm.cassette",
)  # fmt: skip
"""Keys whose values may name a file."""


def _make_absolute(keys: dict[str, Any], folder: Path) -> None:
    for key in PATH_KEYS:
        if key in keys:
            keys[key] = absolute(keys[key], folder)


def absolute(value: Any, folder: Path) -> Any:
    """The absolute path of a file that exists in a folder, or of ``FILE.py:NAME``; else `value`."""
    if not isinstance(value, str):
        return value
    path, colon, name = value.rpartition(":")
    if colon and path.endswith(".py"):
        return f"{(folder / path).resolve()}:{name}" if (folder / path).is_file() else value
    looks_like_one = bool(Path(value).suffix) or len(Path(value).parts) > 1
    return (
        str((folder / value).resolve()) if looks_like_one and (folder / value).exists() else value
    )


def _axis(name: str, values: list[Any]) -> Axis:
    known = {key.key for key in scenario_keys()}
    if name.startswith(_PARAMETERS):
        known.add(name)  # The selector or policy checks its own parameters.
    if not values:
        raise StudyError(f"axis '{name}' has no values")
    tables = [isinstance(value, dict) for value in values]
    if name in known and not all(tables):
        if any(tables):
            raise StudyError(f"axis '{name}' mixes tables and plain values: write one or the other")
        axis = Axis(name, [AxisValue(_plain_label(name, v), {name: v}) for v in values])
    elif all(tables):
        axis = Axis(name, [_joint_value(name, dict(value)) for value in values])
    else:
        near = did_you_mean(name, known)
        raise StudyError(
            f"axis '{name}' is not a scenario key: {near} (an axis of another name needs tables as "
            'values: { label = "…", KEY = VALUE })'
        )
    labels = [str(label) for label in axis.labels]
    if not all(label.isprintable() for label in labels):
        raise StudyError(f"axis '{name}': a label holds a control character")
    doubled = next((label for label in labels if labels.count(label) > 1), None)
    if doubled is not None:
        raise StudyError(f"axis '{name}' has the value {doubled} twice")
    return axis


def _plain_label(name: str, value: Any) -> str | int | float | bool:
    if isinstance(value, bool | int | float):
        return value
    if isinstance(value, str):
        return _short(name, value)
    raise StudyError(f"axis '{name}': {value!r} is neither a number nor a text nor a table")


def _short(key: str, value: str) -> str:
    """``rules/my.py:Far`` as Far and ``maps/cave.yaml`` as cave; anything else as it is."""
    path, colon, name = value.rpartition(":")
    if colon and path.endswith(".py"):
        return name
    is_path = key == "world" and (Path(value).suffix or len(Path(value).parts) > 1)
    return Path(value).stem if is_path else value


def _joint_value(name: str, keys: dict[str, Any]) -> AxisValue:
    label = keys.pop("label", None)
    if not isinstance(label, str | int | float):
        raise StudyError(f"axis '{name}': every table needs a label")
    if not keys:
        raise StudyError(f"axis '{name}', value '{label}': no scenario key is set")
    return AxisValue(label, _scenario_keys(keys))


def dotted(
    keys: Mapping[str, Any], whole: Sequence[str] = (), prefix: str = ""
) -> Iterator[tuple[str, Any]]:
    """Every value under its dotted key; sections named in `whole` stay one value."""
    for key, value in keys.items():
        if isinstance(value, Mapping) and prefix + key not in whole:
            yield from dotted(value, whole, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def _scenario_keys(keys: Mapping[str, Any]) -> dict[str, Any]:
    """Sections of a scenario as dotted keys; a selector's parameters stay one mapping."""
    return dict(dotted(keys, whole=("selector",)))


def _check(declared: StudyFile, axes: list[Axis]) -> None:
    if declared.metric not in METRICS:
        raise StudyError(
            f"metric '{declared.metric}' is unknown: {did_you_mean(declared.metric, METRICS)}"
        )
    by_name = {axis.name: axis for axis in axes}
    compared = by_name.get(declared.compare.axis)
    if compared is None:
        near = did_you_mean(declared.compare.axis, by_name)
        raise StudyError(f"compare.axis '{declared.compare.axis}' is not an axis: {near}")
    if str(declared.compare.baseline) not in map(str, compared.labels):
        near = did_you_mean(str(declared.compare.baseline), map(str, compared.labels))
        raise StudyError(
            f"compare.baseline '{declared.compare.baseline}' is not a value of axis "
            f"'{compared.name}': {near}"
        )
    if len(compared.values) < 2:
        raise StudyError(f"axis '{compared.name}' has one value: there is nothing to compare")
    if "seed" in compared.keys:
        raise StudyError("compare.axis sets 'seed': pairs share a seed, so it cannot be compared")
    seeds = [axis.name for axis in axes if "seed" in axis.keys]
    if seeds or "seed" in declared.scenario:
        where = f"axis '{seeds[0]}'" if seeds else "[scenario]"
        raise StudyError(f"{where} sets 'seed': say trials and first_seed instead")
    missions = declared.trials * math.prod(len(axis.values) for axis in axes)
    if missions > MOST_MISSIONS:
        raise StudyError(
            f"this is {missions:,} missions: at most {MOST_MISSIONS:,} are possible, so take fewer "
            "trials or values"
        )
    owner: dict[str, str] = {}
    for axis in axes:
        for key in axis.keys:
            if owner.setdefault(key, axis.name) != axis.name:
                raise StudyError(f"axes '{owner[key]}' and '{axis.name}' both set '{key}'")


def base_of(declared: StudyFile, folder: Path) -> str | Path:
    """The base scenario's name or file."""
    beside = folder / declared.base
    if declared.base in named_scenarios() or not beside.exists():
        return declared.base
    refuse_fifo(beside, f"base '{beside}'")
    return beside


def refuse_fifo(path: Path, where: str) -> None:
    """Refuse what exists and is neither a file nor a folder: reading a FIFO would never end.

    Raises:
        StudyError: the path is a FIFO, a socket or a device.
    """
    if path.exists() and not path.is_file() and not path.is_dir():
        raise StudyError(f"{where} is not a regular file")


def changes_of(declared: StudyFile, folder: Path) -> dict[str, Any]:
    """The keys that the study changes in its base, dotted; file paths are absolute."""
    keys = _scenario_keys(declared.scenario)
    _make_absolute(keys, folder)
    return keys


def _explain(error: ValidationError) -> str:
    """The first error, in one line."""
    first = error.errors(include_url=False)[0]
    key = ".".join(str(part) for part in first["loc"])
    if first["type"] == "extra_forbidden":
        section: type[BaseModel] = Comparison if "." in key else StudyFile
        return f"unknown key '{key}': {did_you_mean(str(first['loc'][-1]), section.model_fields)}"
    if first["type"] == "missing":
        description = StudyFile.model_fields.get(key)
        meaning = f" ({description.description})" if description and description.description else ""
        return f"key '{key}' is missing{meaning}"
    message = first["msg"].removeprefix("Value error, ").removeprefix("Input ")
    return f"key '{key}' = {repr(first['input'])[:100]}: {message}"
