"""Questions of many leaders at once: bounded, within budgets, and with a circuit breaker.

A step's questions are sent together, and answers are handed back in the order of robots. Budgets
and breaker are read before and updated after such a round, in the order of robots, so they depend
on the answers and never on their speed: a replayed mission decides the same.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import replace
from typing import Any

from swarmscout.core.errors import ModelError, SwarmscoutError
from swarmscout.core.language_model import Model, Reply, Request
from swarmscout.core.text import clean_line
from swarmscout.core.tokens import estimate_tokens
from swarmscout.llm.clean import clean_reply
from swarmscout.llm.settings import LlmSettings

__all__ = ["Dispatcher"]

_FOREVER = 1 << 62
_NOTES = 5


class Dispatcher:
    """Asks a model for many robots at once.

    Args:
        model: answers requests.
        limits: concurrency, budgets and breaker of :class:`LlmSettings` are used.
        name: the model's, for the summary.

    Attributes:
        trouble: in one line, why the model does not answer; empty while it does.
    """

    def __init__(self, model: Model, limits: LlmSettings, name: str = "") -> None:
        self.trouble = ""
        self._model = model
        self._limits = limits
        self._decision_s = float("inf") if limits.provider == "embedded" else limits.decision_s
        self._name = name
        self._pool = ThreadPoolExecutor(limits.concurrency, thread_name_prefix="asking")
        self._calls = self._sent = self._answers = self._tokens_in = self._tokens_out = 0
        self._cost_usd = 0.0
        self._cost_known = True
        self._failures: Counter[str] = Counter()
        self._notes: dict[str, str] = {}
        self._in_a_row = 0
        self._paused_until = -1
        self._step = -1
        self._spent_s: dict[int, float] = {}

    def __call__(self, step: int, requests: Sequence[tuple[int, Request]]) -> list[Reply]:
        """Answer the questions of one round.

        Args:
            step: the current step.
            requests: ``(robot, request)`` each, in the order of robots.

        Returns:
            Replies in the same order.

        Raises:
            ModelError: the model broke its contract.
        """
        if step != self._step:
            self._step = step
            self._spent_s = {}
        refusals = [self._refused(step, k, robot) for k, (robot, _) in enumerate(requests)]
        under_way = [
            None
            if refusal
            else self._pool.submit(self._model.complete, self._sized(robot, request))
            for refusal, (robot, request) in zip(refusals, requests, strict=True)
        ]
        replies = []
        for refusal, call, (robot, request) in zip(refusals, under_way, requests, strict=True):
            if call is None:
                replies.append(Reply(failure=refusal, tries=0))
                continue
            reply = _checked(call, f"step {step}, robot {robot}")
            self._spent_s[robot] = self._spent_s.get(robot, 0.0) + reply.seconds
            self._count(reply, request, step)
            replies.append(reply)
        return replies

    def close(self) -> None:
        """Stop asking: requests under way are cancelled."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        close = getattr(self._model, "close", None)
        if close is not None:
            close()

    def figures(self) -> dict[str, Any]:
        """Counts so far, for the summary."""
        return {
            "model": self._name,
            "calls": self._calls,
            "requests": self._sent,
            "failures": dict(sorted(self._failures.items())),
            "tokens_in": self._tokens_in,
            "tokens_out": self._tokens_out,
            "cost_usd": round(self._cost_usd, 6) if self._cost_known else None,
            "trouble": self.trouble,
            **({"notes": "; ".join(self._notes.values())} if self._notes else {}),
        }

    def _sized(self, robot: int, request: Request) -> Request:
        """A request with its limits of time and length."""
        left_s = self._decision_s - self._spent_s.get(robot, 0.0)
        return replace(
            request, budget_s=left_s, max_tokens=self._limits.answer_tokens or request.max_tokens
        )

    def _refused(self, step: int, position: int, robot: int) -> str:
        """Why a question is not asked; empty if it is."""
        limits = self._limits
        calls = self._calls + position
        tokens = self._tokens_in + self._tokens_out
        if limits.max_calls is not None and calls >= limits.max_calls:
            return self._used_up(f"{limits.max_calls} calls")
        if limits.max_tokens is not None and tokens >= limits.max_tokens:
            return self._used_up(f"{limits.max_tokens} tokens")
        if limits.max_cost_usd is not None and self._cost_usd >= limits.max_cost_usd:
            return self._used_up(f"${limits.max_cost_usd:g}")
        if step <= self._paused_until:
            return "paused"
        # After a pause one question finds out whether the model answers again.
        if self._in_a_row >= limits.breaker_failures and position > 0:
            return "paused"
        if self._spent_s.get(robot, 0.0) >= self._decision_s:
            return "timeout"
        return ""

    def _used_up(self, what: str) -> str:
        self.trouble = f"its budget of {what} is used up"
        return "budget used up"

    def _count(self, reply: Reply, request: Request, step: int) -> None:
        self._calls += 1
        self._sent += reply.tries
        if reply.failure:
            self._failures[reply.failure] += 1
            self._fail(reply, step)
            return
        self._answers += 1
        self._in_a_row = 0
        self._paused_until = -1
        self.trouble = ""
        if reply.note and len(self._notes) < _NOTES:
            self._notes.setdefault(re.sub(r"[\d,.]+", "", reply.note), reply.note)
        read, written = reply.tokens_in, reply.tokens_out
        if read is None:
            read = sum(estimate_tokens(message.text) for message in request.messages)
        self._tokens_in += read
        self._tokens_out += estimate_tokens(reply.text) if written is None else written
        if reply.cost_usd is None:
            self._cost_known = False
        else:
            self._cost_usd += reply.cost_usd

    def _fail(self, reply: Reply, step: int) -> None:
        said = f"{reply.failure}: {reply.note}" if reply.note else reply.failure
        if reply.failure == "too long":
            self.trouble = said  # The prompt is at fault: the next one may fit.
            return
        self._in_a_row += 1
        if reply.failure == "unauthorized" and not self._answers:
            self._paused_until = _FOREVER
            self.trouble = f"{said}; it is not asked again"
        elif self._in_a_row >= self._limits.breaker_failures:
            self._paused_until = step + self._limits.breaker_steps
            self.trouble = f"{said}; it is asked again after {self._limits.breaker_steps} steps"
        elif not self._answers:
            self.trouble = said


def _checked(call: Future[Any], where: str) -> Reply:
    wait([call])  # What interrupts the waiting is not the model's failure.
    try:
        reply = call.result()
    except SwarmscoutError as error:
        raise ModelError(f"{error} ({where})") from None
    except Exception as error:
        said = clean_line(f"{type(error).__name__}: {error}")
        raise ModelError(f"the model failed: {said} ({where})") from error
    if not isinstance(reply, Reply):
        kind = type(reply).__name__
        raise ModelError(f"the model's complete() returned {kind}, not a Reply ({where})")
    try:
        return clean_reply(reply)
    except TypeError as error:
        raise ModelError(
            f"the model's complete() returned a Reply whose {error} ({where})"
        ) from None
