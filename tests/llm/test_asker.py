"""Rounds of questions: at once, bounded, in robot order, within budgets, with a breaker."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import pytest

from swarmscout.core.errors import ModelError
from swarmscout.core.language_model import Message, Reply, Request
from swarmscout.llm.dispatcher import Asker, Limits


class Scripted:
    """Answers as a function says; notes how many it answered at the same time."""

    def __init__(self, act: Callable[[Request], Reply]) -> None:
        self.act = act
        self.budgets: list[float] = []
        self.at_once = self.most = self.calls = 0
        self._lock = threading.Lock()

    def complete(self, request: Request) -> Reply:
        with self._lock:
            self.calls += 1
            self.budgets.append(request.budget_s)
            self.at_once += 1
            self.most = max(self.most, self.at_once)
        try:
            return self.act(request)
        finally:
            with self._lock:
                self.at_once -= 1


def questions(*names: str) -> list[tuple[int, Request]]:
    return [(k, Request((Message("user", name),))) for k, name in enumerate(names)]


def fine(request: Request) -> Reply:
    return Reply(request.messages[0].text, tokens_in=10, tokens_out=2, cost_usd=0.5, seconds=1.0)


def test_all_at_once_and_answers_in_robot_order() -> None:
    def slower_first(request: Request) -> Reply:
        time.sleep(0.2 if request.messages[0].text == "a" else 0.05)
        return fine(request)

    model = Scripted(slower_first)
    asker = Asker(model, Limits(concurrency=8), "m")
    assert [r.text for r in asker(1, questions(*"abcdef"))] == list("abcdef")
    assert model.most == 6
    asker.close()
    bounded = Scripted(slower_first)
    asker = Asker(bounded, Limits(concurrency=2), "m")
    assert [r.text for r in asker(1, questions(*"abcdef"))] == list("abcdef")
    assert bounded.most == 2
    asker.close()


@pytest.mark.parametrize(
    ("limit", "answered", "says"),
    [
        ({"max_calls": 4}, 4, "4 calls"),
        ({"max_tokens": 24}, 3, "24 tokens"),
        ({"max_cost_usd": 1.0}, 3, "$1"),
        ({"max_calls": 0}, 0, "0 calls"),
    ],
)
def test_budgets(limit: dict[str, float], answered: int, says: str) -> None:
    """Tokens and costs are known after a round, so a round may go over them, and no further."""
    model = Scripted(fine)
    asker = Asker(model, Limits(**limit), "m")
    for step in range(3):
        asker(step, questions(*"abc"))
    assert model.calls in (answered, 6 if "max_calls" not in limit else answered)
    replies = asker(9, questions("x"))
    assert [(r.failure, r.tries) for r in replies] == [("budget used up", 0)]
    assert says in asker.trouble
    assert asker.figures()["calls"] == model.calls
    asker.close()


def test_the_breaker_pauses_probes_and_closes() -> None:
    down = True

    def act(request: Request) -> Reply:
        return Reply(failure="timeout", note="slow") if down else fine(request)

    model = Scripted(act)
    asker = Asker(model, Limits(breaker_failures=3, breaker_steps=10), "m")
    assert [r.failure for r in asker(1, questions("a", "b"))] == ["timeout"] * 2
    assert [r.failure for r in asker(2, questions("a", "b"))] == ["timeout"] * 2
    assert "timeout: slow; it is asked again after 10 steps" in asker.trouble
    for step in (3, 12):
        assert [r.failure for r in asker(step, questions("a", "b"))] == ["paused"] * 2
    assert model.calls == 4
    assert [r.failure for r in asker(13, questions("a", "b"))] == ["timeout", "paused"]
    assert [r.failure for r in asker(14, questions("a"))] == ["paused"]
    down = False
    assert [r.failure for r in asker(24, questions("a", "b"))] == ["", "paused"]
    assert [r.failure for r in asker(25, questions("a", "b"))] == ["", ""]
    assert asker.trouble == ""
    asker.close()


def test_a_wrong_key_is_tried_once_and_a_long_prompt_breaks_nothing() -> None:
    model = Scripted(lambda request: Reply(failure="unauthorized", note="no"))
    asker = Asker(model, Limits(), "m")
    asker(1, questions("a"))
    assert asker(500, questions("a"))[0].failure == "paused"
    assert model.calls == 1
    assert "not asked any more" in asker.trouble
    asker.close()
    model = Scripted(lambda request: Reply(failure="too long"))
    asker = Asker(model, Limits(breaker_failures=2), "m")
    for step in range(5):
        asker(step, questions("a"))
    assert model.calls == 5
    assert asker.trouble == ""
    asker.close()


def test_a_decision_has_its_time_over_all_its_questions() -> None:
    def slow(request: Request) -> Reply:
        return Reply("x", seconds=25.0)

    model = Scripted(slow)
    asker = Asker(model, Limits(decision_s=60.0), "m")
    replies = [asker(1, questions("a"))[0] for _ in range(4)]
    assert [r.failure for r in replies] == ["", "", "", "timeout"]
    assert model.budgets == [60.0, 35.0, 10.0]
    assert asker(2, questions("a"))[0].failure == ""
    asker.close()


def test_a_model_that_breaks_its_contract_is_named() -> None:
    def fail(request: Request) -> Reply:
        raise ZeroDivisionError("no luck")

    for act, says in (
        (fail, r"the model failed: ZeroDivisionError: no luck \(step 3, robot 0\)"),
        (lambda request: "text", r"returned str, not a Reply \(step 3, robot 0\)"),
    ):
        asker = Asker(Scripted(act), Limits(), "m")
        with pytest.raises(ModelError, match=says):
            asker(3, questions("a"))
        asker.close()


def test_half_a_character_can_be_kept() -> None:
    asker = Asker(Scripted(lambda request: Reply("a\ud800b")), Limits(), "m")
    assert asker(1, questions("a"))[0].text == "a?b"
    asker.close()
