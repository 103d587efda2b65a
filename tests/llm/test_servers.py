"""Servers as they are found: what they refuse, what they send instead of an answer, and why."""

from __future__ import annotations

import json
import shutil
import signal
import ssl
import subprocess
import threading
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any

import pytest
from provider import KEY, completion, serving

from swarmscout.core.errors import ModelError
from swarmscout.core.language_model import Message, Reply, Request
from swarmscout.llm.dispatcher import Dispatcher
from swarmscout.llm.failures import TryFailed
from swarmscout.llm.openai_model import OpenAIModel
from swarmscout.llm.prices import Prices
from swarmscout.llm.retry import RetryingModel
from swarmscout.llm.settings import Endpoint, LlmSettings, Secret

pytest.importorskip("openai")

SCHEMA = {
    "type": "object",
    "properties": {"choice": {"type": "string", "enum": ["A", "B"], "maxLength": 9}},
    "additionalProperties": False,
}
GOOD = 'text:{"choice": "A"}'


def ask(text: str = "where?", **more: Any) -> Request:
    return Request((Message("system", "lead"), Message("user", text)), SCHEMA, **more)


def model_of(url: str, **more: Any) -> OpenAIModel:
    return OpenAIModel(Endpoint("server", "m", url, "", Secret(KEY)), **more)


def replies(
    plan: Callable[[int, dict[str, Any]], str] | str, *requests: Request, **more: Any
) -> tuple[list[Reply | TryFailed], list[dict[str, Any]]]:
    """What comes of requests, one after the other, and what was sent for them."""
    with serving(plan) as server:
        model = model_of(server.url, **more)
        found: list[Reply | TryFailed] = []
        for request in requests:
            try:
                found.append(model.send(request, 20.0))
            except TryFailed as failed:
                found.append(failed)
        model.close()
        return found, server.seen


def error(status: int, body: Any) -> str:
    return f"answer:{status} {json.dumps(body)}"


NO_SCHEMA = [
    error(400, {"error": {"message": "'response_format.type' must be 'text'"}}),
    error(400, {"error": "json_schema is not supported by this model"}),
    error(400, {"detail": "Extra inputs are not permitted"}),
    error(422, {"message": {"detail": [{"loc": ["body", "response_format"], "msg": "extra"}]}}),
    error(422, {"detail": [{"type": "extra_forbidden", "loc": ["body", "response_format"]}]}),
    error(404, {"error": {"message": "No endpoints found that can handle: response_format"}}),
    error(500, {"error": {"message": "failed to parse grammar"}}),
    error(501, {"error": {"message": "structured outputs are not implemented"}}),
]


@pytest.mark.parametrize("refusal", NO_SCHEMA)
def test_a_server_that_knows_no_schema(refusal: str) -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        return refusal if "response_format" in body else GOOD

    (first, second), seen = replies(plan, ask(), ask("again"))
    assert isinstance(first, Reply)
    assert isinstance(second, Reply)
    assert len([body for body in seen if body["messages"][-1]["content"] == "again"]) == 1


def test_json_mode_where_schemas_are_not_known() -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        kind = body.get("response_format", {}).get("type")
        refusal = error(400, {"error": {"message": "unknown response_format json_schema"}})
        return GOOD if kind == "json_object" else refusal

    (first, _), seen = replies(plan, ask(), ask())
    assert isinstance(first, Reply)
    assert [body["response_format"]["type"] for body in seen][-2:] == ["json_object"] * 2


@pytest.mark.parametrize("keyword", ["maxLength", "additionalProperties"])
def test_a_smaller_schema_before_none(keyword: str) -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        refusal = error(400, {"error": {"message": f"Invalid schema: {keyword} not permitted"}})
        return refusal if keyword in str(body) else GOOD

    for structured in ("auto", "schema"):
        (first, _), seen = replies(plan, ask(), ask(), structured=structured)
        assert isinstance(first, Reply)
        assert seen[-1]["response_format"]["json_schema"]["schema"]["properties"]["choice"]["enum"]


