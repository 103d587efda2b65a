"""A real HTTP server that speaks the chat completions API, and every way of breaking it."""

from __future__ import annotations

import json
import re
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

KEY = "sk-planted-0123456789abcdefghij"
"""A key that must not be found anywhere afterwards."""

Plan = Callable[[int, dict[str, Any]], str]


def completion(text: str | None, **more: Any) -> dict[str, Any]:
    """A body as servers send it."""
    message: dict[str, Any] = {"role": "assistant", "content": text}
    if "refusal" in more:
        message["refusal"] = more.pop("refusal")
    return {
        "id": "x",
        "object": "chat.completion",
        "created": 0,
        "model": more.pop("model", "test-model"),
        "choices": [
            {"index": 0, "message": message, "finish_reason": more.pop("finish_reason", "stop")}
        ],
        "usage": {"prompt_tokens": 100, "completion_tokens": 10, "total_tokens": 110},
        **more,
    }


def frontiers_of(body: dict[str, Any]) -> list[str]:
    """Ids that a request offers."""
    form = body.get("response_format")
    if form is not None and "json_schema" in form:
        choice = form["json_schema"]["schema"]["properties"]["choice"]
        return list(choice.get("enum", []))
    text = body["messages"][1]["content"]
    return [f"{x},{y}" for x, y in re.findall(r"\(\((\d+),(\d+)\),3,", text)]


class Provider:
    """What the server does and has seen.

    Attributes:
        plan: the number of a request (from 0) and its body → what to do, see ``answer``.
        seen: bodies of all requests; headers, paths: theirs.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.url = ""
        self.seen: list[dict[str, Any]] = []
        self.headers: list[dict[str, str]] = []
        self.paths: list[str] = []
        self.at_once = self.most_at_once = 0
        self.lock = threading.Lock()
        self.stopping = threading.Event()

    def good(self, body: dict[str, Any], pick: int = 0) -> dict[str, Any]:
        ids = frontiers_of(body)
        return completion(json.dumps({"candidates": [], "choice": ids[pick], "reason": "open"}))


def _handler(provider: Provider) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"
        disable_nagle_algorithm = True

        def log_message(self, *_: Any) -> None:
            """Nothing."""

        def do_POST(self) -> None:
            raw = self.rfile.read(int(self.headers["Content-Length"]))
            body = json.loads(raw)
            with provider.lock:
                number = len(provider.seen)
                provider.seen.append(body)
                provider.headers.append({k.lower(): v for k, v in self.headers.items()})
                provider.paths.append(self.path)
                provider.at_once += 1
                provider.most_at_once = max(provider.most_at_once, provider.at_once)
            try:
                self.act(provider.plan(number, body), body)
            finally:
                with provider.lock:
                    provider.at_once -= 1

        def act(self, what: str, body: dict[str, Any]) -> None:
            what, _, detail = what.partition(":")
            if what == "good":
                self.say(200, provider.good(body, int(detail or 0)))
            elif what == "text":
                self.say(200, completion(detail))
            elif what == "refusal":
                self.say(200, completion(None, refusal="I cannot help with that."))
            elif what == "filter":
                self.say(200, completion("", finish_reason="content_filter"))
            elif what == "cut":
                self.say(200, completion('{"choice": "1', finish_reason="length"))
            elif what == "raw":
                self.send(200, detail.encode())
            elif what == "status":
                code, _, more = detail.partition(" ")
                headers = {"Retry-After": more} if more else {}
                quoted = self.headers.get("Authorization", self.headers.get("api-key", ""))
                error = {"message": f"trouble with {quoted} today", "type": "t", "code": "c"}
                self.say(int(code), {"error": error}, headers)
            elif what == "says":
                code, _, words = detail.partition(" ")
                self.say(int(code), {"error": {"message": words, "type": "t", "code": "c"}})
            elif what == "answer":
                code, _, data = detail.partition(" ")
                self.send(int(code), data.encode())
            elif what == "hang":
                provider.stopping.wait(20.0)
            elif what == "slow":
                time.sleep(float(detail))
                self.say(200, provider.good(body))
            elif what == "drip":
                data = json.dumps(provider.good(body)).encode()
                self.head(200, len(data), {})
                for at in range(len(data)):
                    self.wfile.write(data[at : at + 1])
                    self.wfile.flush()
                    if provider.stopping.wait(0.1):
                        break
            elif what == "drop":
                data = json.dumps(provider.good(body)).encode()
                self.head(200, len(data), {})
                self.wfile.write(data[: len(data) // 2])
                self.close_connection = True
            elif what == "close":
                self.close_connection = True
            else:
                raise AssertionError(what)

        def say(self, code: int, data: Any, headers: dict[str, str] | None = None) -> None:
            self.send(code, json.dumps(data).encode(), headers)

        def send(self, code: int, data: bytes, headers: dict[str, str] | None = None) -> None:
            self.head(code, len(data), headers or {})
            self.wfile.write(data)

        def head(self, code: int, length: int, headers: dict[str, str]) -> None:
            self.send_response(code)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(length))
            for name, value in headers.items():
                self.send_header(name, value)
            self.end_headers()

    return Handler


class _Quiet(ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, *_: Any) -> None:
        """A client that has gone away is what some of the tests are about."""


@contextmanager
def serving(plan: Plan | str) -> Iterator[Provider]:
    """Serve on this machine.

    Args:
        plan: what to do for each request, or the same for all.
    """
    provider = Provider((lambda n, body: plan) if isinstance(plan, str) else plan)
    server = _Quiet(("127.0.0.1", 0), _handler(provider))
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
    thread.start()
    provider.url = f"http://127.0.0.1:{server.server_address[1]}/v1"
    try:
        yield provider
    finally:
        provider.stopping.set()
        server.shutdown()
        thread.join()
        server.server_close()
