"""Answers that take a while: off by default, and nobody stands still when they are on."""

from __future__ import annotations

import json
from collections.abc import Sequence

import pytest

from swarmscout import Mission, Scenario
from swarmscout.core.language_model import Message, Reply, Request
from swarmscout.core.recorder import Decision
from swarmscout.destinations.asking import Talk, settle
from swarmscout.destinations.registry import make_selector
from swarmscout.destinations.selector import Choice
from swarmscout.testing import small_world
from swarmscout.testing.fingerprints import fingerprint


def last(step: int, asked: Sequence[tuple[int, Request]]) -> list[Reply]:
    """The last candidate that is offered."""
    ids = [request.schema["properties"]["choice"]["enum"] for _, request in asked]
    return [Reply(json.dumps({"choice": names[-1], "reason": "far"})) for names in ids]


def fly(latency: int, answer: object = last, name: str = "llm") -> tuple[list[Decision], Mission]:
    keys = {"robots": 8, "steps": 80, "llm": {"latency_steps": latency}, "destinations": "quantile"}
    mission = Mission(Scenario.model_validate(keys), world=small_world(4))
    mission.destinations.selector = make_selector(name)
    mission.destinations.ask = answer
    decisions: list[Decision] = []
    mission.run(lambda m: decisions.extend(m.decisions))
    return decisions, mission


def test_an_answer_arrives_later_and_the_rule_decides_meanwhile() -> None:
    decisions, _ = fly(4)
    asked = [d for d in decisions if d.attempts]
    arrived = [d for d in decisions if "asked_in_step" in d.details]
    assert len(asked) > 3
    assert len(arrived) > 1
    for decision in asked:
        assert decision.details["answer_in_step"] == decision.step + 4
        assert decision.reason.startswith("quantile"), "the rule's"
    for decision in arrived:
        assert decision.step == decision.details["asked_in_step"] + 4
        assert decision.reason == "far"
        question = next(
            d for d in asked
            if d.step == decision.details["asked_in_step"] and d.leader == decision.leader
        )  # fmt: skip
        assert question.attempts[-1].cell == decision.cell
    waiting: dict[int, int] = {}
    for decision in asked:
        assert waiting.get(decision.leader, 0) <= decision.step, "one question at a time"
        waiting[decision.leader] = decision.step + 4


def test_without_latency_an_answer_is_there_at_once() -> None:
    decisions, _ = fly(0)
    assert all(d.reason == "far" for d in decisions if d.attempts)
    assert not any("asked_in_step" in d.details for d in decisions)


@pytest.mark.parametrize("latency", [0, 1, 7])
def test_a_model_that_never_answers_changes_nothing_with_latency_either(latency: int) -> None:
    keys = {"robots": 8, "steps": 80, "destinations": "quantile"}
    baseline = Mission(Scenario.model_validate(keys), world=small_world(4))
    baseline.run()

    def silent(step: int, asked: Sequence[tuple[int, Request]]) -> list[Reply]:
        return [Reply(failure="timeout")] * len(asked)

    _, mission = fly(latency, silent)
    for one, other in ((baseline.minds.own, mission.minds.own),
                       (baseline.bodies.pose, mission.bodies.pose)):  # fmt: skip
        assert fingerprint(one) == fingerprint(other)


def test_rounds_ask_in_robot_order_and_go_on_with_who_is_not_done() -> None:
    rounds: list[list[tuple[int, str]]] = []

    def ask(step: int, asked: Sequence[tuple[int, Request]]) -> list[Reply]:
        rounds.append([(robot, request.messages[0].text) for robot, request in asked])
        return [Reply(f"to {robot}") for robot, _ in asked]

    def talk(questions: int) -> Talk:
        heard = []
        for number in range(questions):
            reply = yield Request((Message("user", f"{questions}.{number}"),))
            heard.append(reply.text)
        return Choice((0, questions), reason=" ".join(heard))

    choices = settle([(3, talk(1)), (5, talk(3)), (7, talk(0)), (9, talk(2))], ask, 1)
    assert rounds == [
        [(3, "1.0"), (5, "3.0"), (9, "2.0")],
        [(5, "3.1"), (9, "2.1")],
        [(5, "3.2")],
    ]
    assert [choice.cell[1] for choice in choices] == [1, 3, 0, 2]
    assert choices[1].reason == "to 5 to 5 to 5"