@pytest.mark.parametrize(
    "refusal",
    [
        error(400, {"error": {"message": "System role not supported"}}),
        error(500, {"error": "Conversation roles must alternate user/assistant/user"}),
        error(400, [{"error": {"message": "Developer instruction is not enabled for gemma"}}]),
        error(422, {"detail": "Only user and assistant roles are supported!"}),
    ],
)
def test_system_messages_become_the_beginning_of_the_users(refusal: str) -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        return refusal if body["messages"][0]["role"] == "system" else GOOD

    (first, _), seen = replies(plan, ask(), ask())
    assert isinstance(first, Reply)
    assert seen[-1]["messages"] == [{"role": "user", "content": "lead\n\nwhere?"}]
    assert "response_format" in seen[-1]
    assert len(seen) == 3


def test_a_refused_schema_is_not_called_a_long_prompt() -> None:
    words = "Invalid schema for response_format: In context=('properties', 'reason')"
    (found,), _ = replies(error(400, {"error": {"message": words}}), ask(), structured="schema")
    assert isinstance(found, TryFailed)
    assert found.kind == "bad request"
    assert "In context=" in found.note


def test_one_long_prompt_changes_nothing_for_later_ones() -> None:
    words = (
        "'max_tokens' or 'max_completion_tokens' is too large: 1200. This model's maximum context "
        "length is 4096 tokens and your request has 3996 input tokens"
    )

    def plan(number: int, body: dict[str, Any]) -> str:
        return error(400, {"error": {"message": words}}) if "long" in str(body) else GOOD

    requests = [ask("long" if k in (0, 3, 4) else "short", max_tokens=1200) for k in range(6)]
    found, seen = replies(plan, *requests)
    kinds = [one.kind if isinstance(one, TryFailed) else "" for one in found]
    assert kinds == ["too long", "", "", "too long", "too long", ""]
    assert "selector.prompt_tokens" in str(found[0])
    assert len(seen) == 6
    assert all(body["max_tokens"] == 1200 and "response_format" in body for body in seen)


def test_one_refused_prompt_changes_nothing_once_a_form_has_worked() -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        bad = number == 1 and "response_format" in body
        return error(400, {"error": {"message": "too many values in the schema"}}) if bad else GOOD

    found, seen = replies(plan, *[ask(str(k)) for k in range(4)])
    assert all(isinstance(one, Reply) for one in found)
    assert [body["response_format"]["type"] for body in seen] == ["json_schema"] * 5


def test_a_model_that_thinks_gets_room_for_it_once() -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        if body["max_tokens"] >= 300:
            return GOOD
        data = completion("", finish_reason="length")
        data["choices"][0]["message"]["reasoning_content"] = "hm " * 100
        return f"raw:{json.dumps(data)}"

    (first, second), seen = replies(plan, ask(max_tokens=120), ask(max_tokens=120))
    assert [body["max_tokens"] for body in seen] == [120, 8120, 8120]
    assert isinstance(first, Reply)
    assert isinstance(second, Reply)
    assert "from 120 to 8120 tokens" in first.note
    assert (first.tokens_out, second.tokens_out, second.note) == (20, 10, "")


def test_a_model_that_thinks_without_end_says_what_to_do() -> None:
    data = completion("<think>hm", finish_reason="length")
    (first,), _ = replies(f"raw:{json.dumps(data)}", ask(max_tokens=50), effort="high")
    assert isinstance(first, Reply)
    assert first.finish == "length"
    assert "llm.answer_tokens" in first.note
    assert "llm.effort" in first.note


def test_a_small_context_takes_less_room_for_thinking() -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        if body["max_tokens"] > 4000:
            return error(400, {"error": {"message": "max_tokens: at most 4096 output tokens"}})
        return GOOD if body["max_tokens"] > 300 else (
            f"raw:{json.dumps(completion('', finish_reason='length'))}"
        )  # fmt: skip

    (first,), seen = replies(plan, ask(max_tokens=120))
    assert isinstance(first, Reply)
    assert first.text
    assert [body["max_tokens"] for body in seen] == [120, 8120, 2620]


def test_effort_is_sent_and_left_out_where_it_is_refused() -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        refusal = error(400, {"error": {"message": "Unsupported parameter: 'reasoning_effort'"}})
        return refusal if "reasoning_effort" in body else GOOD

    (first,), seen = replies(plan, ask(), effort="low")
    assert isinstance(first, Reply)
    assert [body.get("reasoning_effort") for body in seen] == ["low", None]


