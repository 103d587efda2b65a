"""OpenAI, Azure OpenAI and every compatible server, through the official ``openai`` SDK.

One call is one HTTP request: retries, budgets and records are not this module's. The SDK's own
timeouts are per read, so a call is put under a time limit as a whole, in an event loop of its own.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Mapping
from copy import deepcopy
from email.utils import parsedate_to_datetime
from typing import Any
from urllib.parse import urlsplit

from swarmscout.core.errors import ModelError
from swarmscout.core.extras import install_command
from swarmscout.core.language_model import Reply, Request
from swarmscout.llm.failures import TryFailed
from swarmscout.llm.settings import Endpoint

__all__ = ["OpenAIModel"]

_NOTE = 200


class OpenAIModel:
    """Sends a request once.

    Args:
        endpoint: where to.
        temperature: of sampling; left out when the server does not take it.
        structured: ``auto`` asks for JSON by schema until the server refuses, ``schema`` insists,
            ``off`` never does.
        extra: further fields of the request's body, as some servers take them.

    Raises:
        ModelError: the SDK is not installed.
    """

    def __init__(
        self,
        endpoint: Endpoint,
        *,
        temperature: float = 0.0,
        structured: str = "auto",
        extra: Mapping[str, Any] | None = None,
    ) -> None:
        try:
            import openai
        except ImportError:
            raise ModelError(
                f"asking a language model needs the package openai: {install_command('llm')}"
            ) from None
        self._openai: Any = openai
        self._endpoint = endpoint
        self._extra = dict(extra or {})
        self._insists = structured == "schema"
        # Fields that the server turned out not to take.
        self._without: set[str] = {"response_format"} if structured == "off" else set()
        self._temperature = temperature
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread: threading.Thread | None = None
        self._starting = threading.Lock()
        self._closed = False
        self._client: Any = None

    def __repr__(self) -> str:
        return f"<OpenAIModel {self._endpoint.model} of {self._endpoint.provider}>"

    def send(self, request: Request, timeout_s: float) -> Reply:
        """Send a request once.

        Args:
            request: what to ask.
            timeout_s: from the first byte sent to the last one received.

        Raises:
            TryFailed: no usable answer came.
        """
        loop = self._running()
        return asyncio.run_coroutine_threadsafe(self._send(request, timeout_s), loop).result()

    def close(self) -> None:
        """End what is under way."""

        async def finish() -> None:
            others = [t for t in asyncio.all_tasks() if t is not asyncio.current_task()]
            for task in others:
                task.cancel()
            await asyncio.gather(*others, return_exceptions=True)
            if self._client is not None:
                await self._client.close()

        with self._starting:
            self._closed = True
            if self._loop is None or self._thread is None:
                return
            asyncio.run_coroutine_threadsafe(finish(), self._loop).result(timeout=5.0)
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join()
            self._loop.close()
            self._loop = self._thread = self._client = None

    def _running(self) -> asyncio.AbstractEventLoop:
        """The event loop, in a thread of its own."""
        with self._starting:
            if self._closed:
                raise TryFailed("no connection", "the mission is over")
            if self._loop is None:
                self._loop = asyncio.new_event_loop()
                self._thread = threading.Thread(
                    target=self._loop.run_forever, name="llm", daemon=True
                )
                self._thread.start()
            return self._loop

    async def _send(self, request: Request, timeout_s: float) -> Reply:
        if self._client is None:
            self._client = self._connected()
        began = time.monotonic()
        for _ in range(4):
            left = timeout_s - (time.monotonic() - began)
            body = self._body(request)
            try:
                async with asyncio.timeout(left):
                    answer = await self._client.chat.completions.create(**body)
            except TimeoutError:
                raise TryFailed("timeout", f"no answer within {timeout_s:g} s") from None
            except self._openai.BadRequestError as error:
                if not self._adapt(error, body):
                    raise self._refused(error) from None
            except Exception as error:
                raise self._failed(error) from None
            else:
                return self._reply(answer)
        raise TryFailed("bad request", "the server takes none of the forms that were tried")

    def _connected(self) -> Any:
        endpoint = self._endpoint
        # Tries are counted elsewhere: with the SDK's own, six calls would become eighteen requests.
        common: dict[str, Any] = {"max_retries": 0, "api_key": endpoint.key.reveal() or "none"}
        if endpoint.provider == "azure":
            return self._openai.AsyncAzureOpenAI(
                azure_endpoint=endpoint.base_url,
                azure_deployment=endpoint.model,
                api_version=endpoint.api_version,
                **common,
            )
        # Given even when it is the SDK's own: the environment has been read already.
        url = endpoint.base_url or "https://api.openai.com/v1"
        if urlsplit(url).hostname in ("127.0.0.1", "localhost", "::1"):
            # A proxy for the world outside is none for this machine.
            common["http_client"] = self._openai.DefaultAsyncHttpxClient(trust_env=False)
        return self._openai.AsyncOpenAI(base_url=url, **common)

    def _body(self, request: Request) -> dict[str, Any]:
        hosted = self._endpoint.provider in ("openai", "azure")
        limit = "max_completion_tokens" if hosted else "max_tokens"
        if limit in self._without:
            limit = "max_tokens" if hosted else "max_completion_tokens"
        body: dict[str, Any] = {
            "model": self._endpoint.model,
            "messages": [{"role": m.role, "content": m.text} for m in request.messages],
            limit: request.max_tokens,
            "temperature": self._temperature,
        }
        if request.schema is not None:
            schema = deepcopy(dict(request.schema))
            if hosted:
                _strip(schema, ("maxLength", "maxItems"))
            body["response_format"] = {
                "type": "json_schema",
                "json_schema": {"name": "destination", "strict": True, "schema": schema},
            }
        if self._extra:
            body["extra_body"] = self._extra
        return {key: value for key, value in body.items() if key not in self._without}

    def _adapt(self, error: Any, body: Mapping[str, Any]) -> bool:
        """Leave out what the server says that it does not take; False if there is nothing."""
        words = str(error).casefold()
        for field, signs in (
            ("response_format", ("response_format", "json_schema", "schema", "grammar")),
            ("temperature", ("temperature",)),
            ("max_completion_tokens", ("max_completion_tokens",)),
            ("max_tokens", ("max_tokens",)),
        ):
            if field not in body or not any(sign in words for sign in signs):
                continue
            if field == "response_format" and self._insists:
                return False
            self._without.add(field)
            return True
        return False

    def _refused(self, error: Any) -> TryFailed:
        words = str(error).casefold()
        if "context" in words or "too long" in words or "maximum" in words:
            return TryFailed("too long", "the prompt is longer than the model takes")
        if "content_filter" in words or "content management policy" in words:
            return TryFailed("bad request", "the provider's content filter stopped the prompt")
        return TryFailed("bad request", self._told(error))

    def _failed(self, error: Exception) -> TryFailed:
        sdk = self._openai
        if isinstance(error, sdk.APITimeoutError):
            return TryFailed("timeout", "the server did not answer in time")
        if isinstance(error, sdk.APIConnectionError):
            cause = type(error.__cause__).__name__ if error.__cause__ else "connection failed"
            return TryFailed("no connection", cause)
        if isinstance(error, sdk.AuthenticationError | sdk.PermissionDeniedError):
            # What the server says may quote the key.
            return TryFailed("unauthorized", f"the server refuses the key ({error.status_code})")
        if isinstance(error, sdk.NotFoundError):
            return TryFailed("not found", f"no such model or address: {self._told(error)}")
        if isinstance(error, sdk.RateLimitError):
            wait = retry_after(error.response.headers, time.time())
            return TryFailed("rate limit", self._told(error), wait)
        if isinstance(error, sdk.APIStatusError):
            kind = "server error" if error.status_code >= 500 else "bad request"
            wait = retry_after(error.response.headers, time.time())
            return TryFailed(kind, f"{error.status_code} {self._told(error)}".strip(), wait)
        # A 200 whose body is no JSON, or not what was promised, fails deep inside the SDK.
        return TryFailed("malformed reply", f"the server's reply is unreadable ({_kind(error)})")

    def _told(self, error: Any) -> str:
        body = getattr(error, "body", None)
        message = body.get("message") if isinstance(body, dict) else None
        text = message if isinstance(message, str) else ""
        return self._endpoint.key.scrubbed(" ".join(text.split()))[:_NOTE]

    def _reply(self, answer: Any) -> Reply:
        try:
            choice = answer.choices[0]
            message, finish = choice.message, choice.finish_reason
            text = message.content or ""
            refusal = getattr(message, "refusal", None)
            if not isinstance(text, str):
                raise TypeError(type(text).__name__)
        except (AttributeError, TypeError, IndexError, KeyError) as error:
            raise TryFailed(
                "malformed reply", f"the server's reply holds no answer ({_kind(error)})"
            ) from None
        ends = {"length": "length", "content_filter": "filter"}
        usage = getattr(answer, "usage", None)
        model = getattr(answer, "model", None)
        # A path on the server's disk is nobody's business.
        named = model.replace("\\", "/").rsplit("/", 1)[-1] if isinstance(model, str) else ""
        scrub = self._endpoint.key.scrubbed
        return Reply(
            text=scrub(str(refusal) if refusal and not text else text),
            finish="refusal" if refusal else ends.get(finish, "stop"),
            model=scrub(named) or self._endpoint.model,
            tokens_in=_count(getattr(usage, "prompt_tokens", None)),
            tokens_out=_count(getattr(usage, "completion_tokens", None)),
        )


def retry_after(headers: Mapping[str, str], now_s: float) -> float | None:
    """Seconds that a server asks to wait, in any of the forms in use; None if it does not."""
    for name, unit_s in (("retry-after-ms", 1e-3), ("retry-after", 1.0)):
        value = headers.get(name)
        if value is None:
            continue
        try:
            return max(0.0, float(value) * unit_s)
        except ValueError:
            pass
        try:
            return max(0.0, parsedate_to_datetime(value).timestamp() - now_s)
        except (TypeError, ValueError):
            continue
    return None


def _strip(schema: Any, keywords: tuple[str, ...]) -> None:
    """Take keywords out of a JSON schema, everywhere in it."""
    if isinstance(schema, dict):
        for keyword in keywords:
            if not isinstance(schema.get(keyword), dict):
                schema.pop(keyword, None)
        for inner in schema.values():
            _strip(inner, keywords)
    elif isinstance(schema, list):
        for inner in schema:
            _strip(inner, keywords)


def _count(value: Any) -> int | None:
    return value if isinstance(value, int) and not isinstance(value, bool) and value >= 0 else None


def _kind(error: BaseException) -> str:
    return type(error).__name__
