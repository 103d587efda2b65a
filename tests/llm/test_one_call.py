"""One call over real HTTP: what goes out, what comes back, and the name of every fault."""

from __future__ import annotations

import threading
import time
from typing import Any

import pytest
from provider import KEY, completion, serving

from swarmscout.core.language_model import Message, Reply, Request
from swarmscout.llm.causes import retry_after
from swarmscout.llm.failures import TryFailed
from swarmscout.llm.openai_model import OpenAIModel
from swarmscout.llm.prices import Prices, load_prices
from swarmscout.llm.retry import RetryingModel
from swarmscout.llm.settings import Endpoint, Secret

pytest.importorskip("openai")

SCHEMA = {
    "type": "object",
    "properties": {"choice": {"type": "string", "enum": ["A", "B"], "maxLength": 9}},
}
ASK = Request((Message("system", "lead"), Message("user", "where?")), SCHEMA, max_tokens=50)


def model_of(url: str, provider: str = "server", **more: Any) -> OpenAIModel:
    return OpenAIModel(Endpoint(provider, "m", url, "2024-10-21", Secret(KEY)), **more)


def send(url: str, timeout_s: float = 5.0, **more: Any) -> Reply:
    model = model_of(url, **more)
    try:
        return model.send(ASK, timeout_s)
    finally:
        model.close()


def test_what_goes_out_and_what_comes_back() -> None:
    with serving("good") as server:
        reply = send(server.url)
    body = server.seen[0]
    assert body["model"] == "m"
    assert body["messages"] == [
        {"role": "system", "content": "lead"},
        {"role": "user", "content": "where?"},
    ]
    assert (body["max_tokens"], body["temperature"]) == (50, 0.0)
    assert body["response_format"]["json_schema"]["schema"] == SCHEMA
    assert server.headers[0]["authorization"] == f"Bearer {KEY}"
    assert '"choice": "A"' in reply.text
    assert (reply.model, reply.tokens_in, reply.tokens_out) == ("test-model", 100, 10)
    assert (reply.finish, reply.failure) == ("stop", "")


def test_azure_takes_its_key_its_version_and_its_deployment() -> None:
    with serving("good") as server:
        send(server.url.removesuffix("/v1"), provider="azure")
    assert server.headers[0]["api-key"] == KEY
    path = "/openai/deployments/m/chat/completions?api-version=2024-10-21"
    assert server.paths == [path]
    schema = server.seen[0]["response_format"]["json_schema"]["schema"]
    assert "maxLength" not in str(schema), "OpenAI's strict mode does not take it"
    assert server.seen[0]["max_completion_tokens"] == 50


FAULTS = [
    ("raw:", "malformed reply"),
    ("raw:{", "malformed reply"),
    ("raw:nonsense", "malformed reply"),
    ('raw:"a string"', "malformed reply"),
    ("raw:[]", "malformed reply"),
    ("raw:{}", "malformed reply"),
    ("raw:null", "malformed reply"),
    ('raw:{"choices": null}', "malformed reply"),
    ('raw:{"choices": []}', "malformed reply"),
    ('raw:{"choices": [{}]}', "malformed reply"),
    ('raw:{"choices": [{"message": {"content": [1]}}]}', "malformed reply"),
    ("status:400", "bad request"),
    ("status:401", "unauthorized"),
    ("status:403", "forbidden"),
    ("status:404", "not found"),
    ("status:422", "bad request"),
    ("status:429", "rate limit"),
    ("status:500", "server error"),
    ("status:503", "server error"),
    ("says:400 This model's maximum context length is 8192 tokens.", "too long"),
    ("says:413 Request too large for model on tokens per minute: Limit 6000", "too long"),
    ("raw:<html>Welcome</html>", "malformed reply"),
    ('raw:data: {"choices": []}', "malformed reply"),
    ('raw:{"error": {"code": 429, "message": "no more today"}}', "rate limit"),
    ('raw:{"error": "overloaded"}', "server error"),
    ('raw:{"choices": [{"error": {"code": 502, "message": "upstream"}}]}', "server error"),
    ("hang", "timeout"),
    ("drip", "timeout"),
    ("drop", "no connection"),
    ("close", "no connection"),
]