def test_parts_instead_of_a_text() -> None:
    parts: Any = [
        {"type": "thinking", "thinking": [{"type": "text", "text": "hm"}]},
        {"type": "text", "text": '{"choice": '},
        {"type": "text", "text": '"A"}'},
    ]
    data = completion("x")
    data["choices"][0]["message"]["content"] = parts
    (first,), _ = replies(f"raw:{json.dumps(data)}", ask())
    assert isinstance(first, Reply)
    assert first.text == '{"choice": "A"}'


def test_an_answer_in_a_tool_call() -> None:
    data = completion(None)
    call = {"function": {"name": "destination", "arguments": '{"choice": "A"}'}}
    data["choices"][0]["message"]["tool_calls"] = [call]
    (first,), _ = replies(f"raw:{json.dumps(data)}", ask())
    assert isinstance(first, Reply)
    assert first.text == '{"choice": "A"}'


@pytest.mark.parametrize("count", [4294967295, -1, 2**31, "10" * 400, 1e300, None, "many", True])
def test_counts_that_are_none(count: Any) -> None:
    data = completion("A", usage={"prompt_tokens": count, "completion_tokens": 3})
    (first,), _ = replies(f"raw:{json.dumps(data)}", ask())
    assert isinstance(first, Reply)
    assert (first.tokens_in, first.tokens_out) == (None, 3)


def test_a_prompt_that_is_cut_off_without_an_error_is_noticed_by_its_count() -> None:
    long = " ".join(f"(({x},{y}),1,(3,0),5.5)" for x in range(30) for y in range(20))
    usage = {"prompt_tokens": 4096, "completion_tokens": 3}
    plan = f"raw:{json.dumps(completion('A', usage=usage))}"
    (cut, whole), _ = replies(plan, ask(long), ask("short"))
    assert isinstance(cut, Reply)
    assert isinstance(whole, Reply)
    assert "the server read 4,096 of about" in cut.note
    assert whole.note == ""


@pytest.mark.parametrize(
    "body",
    [
        {"error": "No models loaded. Please load a model"},
        {"detail": "No models loaded. Please load a model"},
        {"message": "No models loaded. Please load a model"},
        {"error": {"error": {"detail": "No models loaded. Please load a model"}}},
        [{"error": {"code": 400, "message": "No models loaded. Please load a model"}}],
        "No models loaded. Please load a model",
    ],
)
def test_a_servers_words_are_passed_on_without_keys(body: Any) -> None:
    (found,), _ = replies(error(400, body), ask())
    assert isinstance(found, TryFailed)
    assert "No models loaded. Please load a model" in found.note
    body = json.loads(json.dumps(body).replace("load a", f"load {KEY} a"))
    (quoted,), _ = replies(error(400, body), ask())
    assert "load *** a model" in str(quoted)


def failure(url: str, **more: Any) -> TryFailed:
    model = model_of(url, **more)
    with pytest.raises(TryFailed) as caught:
        model.send(ask(), 20.0)
    model.close()
    assert "\n" not in str(caught.value)
    return caught.value


def test_a_refused_connection() -> None:
    with serving(GOOD) as server:
        url = server.url
    port = url.split(":")[2].split("/")[0]
    found = failure(url)
    assert str(found) == (
        f"no connection: 127.0.0.1:{port} refuses the connection: is the server running there?"
    )


def test_a_host_without_an_address() -> None:
    assert "host 'model.invalid' is not known (DNS)" in failure("http://model.invalid/v1").note


def test_an_address_without_its_path() -> None:
    with serving("status:404") as server:
        note = failure(server.url.removesuffix("/v1")).note
    assert f"most servers want {server.url}" in note
    with serving("status:404") as server:
        assert "no model 'm' or no such address" in failure(server.url).note


def test_tls_where_there_is_none() -> None:
    with serving(GOOD) as server:
        note = failure(server.url.replace("http:", "https:")).note
    assert "is it http:// instead of https://?" in note


