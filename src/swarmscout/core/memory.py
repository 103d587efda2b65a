"""How much memory this machine has."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

__all__ = ["machine_memory"]

_CONTAINER_LIMIT = Path("/sys/fs/cgroup/memory.max")


def machine_memory() -> int | None:
    """Bytes of memory that this process can have at most; None where the system does not tell.

    That of the machine, or the limit of the container that the process runs in.
    """
    try:
        limits = [os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")]
    except (AttributeError, ValueError, OSError):  # Windows has no such function.
        return None
    with suppress(OSError, ValueError):  # No container, or "max": no limit.
        limits.append(int(_CONTAINER_LIMIT.read_text()))
    return min(limits)
