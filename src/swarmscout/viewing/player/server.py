"""A small HTTP server for the player's page: recorded missions and running ones.

It binds loopback by default. A request must name this server in ``Host`` and, where the browser
sends one, in ``Origin``: other pages cannot read a mission through a visitor's browser. Steps of a
running mission are Server-Sent Events. A connection remembers one number, the last step that its
browser has: slow clients catch up and never stall the mission. A client that sends its request, or
takes the answer, slower than a few kilobytes in 20 seconds is disconnected.
"""

from __future__ import annotations

import base64
import contextlib
import ipaddress
import json
import socket
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
"""Time limit of a whole request, and of each :data:`PIECE` of an answer."""
PIECE = 1 << 16
"""Bytes of an answer that are sent at once."""


class Source(Protocol):
    """A mission that can be shown."""

    live: bool

    def data(self) -> bytes:
        """All steps so far, gzipped packets."""

    def news(self, first: int, wait_s: float) -> tuple[bytes, int]:
        """The steps from `first` on as a packet, and the step after them; b"" if none."""

    def belief(self, robot: int, first: int) -> bytes | None:
        """One robot's map from step `first` on, a gzipped packet; None where it has none."""

    def ending(self) -> dict[str, Any] | None:
        """The facts of the mission's end, or None while it runs."""


class Recorded:
    """A recorded run as a source.

    Args:
        packed: from :func:`swarmscout.viewing.player.recorded.player_data`.
        run: the run, for the maps of single robots.
    """

    live = False

    def __init__(self, packed: bytes, run: Run | None = None) -> None:
        self._packed = packed
        self._run = run if run is not None and run.own_maps else None
        self._beliefs: dict[int, bytes] = {}

    def data(self) -> bytes:
        """All steps."""
        return self._packed

    def news(self, first: int, wait_s: float) -> tuple[bytes, int]:
        """A recorded run gets no new steps."""
        return b"", first

    def belief(self, robot: int, first: int) -> bytes | None:
        """One robot's map over the whole run."""
        if self._run is None or robot >= self._run.scenario.robots:
            return None
        if robot not in self._beliefs:
            self._beliefs |= packed_beliefs(self._run, [robot])
        return self._beliefs[robot]

    def ending(self) -> dict[str, Any] | None:
        """A recorded run has ended."""
        return {}


class PlayerServer:
    """Serves the page.

    Args:
        sources: one mission, or two side by side.
        host: the address to bind.
        port: the port, 0 for any free one; None for 8642, or a free one if that is taken.

    Attributes:
        url: the page's address, for a browser on this machine.
        opened: None on loopback; else one line that says what the address opens to the network.

    Raises:
        ViewError: the address cannot be bound.
    """

    def __init__(
        self, sources: Sequence[Source], host: str = "127.0.0.1", port: int | None = None
    ) -> None:
        self._server = _usual_or_free(host) if port is None else _listening(host, port)
        self._server.sources = list(sources)
        own = socket.gethostname().lower()
        self._server.names = {host.lower(), "localhost", own, f"{own}.local"}
        everywhere = host in ("0.0.0.0", "::", "")
        self.url = self._at("127.0.0.1" if everywhere else host)
        self.opened = None
        if everywhere or not _is_loopback(host):
            address = self._at(own if everywhere else host)
            self.opened = (
                f"open to the network: everyone who can reach {address} can read this mission, "
                "prompts included; there is no password and no encryption"
            )
        self._thread: threading.Thread | None = None

    def _at(self, host: str) -> str:
        shown = f"[{host}]" if ":" in host else host
        return f"http://{shown}:{self._server.server_address[1]}/"

    def start(self) -> None:
        """Start answering requests, in threads of the server's own."""
        self._thread = threading.Thread(
            target=self._server.serve_forever, name="player", daemon=True
        )
        self._thread.start()

    def stop(self) -> None:
        """Stop serving."""
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
        """Ignore browsers that disconnect."""


class _Server6(_Server):
    address_family = socket.AF_INET6


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
        raise ViewError(f"port {port} is impossible: choose 0 (any free one) to 65535") from None
    except OSError as error:
        raise ViewError(
            f"cannot listen on {host}, port {port}: {error.strerror or error}; "
            "choose another with --port (0 takes any free one)"
        ) from None


class _Handler(BaseHTTPRequestHandler):
    server: _Server
    timeout = SECONDS_TO_READ
    protocol_version = "HTTP/1.1"
    server_version = f"swarmscout/{package_version()}"
    sys_version = ""

    def handle_one_request(self) -> None:
        """Read and answer one request; the whole of it has to come within the time limit.

        A socket's timeout alone starts anew with each byte that drips in.
        """
        self._late = threading.Timer(self.timeout, self._hang_up)
        self._late.daemon = True
        self._late.start()
        try:
            super().handle_one_request()
        finally:
            self._late.cancel()

    def _hang_up(self) -> None:
        with contextlib.suppress(OSError):
            self.connection.shutdown(socket.SHUT_RDWR)

    def parse_request(self) -> bool:
        """Read the headers; from here on the limits on writing hold."""
        whole = super().parse_request()
        self._late.cancel()
        return whole

    def do_GET(self) -> None:
        """Answer a request."""
        if not self._is_ours():
            self._say(403, "this server answers only its own page")
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
            self._say(404, "not found")
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
        """Whether the request names this server and comes from its own page."""
        host = self.headers.get("Host", "")
        try:
            name = (urlsplit(f"//{host}").hostname or "").lower()
        except ValueError:
            return False
        if name not in self.server.names and not _is_address(name):
            return False  # Another site's name that resolves to this machine.
        origin = self.headers.get("Origin")
        if origin is not None and origin != f"http://{host}":
            return False
        return self.headers.get("Sec-Fetch-Site", "none") in ("none", "same-origin") or (
            self.headers.get("Sec-Fetch-Mode") == "navigate"
        )

    def _stream(self, source: Source) -> None:
        """Send new steps until the mission ends or the browser disconnects."""
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
        self._write(b"event: " + name.encode() + b"\ndata: " + data + b"\n\n")

    def _say(self, status: int, text: str) -> None:
        self._send(status, "text/plain; charset=utf-8", text.encode())

    def _send(self, status: int, kind: str, body: bytes) -> None:
        self._head(status, kind, len(body))
        if self.command != "HEAD":
            self._write(body)

    def _write(self, data: bytes) -> None:
        for at in range(0, len(data), PIECE):
            self.wfile.write(data[at : at + PIECE])

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
        """Do not print requests."""


def _is_loopback(host: str) -> bool:
    return host == "localhost" or (_is_address(host) and ipaddress.ip_address(host).is_loopback)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