@pytest.mark.skipif(shutil.which("openssl") is None, reason="needs openssl to make a certificate")
def test_a_certificate_that_is_not_trusted(tmp_path: Path) -> None:
    words = (
        "req",
        "-x509",
        "-newkey",
        "rsa:2048",
        "-nodes",
        "-days",
        "2",
        "-subj",
        "/CN=localhost",
    )
    files = ("-keyout", str(tmp_path / "key.pem"), "-out", str(tmp_path / "cert.pem"))
    subprocess.run(["openssl", *words, *files], check=True, capture_output=True)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(tmp_path / "cert.pem", tmp_path / "key.pem")

    class Quiet(HTTPServer):
        def handle_error(self, *_: Any) -> None:
            """The client refuses the certificate."""

    server = Quiet(("127.0.0.1", 0), BaseHTTPRequestHandler)
    server.socket = context.wrap_socket(server.socket, server_side=True)
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
    thread.start()
    try:
        found = failure(f"https://127.0.0.1:{server.server_address[1]}/v1")
    finally:
        server.shutdown()
        thread.join()
        server.server_close()
    assert "is not trusted" in found.note
    assert "SSL_CERT_FILE" in found.note


@pytest.fixture
def no_proxies(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY", "NO_PROXY"):
        monkeypatch.delenv(name, raising=False)
        monkeypatch.delenv(name.lower(), raising=False)


@pytest.mark.usefixtures("no_proxies")
def test_a_proxy_that_does_not_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HTTP_PROXY", "http://127.0.0.1:9")
    found = failure("http://model.invalid/v1")
    assert "the proxy refuses the connection (set by HTTP_PROXY)" in found.note


@pytest.mark.usefixtures("no_proxies")
def test_settings_that_allow_no_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ALL_PROXY", "socks5://127.0.0.1:9")
    with pytest.raises(ModelError, match="ALL_PROXY"):
        model_of("http://model.invalid/v1")
    with serving(GOOD) as server:
        near = model_of(server.url)
        assert near.send(ask(), 5.0).text, "no proxy is used for this machine"
        near.close()
    monkeypatch.delenv("ALL_PROXY")
    monkeypatch.setenv("SSL_CERT_FILE", "/nonexistent.pem")
    with pytest.raises(ModelError, match="SSL_CERT_FILE"):
        model_of("https://model.invalid/v1")


def test_waiting_for_a_server_ends_with_the_mission() -> None:
    with serving("status:429 45") as server:
        model = RetryingModel(model_of(server.url), "m", Prices({}))
        ended = threading.Event()

        def wait() -> None:
            assert model.complete(ask()).failure == "rate limit"
            ended.set()

        thread = threading.Thread(target=wait)
        thread.start()
        while not server.seen:
            time.sleep(0.01)
        time.sleep(0.1)
        model.close()
        assert ended.wait(1.0)
        thread.join()


def test_a_signal_ends_waiting_for_an_answer_at_once() -> None:
    """The thread that runs the mission is interrupted; nothing that waits outlives it."""

    class Enough(Exception):
        """Raised by the signal."""

    def stop(number: int, frame: object) -> None:
        raise Enough

    before = signal.signal(signal.SIGALRM, stop)
    try:
        with serving("status:429 45") as server:
            model = RetryingModel(model_of(server.url), "m", Prices({}))
            dispatcher = Dispatcher(model, LlmSettings(), "m")
            signal.setitimer(signal.ITIMER_REAL, 1.0)
            with pytest.raises(Enough):
                dispatcher(1, [(robot, ask(str(robot))) for robot in range(4)])
            began = time.monotonic()
            dispatcher.close()
            threads = [t for t in threading.enumerate() if t.name.startswith(("asking", "llm"))]
            for thread in threads:
                thread.join(5.0)
            assert time.monotonic() - began < 1.0
            assert not any(thread.is_alive() for thread in threads)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_a_cost_is_known_where_tokens_are_not_counted() -> None:
    data = completion("A", model="gpt-4o")
    del data["usage"]
    with serving(f"raw:{json.dumps(data)}") as server:
        model = RetryingModel(model_of(server.url), "m", Prices({"gpt-4o": (2.5, 10.0)}))
        reply = model.complete(ask("word " * 100))
        model.close()
    assert reply.tokens_in is None
    assert reply.cost_usd == pytest.approx(102 * 2.5e-6, rel=0.3)
