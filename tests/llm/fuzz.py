"""Hostile replies and cassettes, at random: python tests/llm/fuzz.py [COUNT] [SEED].

Whatever a server or a cassette says, what comes of it is a reply that can be kept and shown, an
answer or a named reason why there is none, and never an error of another kind, nor a long wait.
"""

from __future__ import annotations

import json
import random
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from swarmscout.core.errors import ModelError
from swarmscout.core.language_model import FAILURES, FINISHES, Message, Reply, Request
from swarmscout.destinations.llm.parse import InvalidAnswer, read_answer
from swarmscout.llm.cassette import Cassette, Tape
from swarmscout.llm.causes import all_words, refused
from swarmscout.llm.completion import read_completion
from swarmscout.llm.failures import TryFailed
from swarmscout.llm.request_form import RequestForm
from swarmscout.llm.settings import Endpoint, Secret

KEY = "sk-planted-0123456789abcdefghij"
SERVER = Endpoint("server", "m", "http://127.0.0.1:1/v1", "", Secret(KEY))
LONGEST_S = 1.0

TEXTS = [
    "", " ", "A", "7,8", "\ud83d", "\udc00\ud83d", "\x1b[2J\x07", "\u202egnp.", "\x00", "\r\n",
    "8" * 400, "9" * 5000, "-0,0", "1e999", "NaN", KEY, f"Bearer {KEY}", "<think>", "</think>",
    "[THINK]", "<|channel|>final<|message|>", "```json", '{"choice": "7,8"}', "{'choice': '7,8'}",
    '{"choice": "7,8", "reason": "\\ud83d"}', '{"choice": ', '"}', "{" * 50, "[" * 50, "{{", "}}",
    "\\boxed{7,8}", "Choice: ", "<html>", "data: [DONE]", "“”", "（7，8）", "\\", "\\'", "'", '"',
    "x" * 3000, "context length", "response_format", "max_tokens", "system role", "reasoning",
]  # fmt: skip
VALUES: list[Any] = [
    None, True, False, 0, -1, 2**31, 2**32 - 1, 10**18, 10**400, 1.5, 1e308, float("nan"),
    float("inf"), [], {}, [[]], [{}], {"a": 1}, "stop", "length", "content_filter", 429, 500, "429",
    [{"type": "text", "text": "7,8"}, {"type": "thinking", "thinking": []}, 5, None],
]  # fmt: skip


def whole() -> dict[str, Any]:
    message = {"role": "assistant", "content": '{"choice": "7,8", "reason": "near"}'}
    return {
        "id": "x",
        "model": "m",
        "choices": [{"index": 0, "finish_reason": "stop", "message": message}],
        "usage": {"prompt_tokens": 100, "completion_tokens": 10},
        "error": None,
    }


def hostile(draw: random.Random) -> Any:
    if draw.random() < 0.6:
        return "".join(draw.choice(TEXTS) for _ in range(draw.randint(1, 6)))
    return draw.choice(VALUES)


def mutated(data: Any, draw: random.Random) -> Any:
    """Some parts of a value replaced, taken out, or put in."""
    if draw.random() < 0.08:
        return hostile(draw)
    if isinstance(data, dict):
        mixed = {key: mutated(value, draw) for key, value in data.items() if draw.random() > 0.04}
        if draw.random() < 0.05:
            names = ["error", "detail", "message", "text", "reasoning_content", "tool_calls"]
            mixed[draw.choice([*names, "refusal", "\ud83d"])] = hostile(draw)
        return mixed
    if isinstance(data, list):
        return [mutated(value, draw) for value in data for _ in range(draw.choice((1, 1, 1, 2)))]
    return data


def written(data: Any, draw: random.Random) -> bytes:
    """JSON of a value, sometimes damaged."""
    sys.set_int_max_str_digits(0)
    text = json.dumps(data, ensure_ascii=draw.random() < 0.7)
    sys.set_int_max_str_digits(4300)
    raw = bytearray(text.encode("utf-8", "surrogatepass"))
    for _ in range(draw.choice((0, 0, 0, 1, 3))):
        at = draw.randrange(len(raw) + 1)
        how = draw.randrange(3)
        if how == 0:
            raw[at : at + 1] = bytes([draw.randrange(256)])
        elif how == 1:
            raw[at:] = b""
        else:
            raw[at:at] = draw.choice(TEXTS).encode("utf-8", "surrogatepass")
    return bytes(raw)


