"""``swarmscout doctor``: what is installed and where things are kept."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

__all__ = ["doctor"]

_PACKAGES = ("numpy", "numba", "scipy", "pydantic", "polars", "matplotlib", "pillow", "cyclopts")


def doctor(
    *,
    llm: Annotated[str | None, Parameter(metavar="[PROVIDER]")] = None,
    llm_model: str | None = None,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """Show versions, cores, and whether the folders for caches and runs are writable.

    Args:
        llm: send one small question to a language model and report what works: openai, azure,
            embedded, or the address of a compatible server; without a value, the provider is
            taken from environment variables.
        llm_model: the model's name, or Azure's deployment.
        json: print one JSON object.
    """
    if llm or llm_model:
        from swarmscout.cli.doctor_llm import ask_once

        return ask_once(llm, llm_model)
    facts, troubles = _facts()
    if json:
        from json import dumps

        print(dumps({**facts, "problems": troubles}, indent=2))
    else:
        for name, text in facts.items():
            print(f"{name:<10}  {text}")
    for trouble in troubles:
        print(f"error: {trouble}", file=sys.stderr)
    return 2 if troubles else 0


def _facts() -> tuple[dict[str, Any], list[str]]:
    """What is installed and where things are, and what is wrong with it."""
    import platform
    from importlib.metadata import PackageNotFoundError, version

    from swarmscout import __version__
    from swarmscout.core.cores import usable_cores
    from swarmscout.mission.mission import RULES_VERSION

    troubles = []
    python = f"Python {platform.python_version()}"
    system = f"{platform.system()} {platform.machine()}"
    facts = {
        "swarmscout": f"{__version__}, rules {RULES_VERSION}, {python}",
        "system": f"{system}, {usable_cores()} cores for this process",
    }
    for package in _PACKAGES:
        try:
            facts[package] = version(package)
        except PackageNotFoundError:
            facts[package] = "missing"
            troubles.append(f"{package} is not installed")
    kernels, folders = _caches()
    facts["kernels"] = kernels
    for what, shown, parts, remedy in (
        ("cache", _common(folders), folders, "set NUMBA_CACHE_DIR to one that is"),
        ("runs", Path("runs"), [Path("runs")], "work in another one"),
    ):
        locked = [folder for folder in parts if not _writable(folder)]
        facts[what] = f"{shown} ({'NOT writable' if locked else 'writable'})"
        troubles += [f"folder '{folder}' is not writable: {remedy}" for folder in locked[:1]]
    return facts, troubles


def _caches() -> tuple[str, list[Path]]:
    """How many kernels are compiled, and the folders that keep them."""
    from swarmscout.cli.compiling import cache_folders, load_kernels, uncompiled_kernels

    kernels = load_kernels()
    ready = kernels - len(uncompiled_kernels())
    hint = "" if ready == kernels else " (swarmscout warm compiles all)"
    return f"{ready} of {kernels} compiled{hint}", cache_folders()


def _common(folders: list[Path]) -> Path:
    import os

    return Path(os.path.commonpath(folders))


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