@pytest.mark.parametrize(("fault", "kind"), FAULTS)
def test_every_fault_has_a_name_and_names_no_key(fault: str, kind: str) -> None:
    limit_s = 0.4 if kind == "timeout" else 20.0
    with serving(fault) as server:
        began = time.monotonic()
        with pytest.raises(TryFailed) as caught:
            send(server.url, limit_s)
        assert time.monotonic() - began < 15.0
    assert caught.value.kind == kind
    assert KEY not in str(caught.value)
    assert "sk-" not in str(caught.value)
    assert "\n" not in str(caught.value)


def test_nobody_listens() -> None:
    with serving("good") as server:
        url = server.url
    with pytest.raises(TryFailed, match="no connection"):
        send(url)


def test_a_proxy_for_the_world_is_none_for_this_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("HTTP_PROXY", "http_proxy", "ALL_PROXY"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")
    monkeypatch.delenv("NO_PROXY", raising=False)
    monkeypatch.delenv("no_proxy", raising=False)
    with serving("good") as server:
        assert send(server.url).failure == ""


def test_who_still_waits_when_the_mission_ends_asks_nobody_any_more() -> None:
    with serving("hang") as server:
        model = model_of(server.url)
        ended: list[BaseException] = []

        def wait() -> None:
            try:
                model.send(ASK, 30.0)
            except BaseException as error:
                ended.append(error)

        waiting = threading.Thread(target=wait)
        waiting.start()
        while not server.seen:
            time.sleep(0.01)
        began = time.monotonic()
        model.close()
        waiting.join()
        assert time.monotonic() - began < 4.0
        assert len(ended) == 1
        with pytest.raises(TryFailed, match="the mission is over"):
            model.send(ASK, 1.0)
        assert len(server.seen) == 1


def test_refusals_filters_and_cut_answers_are_answers() -> None:
    for what, finish in (("refusal", "refusal"), ("filter", "filter"), ("cut", "length")):
        with serving(what) as server:
            assert send(server.url).finish == finish


def test_a_server_that_takes_no_schema_is_asked_without_one_and_once_for_all() -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        if "response_format" in body:
            return "says:400 'response_format.type' must be 'text'"
        if "temperature" in body:
            return "says:400 Unsupported value: 'temperature' does not support 0.0"
        return 'text:{"choice": "A"}'

    with serving(plan) as server:
        model = model_of(server.url)
        assert model.send(ASK, 5.0).text == '{"choice": "A"}'
        assert model.send(ASK, 5.0).text == '{"choice": "A"}'
        model.close()
    # The schema whole, without lengths, bare, any JSON, nothing; no temperature; the second call.
    assert len(server.seen) == 7
    with serving(plan) as server, pytest.raises(TryFailed, match="bad request"):
        send(server.url, structured="schema")
    with serving(plan) as server:
        send(server.url, structured="off")
        assert "response_format" not in server.seen[0]


def test_the_name_of_the_other_token_limit() -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        return "good" if "max_completion_tokens" in body else (
            "says:400 Use 'max_completion_tokens' instead of 'max_tokens'."
        )  # fmt: skip

    with serving(plan) as server:
        assert send(server.url).failure == ""


@pytest.mark.parametrize(
    ("headers", "seconds"),
    [
        ({}, None),
        ({"retry-after": "3"}, 3.0),
        ({"retry-after": "-3"}, 0.0),
        ({"retry-after-ms": "250", "retry-after": "3"}, 0.25),
        ({"retry-after": "Thu, 01 Jan 1970 00:01:40 GMT"}, 40.0),
        ({"retry-after": "soon"}, None),
    ],
)
def test_how_long_to_wait(headers: dict[str, str], seconds: float | None) -> None:
    assert retry_after(headers, 60.0) == seconds


class Clock:
    """Time that passes when somebody sleeps."""

    def __init__(self) -> None:
        self.now = 0.0
        self.slept: list[float] = []

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.now += seconds


class Script:
    """A sender that fails as told, then answers."""

    def __init__(self, *faults: TryFailed, takes_s: float = 1.0, clock: Clock) -> None:
        self.faults = list(faults)
        self.takes_s = takes_s
        self.clock = clock
        self.timeouts: list[float] = []

    def send(self, request: Request, timeout_s: float) -> Reply:
        self.timeouts.append(timeout_s)
        self.clock.now += min(self.takes_s, timeout_s)
        if self.faults:
            raise self.faults.pop(0)
        return Reply("fine", model="m", tokens_in=1000, tokens_out=100)


def patient(
    *faults: TryFailed, takes_s: float = 1.0, **more: Any
) -> tuple[RetryingModel, Script, Clock]:
    clock = Clock()
    script = Script(*faults, takes_s=takes_s, clock=clock)
    prices = Prices({"m": (2.0, 8.0)})
    made = RetryingModel(script, "m", prices, clock=clock, sleep=clock.sleep, **more)
    return made, script, clock


def test_trying_again_until_it_works() -> None:
    made, _, clock = patient(TryFailed("server error"), TryFailed("timeout"))
    reply = made.complete(ASK)
    assert (reply.text, reply.tries, reply.failure) == ("fine", 3, "")
    assert reply.cost_usd == pytest.approx(1000 * 2e-6 + 100 * 8e-6)
    assert reply.seconds == pytest.approx(clock.now, abs=1e-3)
    assert 0.5 <= clock.slept[0] < 1.0 <= clock.slept[1] < 2.0


def test_as_long_as_the_server_asks() -> None:
    made, _, clock = patient(TryFailed("rate limit", "", 7.0))
    assert made.complete(ASK).tries == 2
    assert clock.slept == [7.0]
    made, _, clock = patient(TryFailed("rate limit", "later", 100.0))
    reply = made.complete(ASK)
    assert (reply.failure, reply.note, reply.tries, clock.slept) == ("rate limit", "later", 1, [])


@pytest.mark.parametrize("kind", ["unauthorized", "not found", "bad request", "too long"])
def test_some_failures_are_final(kind: str) -> None:
    made, script, _ = patient(TryFailed(kind))
    assert made.complete(ASK).failure == kind
    assert len(script.timeouts) == 1


def test_within_the_time_of_a_decision() -> None:
    made, script, clock = patient(*[TryFailed("timeout")] * 9, takes_s=99.0, tries=9, call_s=25.0)
    reply = made.complete(ASK)
    assert reply.failure == "timeout"
    assert clock.now <= 60.0
    assert script.timeouts[0] == 25.0
    assert script.timeouts[-1] < 25.0
    made, script, _ = patient()
    assert made.complete(Request(ASK.messages, budget_s=0.0)).failure == "timeout"
    assert script.timeouts == []


def test_retries_are_counted_once() -> None:
    """The SDK's own retries are off: four tries are four requests."""
    with serving("status:500") as server:
        model = RetryingModel(model_of(server.url), "m", load_prices(), sleep=lambda s: None)
        reply = model.complete(ASK)
        model.close()
    assert (reply.tries, len(server.seen), reply.failure) == (4, 4, "server error")


def test_prices() -> None:
    prices = load_prices()
    assert prices.cost_usd(("gpt-4o-2024-08-06",), 1_000_000, 0) == 2.5
    assert prices.cost_usd(("gpt-4o-mini",), 0, 1_000_000) == 0.6
    assert prices.cost_usd(("gpt-4o-audio-preview",), 1, 1) is None
    assert prices.cost_usd(("gpt-4o",), None, 1) is None
    assert prices.cost_usd(("smollm2-135m-instruct",), 5, 5) == 0.0


def test_a_server_may_say_almost_nothing() -> None:
    bare = completion("A")
    for part in ("usage", "id", "created", "model", "object"):
        del bare[part]
    import json

    with serving(f"raw:{json.dumps(bare)}") as server:
        reply = send(server.url)
    assert (reply.text, reply.model, reply.tokens_in) == ("A", "m", None)
