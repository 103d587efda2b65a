"""An exception in a user's code as one line, with the place where it arose."""

from __future__ import annotations

import os
import sysconfig
from pathlib import Path
from traceback import walk_tb

__all__ = ["describe_error"]

_NOT_USERS = (
    "<",  # Code that lies in no file.
    str(Path(__file__).parents[1]) + os.sep,
    *(sysconfig.get_path(name) + os.sep for name in ("stdlib", "platstdlib", "purelib", "platlib")),
)


def describe_error(error: BaseException) -> str:
    """An exception as one line with the place in the user's code: ``KeyError: 3 (my.py, line 7)``.

    The place is the deepest one that is neither in this package nor in a library.
    """
    said = " ".join(str(error).split())
    if isinstance(error, SystemExit):
        said = f"the code called sys.exit({'' if error.code is None else repr(error.code)})"
    else:
        said = f"{type(error).__name__}: {said}" if said else type(error).__name__
    place = None
    for frame, line in walk_tb(error.__traceback__):
        file = frame.f_code.co_filename
        if not file.startswith(_NOT_USERS):
            place = file, line
    if isinstance(error, SyntaxError) and error.filename and error.lineno:
        place = error.filename, error.lineno
        said = f"{type(error).__name__}: {error.msg}"
    return said if place is None else f"{said} ({_short(place[0])}, line {place[1]})"


def _short(file: str) -> str:
    """A file's path relative to the working directory, where it lies below."""
    try:
        return str(Path(file).relative_to(Path.cwd()))
    except (ValueError, OSError):
        return file
