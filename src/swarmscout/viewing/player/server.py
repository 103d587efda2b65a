"""A small HTTP server for the player's page: missions that are recorded, and ones that run.

It binds loopback unless told otherwise. A request must name this server in ``Host`` and, where a
browser says where it comes from, in ``Origin``: no other page can read a mission through somebody's
browser. News of a running mission are Server-Sent Events. A connection remembers one number, the
step that its browser has; what a slow browser missed is sent when it reads again, so it holds back
nobody and nothing piles up for it.
"""

from __future__ import annotations

import base64
import ipaddress
import json
import threading
from collections.abc import Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import TYPE_CHECKING, Any, Protocol
from urllib.parse import parse_qs, urlsplit

from swarmscout.core.errors import ViewError
from swarmscout.core.version import package_version
from swarmscout.viewing.player.beliefs import packed_beliefs
from swarmscout.viewing.player.page import PAGE_FILES, file_bytes, served_policy

if TYPE_CHECKING:
    from swarmscout.recording.run import Run

__all__ = ["PlayerServer", "Recorded", "Source"]

USUAL_PORT = 8642
SECONDS_BETWEEN_NEWS = 0.1
SECONDS_TO_READ = 20.0
"""A browser that takes nothing for so long is let go; it asks again when it wakes up."""


class Source(Protocol):
    """A mission that can be shown."""

    live: bool

    def data(self) -> bytes:
        """Everything so far, gzipped packets."""

    def news(self, first: int, wait_s: float) -> tuple[bytes, int]:
        """The steps from `first` on as a packet, and what follows on them; b"" if none came."""

    def belief(self, robot: int, first: int) -> bytes | None:
        """One robot's map from step `first` on, a gzipped packet; None where there is none."""

    def ending(self) -> dict[str, Any] | None:
        """What there is to say at the end of the mission, or None while it runs."""


class Recorded:
    """A recorded run as a source.

    Args:
        packed: what :func:`swarmscout.viewing.player.recorded.player_data` made of it.
        run: the run itself, for the maps of single robots.
    """

    live = False

    def __init__(self, packed: bytes, run: Run | None = None) -> None:
        self._packed = packed
        self._run = run if run is not None and run.own_maps else None
        self._beliefs: dict[int, bytes] = {}

    def data(self) -> bytes:
        """Everything."""
        return self._packed

    def news(self, first: int, wait_s: float) -> tuple[bytes, int]:
        """There are none."""
        return b"", first

    def belief(self, robot: int, first: int) -> bytes | None:
        """One robot's map over the whole run."""
        if self._run is None or robot >= self._run.scenario.robots:
            return None
        if robot not in self._beliefs:
            self._beliefs |= packed_beliefs(self._run, [robot])
        return self._beliefs[robot]

    def ending(self) -> dict[str, Any] | None:
        """It has ended long ago."""
        return {}


