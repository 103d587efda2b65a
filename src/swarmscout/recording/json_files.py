"""``run.json`` and ``summary.json``: JSON objects that carry their own checksum."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from swarmscout.core.errors import RunError
from swarmscout.recording.table_files import checksum, write_whole

__all__ = ["RUN", "SUMMARY", "read_json", "write_json"]

RUN, SUMMARY = "run.json", "summary.json"

_CHECKSUM = "checksum"


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Write an object of plain data.

    Raises:
        RunError: the file cannot be written.
    """
    whole = {**data, _CHECKSUM: _checksum(data)}
    text = json.dumps(whole, indent=2, ensure_ascii=False, allow_nan=False)
    write_whole(path, f"{text}\n".encode(), sweep=False)


def read_json(path: Path, check: bool = True) -> dict[str, Any] | None:
    """The object in a JSON file without its checksum, or None when the file is missing.

    Args:
        path: the file.
        check: compare the checksum.

    Raises:
        RunError: the file cannot be read, or it is damaged.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except OSError as error:
        raise RunError(f"cannot read '{path}': {error.strerror or error}") from None
    except (ValueError, RecursionError):
        raise RunError(f"'{path}' is damaged: it is not valid JSON") from None
    if not isinstance(data, dict):
        raise RunError(f"'{path}' is damaged: it holds no JSON object")
    expected = data.pop(_CHECKSUM, None)
    if check and expected != _checksum(data):
        raise RunError(f"'{path}' is damaged: its content does not match its checksum")
    return data


def _checksum(data: Mapping[str, Any]) -> str:
    # A run may be labelled anew when its rules turn out to be others: rules_version is left out
    # here, and compared between run.json and summary.json instead.
    kept = {key: value for key, value in data.items() if key != "rules_version"}
    return checksum(json.dumps(kept, sort_keys=True, separators=(",", ":")).encode())
