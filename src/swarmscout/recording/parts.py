"""Tables on disk: parts while a mission runs, one file per table when it ends.

A file appears under its name whole or not at all: it is written under a temporary name and renamed.
``parts/coverage-000003.parquet`` is written after the same part of every other table and so vouches
for them. When the mission ends, ``coverage.parquet`` replaces its parts: the joined file is put in
place first and the parts are removed after it, and a reader that finds both takes the joined file.
So whenever the process is killed, no row is lost with a closed part and none is read twice.
"""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from swarmscout.core.errors import RunError
from swarmscout.recording.tables import empty_table

if TYPE_CHECKING:
    import polars as pl

__all__ = ["join_parts", "read_table", "write_part", "write_table", "write_whole"]


def write_whole(path: Path, data: bytes, durable: bool = True) -> None:
    """Write a file that appears whole or not at all.

    Args:
        path: the file. data: what it holds.
        durable: wait until the disk has it, so that it survives a power cut too. That takes a
            millisecond or two, too much for the parts of a short mission.

    Raises:
        RunError: the disk is full, or the folder cannot be written.
    """
    temporary = path.with_name(path.name + ".tmp")
    try:
        if path.exists() and not path.is_file():
            path.write_bytes(data)  # A device such as /dev/stdout is written to, not replaced.
            return
        temporary.write_bytes(data)
        if durable:  # Else a power cut may leave the name without the bytes.
            with temporary.open("r+b") as file:
                os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise RunError(f"cannot write '{path}': {error.strerror or error}") from error


def write_part(folder: Path, table: str, part: int, frame: pl.DataFrame) -> None:
    """Write one part of a table; a part without rows is not written.

    Args:
        folder: the run's folder.
        table: the table's name.
        part: 0 for the first.
        frame: the part's rows.

    Raises:
        RunError: the part cannot be written.
    """
    if frame.height:
        parts = folder / "parts"
        if part == 0:
            with contextlib.suppress(OSError):  # If it cannot be made, the next line says why.
                parts.mkdir(exist_ok=True)
        file = parts / f"{table}-{part:06d}.parquet"
        write_whole(file, _parquet(frame), durable=False)


def write_table(folder: Path, table: str, frame: pl.DataFrame) -> None:
    """Write a table whole, as :func:`join_parts` would leave it.

    Raises:
        RunError: the table cannot be written.
    """
    write_whole(folder / f"{table}.parquet", _parquet(frame))


def join_parts(folder: Path, tables: Iterable[str]) -> None:
    """Join the parts of each table into one file and remove them.

    Raises:
        RunError: a table cannot be written; its parts are still there.
    """
    for table in tables:
        joined = folder / f"{table}.parquet"
        parts = _parts(folder, table)
        if not joined.exists():
            write_whole(joined, _parquet(_read_parts(table, parts)))
        for part in parts:
            part.unlink(missing_ok=True)
    remainder = folder / "parts"
    if remainder.is_dir() and not any(remainder.iterdir()):
        remainder.rmdir()


def read_table(folder: Path, table: str) -> pl.DataFrame:
    """A table, joined or in parts; without rows when there is neither.

    Raises:
        RunError: a file of the table is damaged.
    """
    joined = folder / f"{table}.parquet"
    return _read(joined) if joined.exists() else _read_parts(table, _parts(folder, table))


def _parts(folder: Path, table: str) -> list[Path]:
    return sorted((folder / "parts").glob(f"{table}-*.parquet"))


def _read_parts(table: str, parts: list[Path]) -> pl.DataFrame:
    import polars as pl

    if not parts:
        return empty_table(table)
    # What the clock measures may differ from part to part; every other table has fixed columns.
    how = "diagonal" if table == "timing" else "vertical"
    return pl.concat([_read(part) for part in parts], how=how, rechunk=True)  # type: ignore[arg-type]


def _read(path: Path) -> pl.DataFrame:
    import polars as pl

    try:
        return pl.read_parquet(io.BytesIO(path.read_bytes()))
    except OSError as error:
        raise RunError(f"cannot read '{path}': {error.strerror or error}") from None
    except pl.exceptions.PolarsError:
        raise RunError(
            f"'{path}' is damaged: it is no whole Parquet file (its size is "
            f"{path.stat().st_size} bytes)"
        ) from None


def _parquet(frame: pl.DataFrame) -> bytes:
    buffer = io.BytesIO()
    frame.write_parquet(buffer, compression="zstd", compression_level=1)
    return buffer.getvalue()
