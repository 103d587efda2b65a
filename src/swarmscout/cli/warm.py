"""``swarmscout warm``: compile every kernel now, so that the first mission does not wait for it."""

from __future__ import annotations

__all__ = ["warm"]


def warm() -> int:
    """Compile every kernel now and keep the result on disk."""
    import time

    from swarmscout.cli.compiling import (
        compile_all,
        load_kernels,
        say_if_compiling,
        uncompiled_kernels,
    )

    began = time.perf_counter()
    load_kernels()
    say_if_compiling()
    compile_all()
    left = uncompiled_kernels()
    seconds = time.perf_counter() - began
    if left:
        print(f"ready after {seconds:.1f} s; compiled when first used: {', '.join(left)}")
    else:
        print(f"ready after {seconds:.1f} s: every kernel is compiled")
    return 0
