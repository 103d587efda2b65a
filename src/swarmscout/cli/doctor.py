"""``swarmscout doctor``: what is installed and where things are kept."""

from __future__ import annotations

from pathlib import Path

__all__ = ["doctor"]

_PACKAGES = ("numpy", "numba", "scipy", "pydantic", "polars", "matplotlib", "pillow", "cyclopts")


def doctor(*, llm: bool = False, provider: str | None = None, model: str | None = None) -> int:
    """Show versions, cores, and whether the folders for caches and runs are writable.

    Args:
        llm: ask a language model one small question, and say what works.
        provider: who is asked: openai, azure, embedded, or a server's address; by default whoever
            the environment names.
        model: the model's name, or Azure's deployment.
    """
    if llm or provider or model:
        from swarmscout.cli.doctor_llm import ask_once

        return ask_once(provider, model)
    import os
    import platform
    import sys
    from importlib.metadata import PackageNotFoundError, version

    from swarmscout import __version__
    from swarmscout.mission.mission import RULES_VERSION

    troubles = []
    python = f"Python {platform.python_version()}"
    print(f"swarmscout  {__version__}, rules {RULES_VERSION}, {python}")
    system = f"{platform.system()} {platform.machine()}"
    print(f"system      {system}, {_cores()} cores for this process")
    for package in _PACKAGES:
        try:
            print(f"{package:<10}  {version(package)}")
        except PackageNotFoundError:
            print(f"{package:<10}  missing")
            troubles.append(f"{package} is not installed")

    from swarmscout.cli.compiling import cache_folders, load_kernels, uncompiled_kernels

    kernels = load_kernels()
    ready = kernels - len(uncompiled_kernels())
    print(f"kernels     {ready} of {kernels} compiled" + ("" if ready == kernels else ": run warm"))
    caches = cache_folders()
    cache = Path(os.path.commonpath(caches))
    for what, shown, folders, remedy in (
        ("cache", cache, caches, "set NUMBA_CACHE_DIR to one that is"),
        ("runs", Path("runs"), [Path("runs")], "work in another one"),
    ):
        locked = [folder for folder in folders if not _writable(folder)]
        print(f"{what:<10}  {shown} ({'NOT writable' if locked else 'writable'})")
        troubles += [f"folder '{folder}' is not writable: {remedy}" for folder in locked[:1]]
    for trouble in troubles:
        print(f"error: {trouble}", file=sys.stderr)
    return 2 if troubles else 0


def _cores() -> int:
    import os

    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _writable(folder: Path) -> bool:
    """Whether a file can be made in a folder, or the folder itself in the nearest one there is."""
    import os
    import tempfile

    there = folder.absolute()
    while not there.exists():
        there = there.parent
    if not (there.is_dir() and os.access(there, os.W_OK)):
        return False
    try:
        with tempfile.TemporaryFile(dir=there):
            return True
    except OSError:
        return False
