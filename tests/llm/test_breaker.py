"""The circuit breaker opens after N failures in a row, then sends one question as a probe."""

from __future__ import annotations

import pytest

from swarmscout.core.language_model import Message, Reply, Request
from swarmscout.llm.dispatcher import Asker, Limits


class Switched:
    """Answers while it is up."""

    def __init__(self) -> None:
        self.up = False
        self.calls = 0

    def complete(self, request: Request) -> Reply:
        self.calls += 1
        return Reply("x") if self.up else Reply(failure="timeout")


def ask(asker: Asker, step: int, count: int = 1) -> list[str]:
    """Why each of some questions got no answer; empty for an answer."""
    asked = [(robot, Request((Message("user", "?"),))) for robot in range(count)]
    return [reply.failure for reply in asker(step, asked)]


@pytest.mark.parametrize("failures", [1, 2, 5])
def test_after_exactly_n_failures_the_breaker_opens_and_sends_one_probe(failures: int) -> None:
    model = Switched()
    asker = Asker(model, Limits(breaker_failures=failures, breaker_steps=4), "m")
    for step in range(1, failures + 1):
        assert "asked again" not in asker.trouble
        assert ask(asker, step) == ["timeout"]
    opened = failures
    assert "asked again after 4 steps" in asker.trouble
    # Open: no question is sent until 4 steps have passed …
    assert ask(asker, opened + 1, 3) == ["paused"] * 3
    assert ask(asker, opened + 4, 3) == ["paused"] * 3
    assert model.calls == failures
    # … then half-open: one of three. Its failure opens the breaker for another 4 steps.
    assert ask(asker, opened + 5, 3) == ["timeout", "paused", "paused"]
    assert ask(asker, opened + 9, 3) == ["paused"] * 3
    model.up = True
    assert ask(asker, opened + 10, 3) == ["", "paused", "paused"]
    # The probe's answer closes it.
    assert ask(asker, opened + 11, 3) == ["", "", ""]
    assert asker.trouble == ""
    assert model.calls == failures + 5
    asker.close()


def test_an_answer_between_failures_starts_the_count_again() -> None:
    model = Switched()
    asker = Asker(model, Limits(breaker_failures=2, breaker_steps=4), "m")
    for step, up in enumerate([False, True, False, True, False, False], start=1):
        model.up = up
        assert ask(asker, step) == ["" if up else "timeout"]
    assert ask(asker, 7) == ["paused"]
    asker.close()