def check(reply: Reply, key: str) -> None:
    """A reply that can be kept and shown, without a key."""
    for text in (reply.text, reply.note, reply.model):
        assert not key or key not in text
        text.encode()
        assert not any(ord(sign) < 32 and sign not in "\n\t" for sign in text), repr(text)
        assert not any(0x7F <= ord(sign) < 0xA0 for sign in text), repr(text)
    assert "\n" not in reply.note + reply.model
    assert reply.finish in FINISHES
    assert reply.failure in ("", *FAILURES)
    for count in (reply.tokens_in, reply.tokens_out):
        assert count is None or 0 <= count < 2**31


def answer(text: str, finish: str) -> None:
    try:
        found = read_answer(text, finish)
    except InvalidAnswer:
        return
    (found.id + found.reason).encode()
    assert found.point is None or all(abs(part) < 10**10 for part in found.point)


def provider(draw: random.Random) -> None:
    """One reply of a server, and one error."""
    try:
        completion = read_completion(written(mutated(whole(), draw), draw), SERVER)
        check(completion.reply, KEY)
        answer(completion.reply.text, completion.reply.finish)
    except TryFailed as failed:
        check(Reply(failure=failed.kind, note=failed.note), KEY)
    answer("".join(str(hostile(draw)) for _ in range(3)) if draw.random() < 0.5 else
           str(mutated(whole(), draw)), "stop")  # fmt: skip
    body = mutated({"error": {"message": "refused", "code": 1}}, draw)
    status = draw.choice((302, 400, 401, 403, 404, 413, 422, 429, 500, 503))
    headers = {"retry-after": str(hostile(draw))[:50]}
    failed = refused(status, body, headers, SERVER, 0.0)
    check(Reply(failure=failed.kind, note=failed.note), KEY)
    form: RequestForm | None = RequestForm(thinking=8000, effort="low")
    for _ in range(20):
        form = form and form.after(status, all_words(body), guess=draw.random() < 0.5)
    assert form is None or form.schema < 5


class Model:
    """Answers anything."""

    def complete(self, request: Request) -> Reply:
        return Reply('{"choice": "7,8"}')


def cassette(draw: random.Random, file: Path) -> None:
    """One damaged cassette: it is refused by name, or its replies are clean, and it is written."""
    entry = {
        "attempt": 1, "key": "k", "messages": [["user", "x"]], "model": "m", "params": {},
        "reply": {"text": "7,8", "finish": "stop", "tokens_in": 1, "seconds": 0.1}, "schema": "",
    }  # fmt: skip
    whole_line = json.dumps(entry).encode() + b"\n"
    file.write_bytes(whole_line * draw.randint(0, 1) + written(mutated(entry, draw), draw) + (
        b"\n" + whole_line if draw.random() < 0.3 else b""
    ))  # fmt: skip
    before = file.read_bytes()
    try:
        tape = Tape(file)
    except ModelError as refused_:
        str(refused_).encode()
        assert file.read_bytes() == before
        return
    for kept in tape.entries.values():
        check(kept.reply, "")
    request = Request((Message("user", f"new {draw.random()}"),))
    Cassette(tape, "auto", Model(), "m", {}).complete(request)
    assert len(Tape(file).entries) == len(tape.entries)


def fuzz(count: int, seed: int = 0) -> None:
    """Try both doors.

    Args:
        count: of replies, and of cassettes.
        seed: of the random numbers.
    """
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            for door in (provider, lambda draw: cassette(draw, Path(folder) / "c.jsonl")):
                began = time.process_time()
                try:
                    door(random.Random(f"{seed}.{number}"))
                except Exception as error:
                    raise AssertionError(f"seed {seed}, number {number}") from error
                assert time.process_time() - began < LONGEST_S, f"slow: seed {seed}, {number}"


if __name__ == "__main__":
    amount, start = (int(word) for word in (*sys.argv[1:], *("1000", "0")[len(sys.argv) - 1 :]))
    fuzz(amount, start)
    print(f"{amount:,} replies and {amount:,} cassettes: nothing came through")
