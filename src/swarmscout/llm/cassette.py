"""Cassettes: requests and replies on record, so that a mission can be replayed without a model.

A cassette is a text file with one JSON object a line, addressed by what was asked: model,
parameters, messages, schema and the attempt's number. Lines are only ever appended, whole and under
a lock, so several processes may write to one cassette, and two cassettes are merged by putting one
behind the other. Where a request stands twice the later line counts.
"""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import IO, Any

from swarmscout.core.errors import ModelError
from swarmscout.core.language_model import Model, Reply, Request

__all__ = ["MODES", "Cassette", "Tape"]

MODES = ("auto", "record", "replay", "refresh")
"""``replay`` never asks; ``record`` asks for what is missing; ``refresh`` asks for everything anew;
``auto`` is ``record`` with a model at hand and ``replay`` without one."""

_SHOWN = 60


@dataclass(frozen=True, slots=True)
class _Entry:
    """A line of a cassette: what was asked, in plain data, and what came back."""

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
        return sorted({str(entry.asked["model"]) for entry in self.entries.values()})

    def add(self, key: str, asked: Mapping[str, Any], reply: Reply, *, anew: bool) -> Reply:
        """Append an entry unless somebody else has it already.

        Args:
            key: the request's address.
            asked: what was asked.
            reply: what came back.
            anew: append in any case.

        Returns:
            The reply that counts.

        Raises:
            ModelError: the file cannot be written.
        """
        line = json.dumps(
            {"key": key, **asked, "reply": asdict(reply)}, ensure_ascii=False, sort_keys=True
        )
        with self._lock, self._opened("a+b") as file, _locked(file):
            self._catch_up(file)
            found = self.entries.get(key)
            if found is not None and not anew and not found.reply.failure:
                return found.reply
            file.seek(0, os.SEEK_END)
            data = line.encode() + b"\n"
            if file.tell() > self._read:
                data = b"\n" + data  # Somebody was killed in the middle of a line.
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

    def _catch_up(self, file: IO[bytes]) -> None:
        """Read what was appended since the last time; a last line without its end is left."""
        file.seek(self._read)
        data = file.read()
        whole = data.rfind(b"\n") + 1
        for line in data[:whole].splitlines():
            self._line += 1
            if line.strip():
                self._keep(line)
        self._read += whole

    def _keep(self, line: bytes) -> None:
        try:
            data = json.loads(line)
            reply = Reply(**data.pop("reply"))
            key = data.pop("key")
            self.entries[str(key)] = _Entry(data, reply)
            data["model"], data["params"], data["attempt"], data["messages"]
        except (ValueError, TypeError, KeyError, AttributeError):
            raise ModelError(
                f"cassette '{self.path}', line {self._line}: this is no entry of a cassette"
            ) from None


class Cassette:
    """A model with a cassette in front of it; see ``core.language_model.Model``.

    Args:
        tape: the cassette.
        mode: one of :data:`MODES`.
        model: who answers what is not on it; None in ``replay``.
        name: the model's name.
        params: whatever else an answer depends on.
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
        """Close the model."""
        close = getattr(self._model, "close", None)
        if close is not None:
            close()

    def complete(self, request: Request) -> Reply:
        """The reply on the cassette, or else the model's, which is then put on it.

        Raises:
            ModelError: a request is not on the cassette and nobody can be asked.
        """
        asked = self._asked(request)
        key = sha256(_canonical(asked).encode()).hexdigest()[:32]
        found = self._tape.entries.get(key)
        if self._model is None:
            if found is None:
                raise ModelError(self._missing(asked, key))
            return found.reply
        anew = self._mode == "refresh" and key not in self._fresh
        if found is not None and not anew and not found.reply.failure:
            return found.reply
        reply = self._tape.add(key, asked, self._model.complete(request), anew=anew)
        self._fresh.add(key)
        return reply

    def _asked(self, request: Request) -> dict[str, Any]:
        schema = "" if request.schema is None else _canonical(request.schema)
        return {
            "model": self._name,
            "params": {**self._params, "max_tokens": request.max_tokens},
            "attempt": request.attempt,
            "schema": sha256(schema.encode()).hexdigest()[:16] if schema else "",
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
    """How alike two requests are: equal parts, then lines in common."""
    parts = sum(one[part] == other[part] for part in ("model", "params", "attempt"))
    mine = {line for _, text in one["messages"] for line in str(text).splitlines()}
    theirs = {line for _, text in other["messages"] for line in str(text).splitlines()}
    return parts, len(mine & theirs)


def _difference(recorded: Mapping[str, Any], asked: Mapping[str, Any]) -> str:
    """The first thing in which two requests differ, in words."""
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
def _locked(file: IO[bytes]) -> Any:
    """No other process appends meanwhile; where there are no such locks, lines are short enough."""
    try:
        import fcntl
    except ImportError:
        yield
        return
    with suppress(OSError):
        fcntl.flock(file, fcntl.LOCK_EX)
    try:
        yield
    finally:
        with suppress(OSError):
            fcntl.flock(file, fcntl.LOCK_UN)
