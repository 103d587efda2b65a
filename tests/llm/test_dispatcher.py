"""Rounds of questions: at once, bounded, in robot order, within budgets, with a breaker."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import pytest

from swarmscout.core.errors import ModelError
from swarmscout.core.language_model import Message, Reply, Request
from swarmscout.llm.dispatcher import Dispatcher
from swarmscout.llm.settings import LlmSettings


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
    asker = Dispatcher(model, LlmSettings(concurrency=8), "m")
    assert [r.text for r in asker(1, questions(*"abcdef"))] == list("abcdef")
    assert model.most == 6
    asker.close()
    bounded = Scripted(slower_first)
    asker = Dispatcher(bounded, LlmSettings(concurrency=2), "m")
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
    asker = Dispatcher(model, LlmSettings(**limit), "m")
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
    asker = Dispatcher(model, LlmSettings(breaker_failures=3, breaker_steps=10), "m")
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


def test_the_breaker_opens_at_its_number_of_failures_and_probes_with_one_question() -> None:
    model = Scripted(lambda request: Reply(failure="server error"))
    asker = Dispatcher(model, LlmSettings(breaker_failures=3, breaker_steps=10), "m")
    found = [asker(step, questions("a"))[0].failure for step in range(5)]
    assert found == ["server error"] * 3 + ["paused"] * 2
    assert [r.failure for r in asker(12, questions("a", "b"))] == ["paused"] * 2
    assert [r.failure for r in asker(13, questions("a", "b"))] == ["server error", "paused"]
    assert [r.failure for r in asker(23, questions("a"))] == ["paused"]
    assert [r.failure for r in asker(24, questions("a"))] == ["server error"]
    assert model.calls == 5
    asker.close()


def test_a_wrong_key_is_tried_once_and_a_long_prompt_breaks_nothing() -> None:
    model = Scripted(lambda request: Reply(failure="unauthorized", note="no"))
    asker = Dispatcher(model, LlmSettings(), "m")
    asker(1, questions("a"))
    assert asker(500, questions("a"))[0].failure == "paused"
    assert model.calls == 1
    assert "it is not asked again" in asker.trouble
    asker.close()
    model = Scripted(lambda request: Reply(failure="too long"))
    asker = Dispatcher(model, LlmSettings(breaker_failures=2), "m")
    for step in range(5):
        asker(step, questions("a"))
    assert model.calls == 5
    assert asker.trouble == "too long", "said, although the next prompt may fit"
    asker.close()


@pytest.mark.parametrize("failure", ["forbidden", "not found", "unauthorized"])
def test_one_refusal_does_not_end_asking(failure: str) -> None:
    """A prompt may be flagged, a deployment may be minutes old."""
    answers = iter(["", failure, "", failure, ""])
    model = Scripted(lambda r: Reply(failure=why) if (why := next(answers)) else fine(r))
    asker = Dispatcher(model, LlmSettings(), "m")
    found = [asker(step, questions("a"))[0].failure for step in range(5)]
    assert found == ["", failure, "", failure, ""]
    assert asker.trouble == ""
    asker.close()


def test_the_embedded_model_has_all_the_time_it_takes() -> None:
    """Else a decision would depend on how fast the machine is."""
    model = Scripted(lambda request: Reply("x", seconds=5000.0))
    asker = Dispatcher(model, LlmSettings(provider="embedded", decision_s=1.0), "m")
    assert [asker(1, questions("a"))[0].failure for _ in range(4)] == [""] * 4
    assert model.budgets == [float("inf")] * 4
    asker.close()


def test_the_longest_answer_and_what_is_worth_a_note() -> None:
    asked: list[int] = []

    def act(request: Request) -> Reply:
        asked.append(request.max_tokens)
        return Reply("x", note=f"read {len(asked)},000 tokens")

    asker = Dispatcher(Scripted(act), LlmSettings(answer_tokens=77), "m")
    for step in range(3):
        asker(step, questions("a"))
    assert asked == [77, 77, 77]
    assert asker.figures()["notes"] == "read 1,000 tokens"
    asker.close()


def test_a_decision_has_its_time_over_all_its_questions() -> None:
    def slow(request: Request) -> Reply:
        return Reply("x", seconds=25.0)

    model = Scripted(slow)
    asker = Dispatcher(model, LlmSettings(decision_s=60.0), "m")
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
        (lambda request: Reply(5), r"a Reply whose text is not a text \(step 3, robot 0\)"),
        (lambda request: Reply("x", finish="end"), "finish is none of stop, length, refusal"),
        (lambda request: Reply("x", seconds=float("nan")), "seconds = nan is impossible"),
    ):
        asker = Dispatcher(Scripted(act), LlmSettings(), "m")
        with pytest.raises(ModelError, match=says):
            asker(3, questions("a"))
        asker.close()


def test_half_a_character_can_be_kept() -> None:
    asker = Dispatcher(Scripted(lambda request: Reply("a\ud800b")), LlmSettings(), "m")
    assert asker(1, questions("a"))[0].text == "a\ufffdb"
    asker.close()
