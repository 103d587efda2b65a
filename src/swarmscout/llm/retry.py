"""Retries: with backoff, as the server asks, and within a decision's time."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace
from hashlib import blake2b
from typing import Protocol

from swarmscout.core.language_model import Reply, Request
from swarmscout.core.tokens import estimate_tokens
from swarmscout.llm.failures import FINAL, TryFailed
from swarmscout.llm.prices import Prices

__all__ = ["RetryingModel", "Sender"]


BACKOFF_S = 0.5
"""The first wait, times 1 to 2; each further one is twice as long."""


class Sender(Protocol):
    """Sends a request once."""

    def send(self, request: Request, timeout_s: float) -> Reply:
        """Send a request once.

        Raises:
            TryFailed: no usable answer came.
        """
        ...

    def close(self) -> None:
        """Cancel all requests under way."""
        ...


class RetryingModel:
    """A model that sends a failed request again; see ``core.language_model.Model``.

    Args:
        sender: sends once.
        model: its name, for the record.
        prices: of tokens.
        tries: maximum attempts per request.
        call_s: time limit of one attempt, in seconds.
        clock: the time, in seconds.
        sleep: waits for a number of seconds; None: until :meth:`close` at the latest.
    """

    def __init__(
        self,
        sender: Sender,
        model: str,
        prices: Prices,
        *,
        tries: int = 4,
        call_s: float = 30.0,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], object] | None = None,
    ) -> None:
        self._sender = sender
        self._model = model
        self._prices = prices
        self._tries = tries
        self._call_s = call_s
        self._clock = clock
        self._closed = threading.Event()
        self._sleep = sleep or self._closed.wait

    def close(self) -> None:
        """End all waiting and cancel all requests under way."""
        self._closed.set()
        self._sender.close()

    def complete(self, request: Request) -> Reply:
        """Answer a request, or say why there is no answer."""
        began = self._clock()
        failed = TryFailed("timeout", "no time was left")
        made = 0
        for number in range(self._tries):
            left = request.budget_s - (self._clock() - began)
            if left <= 0.0 or self._closed.is_set():
                break
            made = number + 1
            try:
                reply = self._sender.send(request, min(self._call_s, left))
            except TryFailed as error:
                failed = error
            else:
                seconds = round(self._clock() - began, 4)
                cost_usd = self._cost_usd(request, reply)
                return replace(reply, tries=made, seconds=seconds, cost_usd=cost_usd)
            if failed.kind in FINAL or made == self._tries:
                break
            wait = failed.retry_after_s
            if wait is None:
                wait = BACKOFF_S * 2.0**number * (1.0 + _spread(request))
            if wait >= request.budget_s - (self._clock() - began):
                break
            self._sleep(wait)
        return Reply(
            failure=failed.kind,
            note=failed.note,
            model=self._model,
            tries=made,
            seconds=round(self._clock() - began, 4),
        )

    def _cost_usd(self, request: Request, reply: Reply) -> float | None:
        """The price of a reply; tokens that the server did not count are estimated."""
        read, written = reply.tokens_in, reply.tokens_out
        if read is None:
            read = sum(estimate_tokens(message.text) for message in request.messages)
        if written is None:
            written = estimate_tokens(reply.text)
        return self._prices.cost_usd((reply.model, self._model), read, written)


def _spread(request: Request) -> float:
    """In [0, 1), so that requests that failed together are not sent again together."""
    text = request.messages[-1].text if request.messages else ""
    return blake2b(text.encode(errors="replace"), digest_size=1).digest()[0] / 256.0
