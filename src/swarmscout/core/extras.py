"""How to install an optional part of the package, for errors that say so."""

from __future__ import annotations

from pathlib import Path

__all__ = ["install_command"]


def install_command(extra: str) -> str:
    """The command that installs an extra: from a clone where the package runs in one.

    Args:
        extra: one of ``pyproject.toml``'s optional dependencies.

    Returns:
        ``pip install 'swarmscout[mesh]'``, or in a clone ``pip install -e '.[mesh]'``.
    """
    clone = Path(__file__).parents[3]
    if not (clone / "pyproject.toml").is_file():
        return f"pip install 'swarmscout[{extra}]'"
    where = "." if clone == Path.cwd() else str(clone)
    pip = ".venv/bin/pip" if where == "." and (clone / ".venv/bin/pip").exists() else "pip"
    return f"{pip} install -e '{where}[{extra}]'"
