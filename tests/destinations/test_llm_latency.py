"""Answers that take a while: off by default, and nobody stands still when they are on."""

from __future__ import annotations

import json
from collections.abc import Sequence

import pytest

from swarmscout import Mission, Scenario
from swarmscout.core.model import Reply, Request
from swarmscout.core.recorder import Decision
from swarmscout.destinations.registry import make_selector
from swarmscout.testing import small_world
from swarmscout.testing.watching import fingerprint


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
    for one, other in ((baseline.minds.state, mission.minds.state),
                       (baseline.bodies.pose, mission.bodies.pose)):  # fmt: skip
        assert fingerprint(one) == fingerprint(other)
