"""Cassettes: recorded requests and replies, to replay a mission without a model.

A cassette is a text file with one JSON object per line, addressed by the request: model,
parameters, messages, schema and the attempt's number. Lines are only ever appended, under a lock,
so several processes may write to one cassette, and cassettes are merged by concatenating them.
Where a request stands twice the later line counts. What a killed process left of a line is cut off
before the next one is written, and skipped where it stands between others.
"""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import IO, Any

from swarmscout.core.errors import ModelError
from swarmscout.core.language_model import Model, Reply, Request
from swarmscout.core.text import clean_line
from swarmscout.llm.clean import clean_reply

__all__ = ["MODES", "Cassette", "Tape"]

MODES = ("auto", "record", "replay", "refresh")
"""``replay`` asks no model; ``record`` asks for what is missing; ``refresh`` asks for everything
anew; ``auto`` is ``record`` with a model at hand and ``replay`` without one."""

_SHOWN = 60
_BEGINNING = '{"attempt"'
_READER = json.JSONDecoder(strict=False, parse_int=lambda n: int(n) if len(n) < 20 else None)


@dataclass(frozen=True, slots=True)
class _Entry:
    """An entry of a cassette: the request, in plain data, and the reply."""

    asked: dict[str, Any]
    reply: Reply


class Tape:
    """A cassette's file.

    Args:
        path: the file; it need not exist.

    Raises:
        ModelError: the file cannot be read, or a line is damaged.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.entries: dict[str, _Entry] = {}
        self._lock = threading.Lock()
        self._read = 0
        self._line = 0
        if path.exists():
            with self._opened("rb") as file:
                self._catch_up(file)

    def models(self) -> list[str]:
        """Names of the models on the cassette."""
        return sorted({clean_line(entry.asked["model"]) for entry in self.entries.values()})

    def add(self, key: str, asked: Mapping[str, Any], reply: Reply, *, anew: bool) -> Reply:
        """Append an entry unless another process has appended it already.

        Args:
            key: the request's address.
            asked: the request.
            reply: the reply.
            anew: append in any case.

        Returns:
            The reply that counts.

        Raises:
            ModelError: the file cannot be written.
        """
        entry = {"key": key, **asked, "reply": asdict(reply)}
        line = json.dumps(entry, ensure_ascii=False, sort_keys=True).encode(errors="replace")
        with self._lock, self._opened("a+b") as file, _locked(file) as alone:
            rest = self._catch_up(file)
            found = self.entries.get(key)
            if found is not None and not anew and not found.reply.failure:
                return found.reply
            file.seek(0, os.SEEK_END)
            data = line + b"\n"
            if rest and alone and not self._entries_in(rest, self._line + 1, ended=False):
                file.truncate(self._read)  # A process was killed while it wrote.
                file.seek(0, os.SEEK_END)
            elif rest:
                data = b"\n" + data
            file.write(data)
            file.flush()
            self._read = file.tell()
            self._line += data.count(b"\n")
            self.entries[key] = _Entry(dict(asked), reply)
        return reply

    @contextmanager
    def _opened(self, how: str) -> Any:
        try:
            if how != "rb":
                self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.open(how) as file:
                yield file
        except OSError as error:
            raise ModelError(
                f"cassette '{self.path}' cannot be used: {error.strerror or error}"
            ) from None

    def _catch_up(self, file: IO[bytes]) -> bytes:
        """Read what was appended since the last time.

        Returns:
            What stands behind the last line end: a line that is being written, or a torn one.
        """
        file.seek(self._read)
        data = file.read()
        whole = data.rfind(b"\n") + 1
        for line in data[:whole].split(b"\n")[:-1]:
            self._line += 1
            self.entries.update(self._entries_in(line, self._line, ended=True))
        self._read += whole
        rest = data[whole:]
        self.entries.update(self._entries_in(rest, self._line + 1, ended=False))
        return rest

    def _entries_in(self, line: bytes, number: int, *, ended: bool) -> dict[str, _Entry]:
        """Entries in a line: one, or several that were merged without a line end between them.

        A torn entry is skipped: one that ends in the middle, or in which another one begins.

        Args:
            line: the line.
            number: its number, for errors.
            ended: whether a line end follows.

        Raises:
            ModelError: something else stands there, or an entry has an impossible value.
        """
        text = line.decode("utf-8", "replace").lstrip("\ufeff").strip()
        found: dict[str, _Entry] = {}
        at = 0
        while at < len(text):
            try:
                data, end = _READER.raw_decode(text, at)
            except (ValueError, RecursionError):
                following = text.find(_BEGINNING, at + 1)
                piece = text[at:] if following < 0 else text[at:following]
                begun = piece.startswith('{"') or _BEGINNING.startswith(piece)
                if not begun or (following < 0 and ended and text.endswith('"}')):
                    raise self._damaged(number, "this is not an entry of a cassette") from None
                if following < 0:
                    break
                at = following
                continue
            key, entry = self._entry(data, number)
            found[key] = entry
            at = end
            while at < len(text) and text[at].isspace():
                at += 1
        return found

    def _entry(self, data: Any, number: int) -> tuple[str, _Entry]:
        try:
            key, reply = str(data.pop("key")), Reply(**data.pop("reply"))
            data["messages"] = [(str(role), str(text)) for role, text in data["messages"]]
            asked = data["attempt"] and data["params"].keys() and str(data["model"])
        except (ValueError, TypeError, KeyError, AttributeError):
            asked = None
        if not asked:
            raise self._damaged(number, "this is not an entry of a cassette")
        try:
            return key, _Entry(data, clean_reply(reply))
        except TypeError as error:
            raise self._damaged(number, f"the reply's {error}") from None

    def _damaged(self, number: int, what: str) -> ModelError:
        return ModelError(f"cassette '{self.path}', line {number}: {what}")


class Cassette:
    """A model with a cassette in front of it; see ``core.language_model.Model``.

    Args:
        tape: the cassette.
        mode: one of :data:`MODES`.
        model: answers requests that are not on it; None in ``replay``.
        name: the model's name.
        params: what else an answer depends on.
    """

    def __init__(
        self,
        tape: Tape,
        mode: str,
        model: Model | None,
        name: str,
        params: Mapping[str, Any],
    ) -> None:
        self._tape = tape
        self._mode = mode
        self._model = model
        self._name = name
        self._params = dict(params)
        self._fresh: set[str] = set()

    def close(self) -> None:
        """Close the model; see ``core.language_model.Model``."""
        close = getattr(self._model, "close", None)
        if close is not None:
            close()

    def complete(self, request: Request) -> Reply:
        """The recorded reply, or else the model's, which is then recorded.

        Raises:
            ModelError: a request is not on the cassette and there is no model to ask, or the model
                broke its contract.
        """
        asked = self._asked(request)
        key = sha256(_canonical(asked).encode(errors="replace")).hexdigest()[:32]
        found = self._tape.entries.get(key)
        if self._model is None:
            if found is None:
                raise ModelError(self._missing(asked, key))
            return found.reply
        anew = self._mode == "refresh" and key not in self._fresh
        if found is not None and not anew and not found.reply.failure:
            return found.reply
        answer = self._model.complete(request)
        try:
            answer = clean_reply(answer)
        except (TypeError, AttributeError):
            return answer  # The dispatcher says what is wrong with it.
        reply = self._tape.add(key, asked, answer, anew=anew)
        self._fresh.add(key)
        return reply

    def _asked(self, request: Request) -> dict[str, Any]:
        schema = "" if request.schema is None else _canonical(request.schema)
        return {
            "model": self._name,
            "params": {**self._params, "max_tokens": request.max_tokens},
            "attempt": request.attempt,
            "schema": sha256(schema.encode(errors="replace")).hexdigest()[:16] if schema else "",
            "messages": [[message.role, message.text] for message in request.messages],
        }

    def _missing(self, asked: Mapping[str, Any], key: str) -> str:
        where = f"cassette '{self._tape.path}'"
        how = "--llm-mode auto asks the model for what is missing"
        if not self._tape.entries:
            return f"{where} is empty: {how}"
        nearest = max(
            (entry.asked for entry in self._tape.entries.values()),
            key=lambda other: _likeness(other, asked),
        )
        return (
            f"{where} has no answer to request {key[:8]}; the nearest of its "
            f"{len(self._tape.entries)} differs in {_difference(nearest, asked)}; {how}"
        )


def _canonical(data: Any) -> str:
    return json.dumps(data, ensure_ascii=False, sort_keys=True, separators=(",", ":"))


def _likeness(one: Mapping[str, Any], other: Mapping[str, Any]) -> tuple[int, int]:
    """Similarity of two requests: equal parts, then lines in common."""
    parts = sum(one[part] == other[part] for part in ("model", "params", "attempt"))
    mine = {line for _, text in one["messages"] for line in str(text).splitlines()}
    theirs = {line for _, text in other["messages"] for line in str(text).splitlines()}
    return parts, len(mine & theirs)


def _difference(recorded: Mapping[str, Any], asked: Mapping[str, Any]) -> str:
    """The first difference between two requests, in words."""
    for part in ("model", "params", "attempt"):
        if recorded[part] != asked[part]:
            return f"{part}: recorded {recorded[part]!r}, asked {asked[part]!r}"
    if len(recorded["messages"]) != len(asked["messages"]):
        return (
            f"the number of messages: recorded {len(recorded['messages'])}, "
            f"asked {len(asked['messages'])}"
        )
    for (_, old), (role, new) in zip(recorded["messages"], asked["messages"], strict=True):
        before, now = [*str(old).splitlines(), ""], [*str(new).splitlines(), ""]
        for number, (a, b) in enumerate(zip(before, now, strict=False), start=1):
            if a != b:
                return (
                    f"the {role} message, line {number}: recorded {a[:_SHOWN]!r}, "
                    f"asked {b[:_SHOWN]!r}"
                )
    return "the schema of the answer"


@contextmanager
def _locked(file: IO[bytes]) -> Iterator[bool]:
    """Keep other processes from appending; yields whether that is certain."""
    try:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX)
    except (ImportError, OSError):
        yield False  # No locks on this system or file system: one write per line has to do.
        return
    try:
        yield True
    finally:
        fcntl.flock(file, fcntl.LOCK_UN)
