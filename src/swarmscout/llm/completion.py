"""Reading a server's reply: a chat completion, or one of the things that come in its place."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from swarmscout.core.language_model import Reply
from swarmscout.core.text import clean_line
from swarmscout.llm.clean import clean_count, clean_reply
from swarmscout.llm.failures import TryFailed
from swarmscout.llm.settings import Endpoint

__all__ = ["Completion", "kind_of_status", "read_completion", "words_of"]

_SAYING = (
    "message", "error", "detail", "details", "msg", "errors", "error_description", "title", "reason"
)  # fmt: skip
_ENDS = {
    "length": "length",
    "max_tokens": "length",
    "content_filter": "filter",
    "safety": "filter",
}
_DEEPEST = 6


@dataclass(frozen=True, slots=True)
class Completion:
    """A server's answer.

    Attributes:
        reply: the answer.
        thinking: whether the model thought before it answered, or used up its tokens doing so.
    """

    reply: Reply
    thinking: bool


def read_completion(data: bytes, endpoint: Endpoint) -> Completion:
    """Read the body of a reply with status 200.

    Args:
        data: the body.
        endpoint: where it comes from; its key is taken out of all texts.

    Raises:
        TryFailed: the body holds no answer; the failure says what it holds instead.
    """
    body = _parsed(data, endpoint)
    if isinstance(body, list) and body and isinstance(body[0], dict):
        body = body[0]
    choices = body.get("choices") if isinstance(body, dict) else None
    choice = choices[0] if isinstance(choices, list) and choices else None
    if not isinstance(choice, dict):
        raise _in_place_of_an_answer(body, endpoint)
    if choice.get("error") and not choice.get("message"):
        raise _in_place_of_an_answer(choice, endpoint)
    message = choice.get("message")
    if not isinstance(message, dict):
        if not isinstance(choice.get("text"), str):
            raise _in_place_of_an_answer(body, endpoint)
        message = {"content": choice["text"]}
    text = _content(message)
    refusal = message.get("refusal")
    finish = _ENDS.get(str(choice.get("finish_reason")).casefold(), "stop")
    usage = body.get("usage") if isinstance(body.get("usage"), dict) else {}
    model = body.get("model")
    # A local server's model may be a path, which is private.
    name = model.replace("\\", "/").rsplit("/", 1)[-1] if isinstance(model, str) else ""
    hidden_in = endpoint.key.hidden_in
    reply = Reply(
        text=hidden_in(str(refusal) if refusal and not text else text),
        finish="refusal" if refusal else finish,
        model=hidden_in(name).strip() or endpoint.model,
        tokens_in=clean_count(usage.get("prompt_tokens")),
        tokens_out=clean_count(usage.get("completion_tokens")),
    )
    return Completion(clean_reply(reply), _thinking(message, usage, text))


def words_of(body: Any, depth: int = 0) -> str:
    """The words in an error's body, in any of its forms; empty if it has none."""
    if isinstance(body, str):
        return "" if body.lstrip()[:1] == "<" else body
    if depth > _DEEPEST:
        return ""
    if isinstance(body, list):
        found = [words for one in body[:3] if (words := words_of(one, depth + 1))]
        return "; ".join(found)
    if not isinstance(body, dict):
        return ""
    words = next((w for key in _SAYING if (w := words_of(body.get(key), depth + 1))), "")
    place = body.get("loc")
    if words and isinstance(place, list):
        words = f"{'.'.join(map(str, place[:6]))}: {words}"
    return words


def kind_of_status(status: int) -> str:
    """The failure that an HTTP status means."""
    kinds = {
        401: "unauthorized",
        403: "forbidden",
        404: "not found",
        408: "timeout",
        413: "too long",
        429: "rate limit",
    }
    return kinds.get(status, "server error" if status >= 500 else "bad request")


def _parsed(data: bytes, endpoint: Endpoint) -> Any:
    text = data.decode("utf-8", "replace").lstrip("\ufeff").strip()
    if not text:
        raise TryFailed("malformed reply", "the server's reply is empty")
    if text.startswith("<"):
        raise TryFailed(
            "malformed reply",
            "the server sent a web page: is this the address of its API? most end in /v1",
        )
    if text.startswith(("data:", "event:", ":")):
        raise TryFailed("malformed reply", "the server sent an event stream instead of one reply")
    try:
        # A number too long for Python is no count of anything.
        return json.loads(text, parse_int=lambda n: int(n) if len(n) < 20 else None)
    except (ValueError, RecursionError):
        said = clean_line(endpoint.key.scrubbed(text[:200]), 60)
        raise TryFailed("malformed reply", f"the server's reply is not JSON: {said}") from None


def _in_place_of_an_answer(body: Any, endpoint: Endpoint) -> TryFailed:
    """The failure in a body without an answer, which may be an error sent with status 200."""
    said = clean_line(endpoint.key.scrubbed(words_of(body)[:2000]), 200)
    error = body.get("error") if isinstance(body, dict) else None
    if error:
        codes = [error.get(key) for key in ("code", "status")] if isinstance(error, dict) else []
        numbers = [int(str(code)) for code in codes if str(code) in map(str, range(400, 600))]
        status = numbers[0] if numbers else 500
        return TryFailed(kind_of_status(status), said or "the server reports an error")
    words = f": {said}" if said else ""
    return TryFailed("malformed reply", f"the server's reply holds no answer{words}")


def _content(message: dict[str, Any]) -> str:
    """The text of a message: a text, parts of which only texts count, or a tool call."""
    content = message.get("content")
    if isinstance(content, str) and content:
        return content
    if isinstance(content, list):
        parts = [part if isinstance(part, dict) else {} for part in content]
        texts = [
            part["text"]
            for part in parts
            if part.get("type", "text") in ("text", "output_text")
            and isinstance(part.get("text"), str)
        ]
        if not texts and not any(part.get("type") for part in parts):
            raise TryFailed("malformed reply", "the server's reply holds parts without a text")
        return "".join(texts)
    if content:
        kind = type(content).__name__
        raise TryFailed("malformed reply", f"the server's reply holds a {kind} instead of a text")
    calls = message.get("tool_calls")
    call = calls[0] if isinstance(calls, list) and calls else None
    function = call.get("function") if isinstance(call, dict) else None
    arguments = function.get("arguments") if isinstance(function, dict) else None
    return arguments if isinstance(arguments, str) else ""


def _thinking(message: dict[str, Any], usage: dict[str, Any], text: str) -> bool:
    if any(message.get(key) for key in ("reasoning_content", "reasoning", "thinking")):
        return True
    details = usage.get("completion_tokens_details")
    counted = details.get("reasoning_tokens") if isinstance(details, dict) else None
    opened = text.lstrip()[:20].casefold().startswith(("<think", "[think", "<|channel|>analysis"))
    return bool(clean_count(counted)) or opened or not text.strip()
