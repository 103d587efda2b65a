"""Asking for many leaders at once: bounded, within budgets, and with a circuit breaker.

A step's questions go out together, and answers come back in the order of robots. Budgets and the
breaker are looked at before and after such a round, in the order of robots too, so they depend on
what was answered and never on who was faster: a replayed mission takes the same turns.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

from swarmscout.core.errors import ModelError, SwarmscoutError
from swarmscout.core.language_model import Model, Reply, Request
from swarmscout.llm.failures import HOPELESS

__all__ = ["Asker", "Limits"]


@dataclass(frozen=True, slots=True)
class Limits:
    """How much may be asked.

    Attributes:
        concurrency: requests under way at once.
        decision_s: how long one decision may take in all.
        breaker_failures: after so many failures in a row nobody is asked …
        breaker_steps: … for so many steps.
        max_calls, max_tokens, max_cost_usd: of a mission; None: as much as it takes.
    """

    concurrency: int = 8
    decision_s: float = 60.0
    breaker_failures: int = 5
    breaker_steps: int = 20
    max_calls: int | None = None
    max_tokens: int | None = None
    max_cost_usd: float | None = None


class Asker:
    """Asks a model for many robots at once.

    Args:
        model: who answers.
        limits: how much may be asked.
        name: the model's, for the summary.

    Attributes:
        trouble: in one line, why the model does not answer; empty while it does.
    """

    def __init__(self, model: Model, limits: Limits, name: str = "") -> None:
        self.trouble = ""
        self._model = model
        self._limits = limits
        self._name = name
        self._pool = ThreadPoolExecutor(limits.concurrency, thread_name_prefix="asking")
        self._calls = self._sent = self._tokens_in = self._tokens_out = 0
        self._cost_usd = 0.0
        self._cost_known = True
        self._failures: Counter[str] = Counter()
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
            else self._pool.submit(
                self._model.complete,
                replace(request, budget_s=self._limits.decision_s - self._spent_s.get(robot, 0.0)),
            )
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
        """Stop asking."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        if hasattr(self._model, "close"):
            self._model.close()

    def figures(self) -> dict[str, Any]:
        """What was asked so far, for the summary."""
        return {
            "model": self._name,
            "calls": self._calls,
            "requests": self._sent,
            "failures": dict(sorted(self._failures.items())),
            "tokens_in": self._tokens_in,
            "tokens_out": self._tokens_out,
            "cost_usd": round(self._cost_usd, 6) if self._cost_known else None,
            "trouble": self.trouble,
        }

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
        # After a pause one question finds out whether the model is back.
        if self._in_a_row >= limits.breaker_failures and position > 0:
            return "paused"
        if self._spent_s.get(robot, 0.0) >= limits.decision_s:
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
        self._in_a_row = 0
        self._paused_until = -1
        self.trouble = ""
        # A server that does not count is taken to use a token for three characters.
        characters = sum(len(message.text) for message in request.messages)
        self._tokens_in += characters // 3 if reply.tokens_in is None else reply.tokens_in
        self._tokens_out += len(reply.text) // 3 if reply.tokens_out is None else reply.tokens_out
        if reply.cost_usd is None:
            self._cost_known = False
        else:
            self._cost_usd += reply.cost_usd

    def _fail(self, reply: Reply, step: int) -> None:
        if reply.failure == "too long":
            return  # It is the prompt, not the model.
        self._in_a_row += 1
        said = f"{reply.failure}: {reply.note}" if reply.note else reply.failure
        if reply.failure in HOPELESS:
            self._paused_until = 1 << 62
            self.trouble = f"{said}; it is not asked any more"
        elif self._in_a_row >= self._limits.breaker_failures:
            self._paused_until = step + self._limits.breaker_steps
            self.trouble = f"{said}; it is asked again after {self._limits.breaker_steps} steps"


def _checked(call: Any, where: str) -> Reply:
    try:
        reply = call.result()
    except SwarmscoutError as error:
        raise ModelError(f"{error} ({where})") from None
    except Exception as error:
        raise ModelError(f"the model failed: {type(error).__name__}: {error} ({where})") from error
    if not isinstance(reply, Reply):
        kind = type(reply).__name__
        raise ModelError(f"the model's complete() returned {kind}, not a Reply ({where})")
    # Half of a character can be said in JSON, and cannot be kept in any file.
    return replace(reply, text=reply.text.encode(errors="replace").decode())
