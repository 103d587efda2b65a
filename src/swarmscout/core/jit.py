"""How every kernel of the package is compiled.

Each kernel is cached on disk, has one signature (a test asserts it) and calls no kernel of another
file: Numba's cache does not notice a change in a function that lives elsewhere. No ``fastmath`` and
no ``parallel``: bits agree across processors and thread counts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba

from swarmscout.core.errors import SwarmscoutError

__all__ = ["inlined", "kernel", "kernels"]

F = TypeVar("F", bound=Callable[..., Any])

kernels: dict[str, Any] = {}
"""Every kernel that has been imported so far, by its qualified name."""


def kernel(function: F) -> F:
    """Compile a function at its first call and keep the result on disk.

    Raises:
        SwarmscoutError: Numba is told not to compile.
    """
    if numba.config.DISABLE_JIT:
        raise SwarmscoutError("NUMBA_DISABLE_JIT is set: missions run compiled only, unset it")
    compiled = numba.njit(cache=True, nogil=True, error_model="numpy")(function)
    kernels[f"{function.__module__}.{function.__name__}"] = compiled
    return compiled  # type: ignore[no-any-return]


def inlined(function: F) -> F:
    """Compile a small function that kernels of the same file call; it is no kernel itself."""
    return numba.njit(nogil=True, error_model="numpy")(function)  # type: ignore[no-any-return]
