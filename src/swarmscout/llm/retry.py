"""Trying again: with backoff, as long as the server asks, and within a decision's time."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from hashlib import blake2b
from typing import Protocol

from swarmscout.core.language_model import Reply, Request
from swarmscout.llm.failures import FINAL, TryFailed
from swarmscout.llm.prices import Prices

__all__ = ["Patient", "Sender"]


BACKOFF_S = 0.5
"""The first wait, up to twice as long; each further one is twice as long."""


class Sender(Protocol):
    """Sends a request once."""

    def send(self, request: Request, timeout_s: float) -> Reply:
        """Send a request once.

        Raises:
            TryFailed: no usable answer came.
        """
        ...


class Patient:
    """A model that does not give up at once; see :class:`swarmscout.core.language_model.Model`.

    Args:
        sender: sends once.
        model: its name, for the record.
        prices: what tokens cost.
        tries: how often a request is sent at most.
        call_s: how long one try may take.
        clock, sleep: for tests.
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
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._sender = sender
        self._model = model
        self._prices = prices
        self._tries = tries
        self._call_s = call_s
        self._clock = clock
        self._sleep = sleep

    def close(self) -> None:
        """End what is under way."""
        if hasattr(self._sender, "close"):
            self._sender.close()

    def complete(self, request: Request) -> Reply:
        """Answer a request, or say why there is no answer."""
        began = self._clock()
        failed = TryFailed("timeout", "no time was left")
        made = 0
        for number in range(self._tries):
            left = request.budget_s - (self._clock() - began)
            if left <= 0.0:
                break
            made = number + 1
            try:
                reply = self._sender.send(request, min(self._call_s, left))
            except TryFailed as error:
                failed = error
            else:
                cost = self._prices.cost_usd(
                    (reply.model, self._model), reply.tokens_in, reply.tokens_out
                )
                return replace(
                    reply, tries=made, seconds=_rounded(self._clock() - began), cost_usd=cost
                )
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
            seconds=_rounded(self._clock() - began),
        )


def _spread(request: Request) -> float:
    """In [0, 1), so that those who failed together do not come back together."""
    text = request.messages[-1].text if request.messages else ""
    return blake2b(text.encode(), digest_size=1).digest()[0] / 256.0


def _rounded(seconds: float) -> float:
    return round(seconds, 4)
