"""Paths as users write them: with ``~`` and environment variables."""

from __future__ import annotations

import os
from pathlib import Path

from swarmscout.core.errors import SwarmscoutError

__all__ = ["expanded"]


def expanded(path: str | Path) -> Path:
    """A path with a leading ``~`` and with ``$NAME`` or ``${NAME}`` replaced.

    A shell does this only for words of their own: it leaves ``--out=~/runs`` as it is.

    Raises:
        SwarmscoutError: the path begins with a variable that is not set, or with a ``~user``
            without a home folder. Anywhere else ``$`` and ``~`` can be part of a name.
    """
    text = str(path)
    if "~" not in text and "$" not in text:
        return Path(path)
    result = os.path.expandvars(os.path.expanduser(text))
    if result.startswith("$"):
        name = result.split(os.sep)[0]
        raise SwarmscoutError(f"path '{path}': the environment variable {name} is not set")
    if result.startswith("~") and not os.path.lexists(result):
        raise SwarmscoutError(f"path '{path}': '{result.split(os.sep)[0]}' has no home folder")
    return Path(result)
