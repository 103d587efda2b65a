"""The package's own version."""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, version

__all__ = ["package_version"]


@cache
def package_version() -> str:
    """The installed version of swarmscout; ``0+unknown`` in a checkout that is not installed."""
    try:
        return version("swarmscout")
    except PackageNotFoundError:
        return "0+unknown"
