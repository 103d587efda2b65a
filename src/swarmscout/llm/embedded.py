"""The embedded model: small, local, without a network; it runs as long as the mission.

It is meant for tests and first steps. It explores no better than chance: docs/llm.md.
"""

from __future__ import annotations

import os
import queue
import secrets
import subprocess
import sys
import tempfile
import threading
from importlib.util import find_spec
from pathlib import Path
from typing import IO

from swarmscout.core.cores import usable_cores
from swarmscout.core.errors import ModelError
from swarmscout.core.extras import install_command
from swarmscout.core.language_model import Reply, Request
from swarmscout.core.text import clean_line
from swarmscout.llm.failures import TryFailed
from swarmscout.llm.installed import model_file
from swarmscout.llm.openai_model import OpenAIModel
from swarmscout.llm.settings import Endpoint, Secret

__all__ = ["Embedded", "servers_at_once"]

CONTEXT_TOKENS = 8192


def servers_at_once() -> int:
    """Number of server processes: one per core, at most two."""
    return min(2, usable_cores())


class Embedded:
    """A local model behind its own HTTP servers; sends a request once.

    Args:
        file: a GGUF file; empty for the model that ``swarmscout models install`` installed.
        name: the model's name in records.
        threads: of each server. With more than one, answers may depend on the machine.
        temperature: of sampling.
        structured: see :class:`swarmscout.llm.openai_model.OpenAIModel`.
        servers: number of processes; each answers one question at a time.

    Raises:
        ModelError: the extra ``local-llm`` or the model is not installed.
    """

    def __init__(
        self,
        file: str,
        name: str,
        *,
        threads: int = 1,
        temperature: float = 0.0,
        structured: str = "auto",
        servers: int = 1,
    ) -> None:
        if find_spec("xllamacpp") is None or find_spec("openai") is None:
            raise ModelError(
                f"the embedded model needs an extra: {install_command('local-llm')}, then "
                "swarmscout models install smollm2"
            )
        path = model_file(file)
        self._free: queue.SimpleQueue[_Server] = queue.SimpleQueue()
        self._servers = [
            _Server(path, name, threads, temperature, structured) for _ in range(servers)
        ]
        for server in self._servers:
            self._free.put(server)

    def send(self, request: Request, timeout_s: float) -> Reply:
        """Send a request once, to the next free server.

        Raises:
            TryFailed: no usable answer came.
        """
        server = self._free.get()
        try:
            return server.send(request, timeout_s)
        finally:
            self._free.put(server)

    def close(self) -> None:
        """Stop the servers."""
        for server in self._servers:
            server.close()


class _Server:
    """One server process; it loads its model while the mission already runs."""

    def __init__(
        self, path: Path, name: str, threads: int, temperature: float, structured: str
    ) -> None:
        self._name = name
        self._form = (temperature, structured)
        self._model: OpenAIModel | None = None
        self._lock = threading.Lock()
        self._key = Secret(secrets.token_hex(16))
        self._said: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 (closed in close)
        self._process = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "swarmscout.llm.embedded_server",
                str(path),
                str(threads),
                str(CONTEXT_TOKENS),
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._said,
            # Ctrl-C is meant for the mission's process: the server ends when its input does.
            start_new_session=True,
            env={key: v for key, v in os.environ.items() if not key.endswith("_API_KEY")},
        )
        if self._process.stdin is not None:
            self._process.stdin.write(f"{self._key.reveal()}\n".encode())
            self._process.stdin.flush()

    def send(self, request: Request, timeout_s: float) -> Reply:
        with self._lock:
            if self._model is None:
                self._model = self._connected()
        return self._model.send(request, timeout_s)

    def close(self) -> None:
        if self._model is not None:
            self._model.close()
        if self._process.stdin is not None:
            self._process.stdin.close()
        try:
            self._process.wait(timeout=2.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        # Only now: another thread may wait for its first line.
        if self._process.stdout is not None:
            self._process.stdout.close()
        self._said.close()

    def _connected(self) -> OpenAIModel:
        address = self._address()
        if not address.startswith("http"):
            code = self._process.poll()
            self._said.seek(0)
            lines = self._said.read().decode(errors="replace").strip().splitlines()
            why = clean_line(lines[-1], 160) if lines else f"it ended with code {code}"
            raise TryFailed("no connection", f"the embedded model did not start: {why}")
        endpoint = Endpoint("server", self._name, f"{address}/v1", "", self._key)
        temperature, structured = self._form
        # The grammar of JSON lets a model go on with blanks after the closing brace: half of what
        # it writes. Answers by schema have no empty line before their end.
        stop = {} if structured == "off" else {"stop": ["\n\n"]}
        return OpenAIModel(
            endpoint,
            temperature=temperature,
            structured=structured,
            extra={"cache_prompt": False, "seed": 0, **stop},
        )

    def _address(self) -> str:
        """The first line of the server's output; empty if the process ended before.

        However slow the machine, this waits: giving up would change decisions with its speed.
        """
        pipe = self._process.stdout
        return pipe.readline().decode(errors="replace").strip() if pipe is not None else ""