class PlayerServer:
    """Serves the page.

    Args:
        sources: one mission, or two side by side.
        host: the address to bind.
        port: the port, 0 for any free one; None for the usual one, or a free one if it is taken.

    Attributes:
        url: where the page is.

    Raises:
        ViewError: the address cannot be bound.
    """

    def __init__(
        self, sources: Sequence[Source], host: str = "127.0.0.1", port: int | None = None
    ) -> None:
        self._server = _usual_or_free(host) if port is None else _listening(host, port)
        self._server.sources = list(sources)
        self._server.names = {host.lower(), "localhost"}
        bound = self._server.server_address[1]
        shown = f"[{host}]" if ":" in host else host
        self.url = f"http://{shown}:{bound}/"
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Answer requests from now on, in threads of its own."""
        self._thread = threading.Thread(
            target=self._server.serve_forever, name="player", daemon=True
        )
        self._thread.start()

    def stop(self) -> None:
        """Close the door."""
        if self._thread is not None:
            self._server.shutdown()
            self._thread.join()
        self._server.server_close()

    def __enter__(self) -> PlayerServer:
        """Start."""
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop."""
        self.stop()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False
    sources: list[Source]
    names: set[str]

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that went away is no error."""


class _Server6(_Server):
    import socket as _socket

    address_family = _socket.AF_INET6


def _usual_or_free(host: str) -> _Server:
    try:
        return _listening(host, USUAL_PORT)
    except ViewError:
        return _listening(host, 0)


def _listening(host: str, port: int) -> _Server:
    kind = _Server6 if ":" in host else _Server
    try:
        return kind((host, port), _Handler)
    except OverflowError:
        raise ViewError(
            f"port {port} is impossible: give one from 0 (any free one) to 65535"
        ) from None
    except OSError as error:
        raise ViewError(
            f"cannot listen on {host}, port {port}: {error.strerror or error}; "
            "give another with --port (0 takes any free one)"
        ) from None


class _Handler(BaseHTTPRequestHandler):
    server: _Server
    timeout = SECONDS_TO_READ
    protocol_version = "HTTP/1.1"
    server_version = f"swarmscout/{package_version()}"
    sys_version = ""

    def do_GET(self) -> None:
        """Answer a request."""
        if not self._is_ours():
            self._say(403, "this server answers its own page only")
            return
        path = self.path.partition("?")[0].removeprefix("/")
        name = path or "index.html"
        if name in PAGE_FILES:
            self._send(200, PAGE_FILES[name], file_bytes(name))
        elif path == "runs.json":
            runs = [
                {
                    "data": f"run/{k}/data",
                    "live": f"run/{k}/live" if source.live else None,
                    "belief": f"run/{k}/belief",
                }
                for k, source in enumerate(self.server.sources)
            ]
            self._send(200, "application/json", json.dumps(runs).encode())
        else:
            self._answer_for_run(path)

    do_HEAD = do_GET

    def _answer_for_run(self, path: str) -> None:
        known = {
            f"run/{k}/{what}": (source, what)
            for k, source in enumerate(self.server.sources)
            for what in ("data", "live", "belief")
        }
        if path not in known:
            self._say(404, "there is nothing here")
            return
        source, what = known[path]
        if what == "data":
            self._send(200, "application/octet-stream", source.data())
        elif what == "belief":
            packet = source.belief(self._number("robot"), self._number("from"))
            if packet is None:
                self._say(404, "this robot has no map of its own")
            else:
                self._send(200, "application/octet-stream", packet)
        elif self.command == "GET":
            self._stream(source)

    def _is_ours(self) -> bool:
        """Whether the request was made to this server by name, and from its own page."""
        host = self.headers.get("Host", "")
        try:
            name = (urlsplit(f"//{host}").hostname or "").lower()
        except ValueError:
            return False
        if name not in self.server.names and not _is_address(name):
            return False  # Some other site's name that was made to point here.
        origin = self.headers.get("Origin")
        if origin is not None and origin != f"http://{host}":
            return False
        return self.headers.get("Sec-Fetch-Site", "none") in ("none", "same-origin") or (
            self.headers.get("Sec-Fetch-Mode") == "navigate"
        )

    def _stream(self, source: Source) -> None:
        """Send news until the mission ends or the browser goes away."""
        first = self._number("from")
        self._head(200, "text/event-stream")
        self.close_connection = True
        pause = threading.Event()
        while True:
            packet, first = source.news(first, wait_s=5.0)
            if packet:
                self._event("steps", base64.b64encode(packet))
                pause.wait(SECONDS_BETWEEN_NEWS)
            elif (ending := source.ending()) is not None:
                self._event("end", json.dumps(ending).encode())
                return
            else:
                self.wfile.write(b": still here\n\n")

    def _number(self, name: str) -> int:
        """A whole number of the query, 0 if it has none."""
        asked = parse_qs(self.path.partition("?")[2]).get(name, ["0"])[0]
        return int(asked) if asked.isascii() and asked.isdecimal() and len(asked) < 10 else 0

    def _event(self, name: str, data: bytes) -> None:
        self.wfile.write(b"event: " + name.encode() + b"\ndata: " + data + b"\n\n")

    def _say(self, status: int, text: str) -> None:
        self._send(status, "text/plain; charset=utf-8", text.encode())

    def _send(self, status: int, kind: str, body: bytes) -> None:
        self._head(status, kind, len(body))
        if self.command != "HEAD":
            self.wfile.write(body)

    def _head(self, status: int, kind: str, length: int | None = None) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        if length is None:
            self.send_header("Connection", "close")
        else:
            self.send_header("Content-Length", str(length))
        for name, value in (
            ("Content-Security-Policy", served_policy()),
            ("X-Content-Type-Options", "nosniff"),
            ("Referrer-Policy", "no-referrer"),
            ("Cross-Origin-Resource-Policy", "same-origin"),
            ("Cross-Origin-Opener-Policy", "same-origin"),
            ("Cache-Control", "no-store"),
        ):
            self.send_header(name, value)
        self.end_headers()

    def log_message(self, format: str, *args: Any) -> None:
        """Requests are nothing that a person wants to read."""


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
