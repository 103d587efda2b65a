"""How every kernel of the package is compiled.

Each kernel is cached on disk, has one signature (a test asserts it) and calls no kernel of another
file. Numba's own cache does not notice a change in another file; constants and inlined functions
that kernels import come from the files in :data:`SHARED`, which this cache watches too. No
``fastmath`` and no ``parallel``: bits agree across processors and thread counts.

With ``NUMBA_BOUNDSCHECK=1`` an index outside an array is an ``IndexError`` instead of undefined
behaviour. Kernels that check are slower, and cached beside the others.
"""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile

from swarmscout.core.errors import SwarmscoutError

__all__ = ["SHARED", "KernelCache", "allocating", "inlined", "kernel", "kernels"]

F = TypeVar("F", bound=Callable[..., Any])

kernels: dict[str, Any] = {}
"""Every kernel that has been imported so far, by its qualified name."""

SHARED = (
    "core/cells.py",
    "core/components.py",
    "core/enums.py",
    "core/events.py",
    "core/segments.py",
    "destinations/claims.py",
    "destinations/criteria_blocks.py",
    "destinations/criteria_seeker.py",
    "destinations/offers.py",
    "destinations/path_lengths.py",
    "destinations/walking.py",
    "mapping/footprint.py",
    "mapping/occupancy.py",
    "minds/given_up.py",
    "minds/modes.py",
    "planning/far_routes.py",
    "planning/neighbours.py",
    "planning/regions.py",
    "planning/route_table.py",
    "planning/search_memory.py",
    "planning/spread.py",
    "planning/tolls.py",
    "worlds/meshes/tiles.py",
)
"""Files of the package from which kernels of other files import constants and functions."""


@cache
def _shared_stamp() -> str:
    """A digest of the files in SHARED, and of this one, which says how all are compiled."""
    package = Path(__file__).parents[1]
    files = [Path(__file__), *(package / name for name in SHARED)]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


class KernelCache(FunctionCache):  # type: ignore[misc]
    """Numba's disk cache of one kernel, which also recompiles what it cannot read.

    Numba raises whatever its unpickling raises when a file was cut off or overwritten.

    Args:
        function: the kernel.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        own_stamp = self._impl.locator.get_source_stamp()
        checked = ".checked" if numba.config.BOUNDSCHECK else ""
        self._cache_file = IndexDataCacheFile(
            cache_path=self._cache_path,
            filename_base=self._impl.filename_base + checked,
            source_stamp=(own_stamp, _shared_stamp()),
        )

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled code of a signature, or None when it must be compiled."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:
            with contextlib.suppress(OSError):  # The save that follows names what is wrong.
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep compiled code.

        Raises:
            SwarmscoutError: the cache folder is full or cannot be written.
        """
        try:
            super().save_overload(sig, data)
        except OSError as error:
            raise SwarmscoutError(
                f"cannot keep compiled kernels in '{self.cache_path}': {error.strerror or error}; "
                "free space there, or set NUMBA_CACHE_DIR to another folder"
            ) from None

    def is_filled(self) -> bool:
        """Whether it holds compiled code of the kernel's present source."""
        try:
            return bool(self._cache_file._load_index())
        except Exception:  # Damaged: it will be compiled again.
            return False


def kernel(function: F) -> F:
    """Compile a function at its first call and keep the result on disk.

    Raises:
        SwarmscoutError: Numba is told not to compile.
    """
    if numba.config.DISABLE_JIT:
        raise SwarmscoutError("NUMBA_DISABLE_JIT is set: missions run compiled only, unset it")
    compiled = numba.njit(nogil=True, error_model="numpy", _nrt=True)(function)
    compiled._cache = KernelCache(function)  # As `cache=True` does with Numba's own.
    kernels[f"{function.__module__}.{function.__name__}"] = compiled
    return compiled  # type: ignore[no-any-return]


def inlined(function: F) -> F:
    """Compile a small function into the kernels of the same file, or of any if it is in SHARED.

    It neither makes arrays nor returns them, so Numba need not count references to those that it is
    given: the counting takes up to two fifths of the time of a search.
    """
    compile_it = numba.njit(nogil=True, error_model="numpy", forceinline=True, _nrt=False)
    return compile_it(function)  # type: ignore[no-any-return]


def allocating(function: F) -> F:
    """Compile a function that kernels call, as :func:`inlined`, but one that makes arrays."""
    return numba.njit(nogil=True, error_model="numpy", _nrt=True)(function)  # type: ignore[no-any-return]
