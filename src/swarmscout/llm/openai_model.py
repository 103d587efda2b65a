"""OpenAI, Azure OpenAI and every compatible server, through the official ``openai`` SDK.

Retries, budgets and records are elsewhere: here a request is sent once, and again only in another
form when the server does not take the first. The SDK's timeouts are per read, so a call runs under
a time limit of its own, in an event loop of its own.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any
from urllib.parse import urlsplit

from swarmscout.core.errors import ModelError
from swarmscout.core.extras import install_command
from swarmscout.core.language_model import Reply, Request
from swarmscout.core.text import clean_line
from swarmscout.core.tokens import estimate_tokens
from swarmscout.llm.causes import all_words, connection_failed, is_loopback, refused
from swarmscout.llm.completion import Completion, read_completion
from swarmscout.llm.failures import TryFailed
from swarmscout.llm.request_form import THINKING_TOKENS, RequestForm
from swarmscout.llm.settings import Endpoint

__all__ = ["OpenAIModel"]

_FORMS = 12
"""Most forms that one request is sent in."""

_STRIKES = 3
"""A form that has worked is given up after this many requests in a row that needed another."""


class OpenAIModel:
    """Sends a request once.

    Args:
        endpoint: the server.
        temperature: of sampling; left out when the server refuses it.
        structured: ``auto`` asks for JSON by schema until the server refuses, ``schema`` insists,
            ``off`` never does.
        effort: how long a reasoning model thinks; empty: its default.
        extra: further fields of the request's body.

    Raises:
        ModelError: the SDK is not installed, or proxy or certificate settings cannot be used.
    """

    def __init__(
        self,
        endpoint: Endpoint,
        *,
        temperature: float = 0.0,
        structured: str = "auto",
        effort: str = "",
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
        self._form = RequestForm.first(
            hosted=endpoint.provider in ("openai", "azure"),
            structured=structured,
            temperature=temperature,
            effort=effort,
        )
        self._works: set[RequestForm] = set()
        self._strikes = 0
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread: threading.Thread | None = None
        self._starting = threading.Lock()
        self._closed = False
        self._client: Any = self._connected()

    def __repr__(self) -> str:
        return f"<OpenAIModel {self._endpoint.model} of {self._endpoint.provider}>"

    def send(self, request: Request, timeout_s: float) -> Reply:
        """Send a request once.

        Args:
            request: the question.
            timeout_s: time limit in seconds, from the first byte sent to the last one received;
                infinity: none.

        Raises:
            TryFailed: no usable answer came.
        """
        loop = self._running()
        return asyncio.run_coroutine_threadsafe(self._send(request, timeout_s), loop).result()

    def close(self) -> None:
        """Cancel all requests under way."""

        async def finish() -> None:
            others = [t for t in asyncio.all_tasks() if t is not asyncio.current_task()]
            for task in others:
                task.cancel()
            await asyncio.gather(*others, return_exceptions=True)
            await self._client.close()

        with self._starting:
            self._closed = True
            if self._loop is None or self._thread is None:
                return
            with suppress(TimeoutError):
                asyncio.run_coroutine_threadsafe(finish(), self._loop).result(timeout=2.0)
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join()
            self._loop.close()
            self._loop = self._thread = None

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
        ends = None if timeout_s == float("inf") else asyncio.get_running_loop().time() + timeout_s
        thinking = self._form.thinking
        try:
            async with asyncio.timeout_at(ends):
                return await self._answered(request)
        except TimeoutError:
            hint = "; raise llm.call_s, or set llm.effort=low: the model thinks" if thinking else ""
            raise TryFailed("timeout", f"no answer within {timeout_s:g} s{hint}") from None

    async def _answered(self, request: Request) -> Reply:
        """The answer, with room for thinking if the model used up its tokens on that."""
        found = await self._in_some_form(request)
        reply, notes = found.reply, [self._cut_prompt(request, found.reply)]
        if reply.finish == "length" and found.thinking and not self._form.thinking:
            self._form = replace(self._form, thinking=THINKING_TOKENS)
            limit = self._form.tokens(request)
            notes.append(
                f"the model thinks before it answers: the limit of its answers was raised from "
                f"{request.max_tokens} to {limit} tokens (set llm.effort or llm.answer_tokens)"
            )
            found = await self._in_some_form(request)
            reply = _together(reply, found.reply)
        if reply.finish == "length" and found.thinking:
            notes = [
                "the model used up its tokens for thinking: raise llm.answer_tokens, or set "
                "llm.effort=low"
            ]
        return replace(reply, note=clean_line("; ".join(note for note in notes if note)))

    async def _in_some_form(self, request: Request) -> Completion:
        """Send a request in the form that works, or find out which one does.

        A form replaces the present one only after it has worked, and only if the present one never
        has, or fails again and again: a server that refuses one prompt is asked as before.
        """
        started = form = self._form
        first: TryFailed | None = None
        for _ in range(_FORMS):
            try:
                found = await self._once(form, request)
            except self._openai.APIStatusError as error:
                failed = refused(
                    error.status_code, error.body, error.response.headers, self._endpoint,
                    time.time(),
                )  # fmt: skip
                first = first or failed
                other = form.after(error.status_code, all_words(error.body), guess=not self._works)
                if other is None:
                    raise (failed if failed.kind == "too long" else first) from None
                form = other
            else:
                self._learn(started, form)
                return found
        raise first or TryFailed("bad request", "the server refuses every form of the request")

    def _learn(self, started: RequestForm, form: RequestForm) -> None:
        if form == started:
            self._strikes = 0
        else:
            self._strikes += 1
        proven = replace(started, thinking=0) in self._works
        if form != started and self._form == started and (
            not proven or self._strikes >= _STRIKES
        ):  # fmt: skip
            self._form, self._strikes = form, 0
        self._works.add(replace(form, thinking=0))

    async def _once(self, form: RequestForm, request: Request) -> Completion:
        body = form.body(self._endpoint.model, request)
        if self._extra:
            body["extra_body"] = self._extra
        sdk = self._openai
        try:
            raw = await self._client.chat.completions.with_raw_response.create(**body)
            return read_completion(raw.content, self._endpoint)
        except (TryFailed, sdk.APIStatusError):
            raise
        except sdk.APITimeoutError:
            raise TryFailed("timeout", "the server did not answer in time") from None
        except sdk.APIConnectionError as error:
            raise connection_failed(error, self._endpoint) from None
        except Exception as error:
            # Reading a body may fail inside the client: wrong compression, wrong length.
            kind = type(error).__name__
            raise TryFailed(
                "malformed reply", f"the server's reply cannot be read ({kind})"
            ) from None

    def _connected(self) -> Any:
        endpoint = self._endpoint
        # The SDK's own retries and time limits are off: both are set here.
        common: dict[str, Any] = {
            "max_retries": 0,
            "timeout": None,
            "api_key": endpoint.key.reveal() or "none",
        }
        # Given even when it is the SDK's own: the environment has been read already.
        url = endpoint.base_url or "https://api.openai.com/v1"
        try:
            if is_loopback(urlsplit(url).hostname or ""):
                # A proxy does not reach this machine.
                client = self._openai.DefaultAsyncHttpxClient(trust_env=False, timeout=None)
                common["http_client"] = client
            if endpoint.provider == "azure":
                return self._openai.AsyncAzureOpenAI(
                    azure_endpoint=url,
                    azure_deployment=endpoint.model,
                    api_version=endpoint.api_version,
                    **common,
                )
            return self._openai.AsyncOpenAI(base_url=url, **common)
        except Exception as error:
            why = clean_line(endpoint.key.scrubbed(str(error)), 200) or type(error).__name__
            raise ModelError(
                f"no connection can be made: {why} (check SSL_CERT_FILE, SSL_CERT_DIR, ALL_PROXY, "
                "HTTPS_PROXY and HTTP_PROXY)"
            ) from None

    def _cut_prompt(self, request: Request, reply: Reply) -> str:
        """A note when the server counted far fewer tokens than the prompt has; empty otherwise."""
        # Below a thousand it is not a context's size, but a count that leaves cached tokens out.
        if reply.tokens_in is None or reply.tokens_in < 1000:
            return ""
        sent = sum(estimate_tokens(message.text) for message in request.messages)
        if reply.tokens_in >= 0.7 * sent:
            return ""
        return (
            f"the server read {reply.tokens_in:,} of about {sent:,} tokens: it cuts prompts off "
            "without an error; give it a larger context (Ollama: OLLAMA_CONTEXT_LENGTH), or lower "
            "selector.prompt_tokens"
        )


def _together(first: Reply, last: Reply) -> Reply:
    """The last reply, with the tokens of both."""
    if None in (first.tokens_in, first.tokens_out, last.tokens_in, last.tokens_out):
        return last
    return replace(
        last,
        tokens_in=(first.tokens_in or 0) + (last.tokens_in or 0),
        tokens_out=(first.tokens_out or 0) + (last.tokens_out or 0),
    )
