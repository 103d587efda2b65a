"""Tables on disk: parts while a mission runs, one file per table when it ends.

A file appears under its name whole or not at all: it is written under a temporary name and renamed.
``parts/coverage-000003.parquet`` is written after the same part of every other table and so vouches
for them. When the mission ends, ``coverage.parquet`` replaces its parts: the joined file is put in
place first and the parts are removed after it, and a reader that finds both takes the joined file.
So whenever the process is killed, no row is lost with a closed part and none is read twice.

A mission that closes no parts writes all its tables at once, as Arrow streams, into ``data.zip``
beside its final map: of many short missions it is files that cost, and making Parquet. What a clock
measured is apart, in ``timing.zip``, so that all other files of two equal missions are the same.
"""

from __future__ import annotations

import contextlib
import io
import os
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from swarmscout.core.errors import RunError
from swarmscout.recording.archives import array_files, zipped
from swarmscout.recording.tables import empty_table

if TYPE_CHECKING:
    import polars as pl
    from numpy.typing import ArrayLike

__all__ = [
    "AT_ONCE",
    "join_parts",
    "read_table",
    "read_whole_table",
    "write_at_once",
    "write_part",
    "write_whole",
]

AT_ONCE = "data.zip"
"""The file of a run that closed no parts: its tables, and the arrays of ``map.npz``."""

_TIMING = "timing.zip"


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
        _fill(temporary, data, durable)
        os.replace(temporary, path)
    except OSError as error:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise RunError(f"cannot write '{path}': {error.strerror or error}") from error


def _fill(path: Path, data: bytes, durable: bool) -> None:
    with open(path, "wb") as file:
        file.write(data)
        if durable:  # Else a power cut may leave the name without the bytes.
            file.flush()
            os.fsync(file.fileno())


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


def write_at_once(
    folder: Path, frames: Mapping[str, pl.DataFrame], arrays: Mapping[str, ArrayLike]
) -> None:
    """Write all that a run holds at once, in place of parts.

    Args:
        folder: the run's folder.
        frames: the tables by their names.
        arrays: what ``map.npz`` would hold; none when the mission was broken off.

    Raises:
        RunError: a file cannot be written.
    """
    streams = {}
    for table, frame in frames.items():
        stream = io.BytesIO()
        frame.write_ipc_stream(stream, compression="zstd")
        streams[_stream_name(table)] = stream.getvalue()
    measured = streams.pop(_stream_name("timing"), None)
    if measured is not None:
        write_whole(folder / _TIMING, zipped({}, stored={_stream_name("timing"): measured}))
    write_whole(folder / AT_ONCE, zipped(array_files(arrays), stored=streams))


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


def read_whole_table(folder: Path, table: str) -> pl.DataFrame | None:
    """A table that is there whole, joined or written at once; None when there is neither.

    Raises:
        RunError: the file of the table is damaged.
    """
    joined = folder / f"{table}.parquet"
    if joined.exists():
        return _read(joined)
    stream = _stream(folder, table)
    return None if stream is None else _read_stream(_archive(folder, table), table, stream)


def read_table(folder: Path, table: str) -> pl.DataFrame:
    """A table, joined, written at once, or in parts; without rows when there is none of these.

    Raises:
        RunError: a file of the table is damaged.
    """
    whole = read_whole_table(folder, table)
    return _read_parts(table, _parts(folder, table)) if whole is None else whole


def _stream(folder: Path, table: str) -> bytes | None:
    """A table among those written at once, as the bytes of its Arrow stream."""
    path = _archive(folder, table)
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise RunError(f"cannot read '{path}': {error.strerror or error}") from None
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as file:
            name = _stream_name(table)
            # A damaged stream could end the process that reads it: here its checksum is compared.
            return file.read(name) if name in file.namelist() else None
    except Exception:  # Of a damaged archive zipfile raises whatever its parsers do.
        raise RunError(
            f"'{path}' is damaged: it is no whole archive (its size is {len(data)} bytes)"
        ) from None


def _archive(folder: Path, table: str) -> Path:
    return folder / (_TIMING if table == "timing" else AT_ONCE)


def _stream_name(table: str) -> str:
    return f"{table}.arrows"


def _read_stream(path: Path, table: str, stream: bytes) -> pl.DataFrame:
    import polars as pl

    try:
        return pl.read_ipc_stream(io.BytesIO(stream))
    except (OSError, pl.exceptions.PolarsError):
        raise RunError(f"'{path}' is damaged: its '{table}' is no table") from None


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
