"""A decision by a model: valid answers count, others are asked again, then a rule decides."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from swarmscout import Mission, Scenario
from swarmscout.core.enums import FREE, OCCUPIED
from swarmscout.core.language_model import Reply, Request
from swarmscout.destinations.llm.history import Remembered
from swarmscout.destinations.llm.llm import Llm
from swarmscout.destinations.llm.shortlist import LlmShortlist, ShortlistRandom, best_of
from swarmscout.destinations.registry import RECOMMENDED, make_selector, model_selectors
from swarmscout.testing import check_selector, small_world
from swarmscout.testing.fingerprints import fingerprint
from swarmscout.testing.situations import leader_view, situations


def view_of(step: int = 30, **more: Any):
    labels = np.zeros((20, 20), dtype=np.uint8)
    labels[3:15, 3:17] = FREE
    labels[3, 3:8] = OCCUPIED
    labels[11, 11] = OCCUPIED
    return leader_view(labels, (8, 8), others=(((10, 12), (14, 10)),), step=step, **more)


def hold(selector, view, replies, memory=None):
    """Drive one conversation; returns the requests and the choice."""
    talk = selector.converse(view, memory)
    asked: list[Request] = []
    try:
        asked.append(next(talk))
        for reply in replies:
            asked.append(talk.send(reply))
    except StopIteration as end:
        return asked, end.value
    raise AssertionError("the conversation is not over")


def say(choice: Any, reason: str = "open") -> Reply:
    return Reply(json.dumps({"choice": choice, "reason": reason}))


def named(view, k: int) -> str:
    row, col = view.frontiers[k].tolist()
    return f"{col},{row}"


def test_a_valid_answer_is_the_choice() -> None:
    view = view_of()
    asked, choice = hold(Llm(), view, [say(named(view, 5))])
    assert choice.cell == tuple(view.frontiers[5])
    assert choice.reason == "open"
    assert [a.verdict for a in choice.attempts] == ["valid"]
    assert choice.details == {"shown": len(view.frontiers), "place": 6}
    assert len(asked) == 1


def meanings():
    view = view_of()
    swapped = next(
        (col, row)
        for row, col in view.frontiers.tolist()
        if not (view.frontiers == (col, row)).all(axis=1).any()
    )
    return [
        (f"{swapped[1]},{swapped[0]}", "swapped axes"),
        ("40,3", "outside the map"),
        ("-1,3", "outside the map"),
        ("8,8", "own position"),
        ("12,10", "another team's position"),
        ("9,9", "no frontier"),
        ("11,11", "obstacle"),
        ("1,1", "unexplored cell"),
        ("Z9", "unknown id"),
        (7, "bare number"),
    ]


@pytest.mark.parametrize(("choice", "verdict"), meanings())
def test_what_is_no_frontier_has_a_name_and_is_told(choice: Any, verdict: str) -> None:
    view = view_of()
    asked, made = hold(Llm(), view, [say(choice), say(named(view, 0))])
    assert [a.verdict for a in made.attempts] == [verdict, "valid"]
    assert [r.attempt for r in asked] == [1, 2]
    roles = [m.role for m in asked[1].messages]
    assert roles == ["system", "user", "assistant", "user"]
    assert "cannot be used" in asked[1].messages[-1].text
    assert asked[1].messages[:2] == asked[0].messages


def test_a_stale_frontier() -> None:
    view = view_of(previous=(7, 7))
    _, made = hold(Llm(retries=0), view, [say("7,7")])
    assert [a.verdict for a in made.attempts] == ["stale frontier"]


def test_after_five_retries_the_baseline_decides_as_if_nobody_had_been_asked() -> None:
    view = view_of()
    baseline = make_selector("quantile").choose(view_of(), None)
    asked, choice = hold(Llm(), view, [say("40,3")] * 6)
    assert len(asked) == 6
    assert choice.cell == baseline.cell
    assert choice.details["fallback"] == "invalid answers"
    assert choice.memory.rule == baseline.memory
    assert len(choice.attempts) == 6


def test_failures_of_the_network_are_no_answers_and_are_not_asked_again() -> None:
    for failure, rows in (("timeout", 1), ("paused", 0), ("budget used up", 0)):
        asked, choice = hold(Llm(), view_of(), [Reply(failure=failure)])
        assert len(asked) == 1
        assert choice.details["fallback"] == failure
        assert len(choice.attempts) == rows


def test_plain_repetition_for_the_paper_to_the_letter() -> None:
    view = view_of()
    asked, _ = hold(Llm(prompt="paper-literal"), view, [say("40,3"), say(named(view, 0))])
    assert asked[1].messages == asked[0].messages
    assert asked[1] != asked[0], "the attempt's number is part of the request"


def test_during_the_warm_up_nobody_is_asked() -> None:
    for name in ("llm", "llm-shortlist"):
        asked, choice = hold(make_selector(name), view_of(step=20), [])
        assert asked == []
        assert choice.details["warm_up"] is True
        with pytest.raises(AssertionError, match="not over"):
            hold(make_selector(name), view_of(step=21), [])


def test_one_candidate_is_not_a_question() -> None:
    labels = np.zeros((20, 20), dtype=np.uint8)
    labels[3:15, 3:17] = OCCUPIED
    labels[8, 8] = labels[8, 9] = FREE
    labels[7, 9] = 0
    view = leader_view(labels, (8, 8), step=30)
    for selector in (Llm(encoding="clusters"), LlmShortlist()):
        asked, choice = hold(selector, view, [])
        assert asked == []
        assert tuple(choice.cell) in {tuple(cell) for cell in view.frontiers.tolist()}
        assert choice.details["shown"] == 1
        assert "fallback" not in choice.details


def test_shuffling_can_be_undone() -> None:
    view = view_of()
    asked, choice = hold(Llm(encoding="frontiers", shuffle=True), view, [say(named(view, 5))])
    shown = asked[0].schema["properties"]["choice"]["enum"]
    assert sorted(shown) == sorted(named(view, k) for k in range(len(view.frontiers)))
    assert shown != [named(view, k) for k in range(len(view.frontiers))]
    assert shown[choice.details["place"] - 1] == named(view, 5)
    again, _ = hold(Llm(encoding="frontiers", shuffle=True), view_of(), [say(named(view, 5))])
    assert again == asked
    other = view_of(step=31)
    later, _ = hold(Llm(encoding="frontiers", shuffle=True), other, [say(named(other, 5))])
    assert later[0].schema["properties"]["choice"]["enum"] != shown


def test_a_leader_remembers_its_last_decisions_and_what_became_of_them() -> None:
    view = view_of()
    selector = Llm(history=2)
    _, first = hold(selector, view, [say(named(view, 5), "open ground")])
    assert first.memory.past == ((30, tuple(first.cell), "open ground", ""),)
    # Since then the cell was explored on the way.
    before = Remembered(None, ((30, (7, 7), "open ground", ""),))
    later = view_of(step=40, previous=(7, 7))
    asked, second = hold(selector, later, [say(named(later, 3))], before)
    assert "\nstep 30: (7,7) because open ground: explored before you came there\n" in (
        asked[0].messages[1].text
    )
    third, _ = hold(selector, view_of(step=50), [say(named(view, 3))], second.memory)
    assert third[0].messages[1].text.count("\nstep ") == 2
    nothing, _ = hold(Llm(), later, [say(named(later, 3))], before)
    assert "last decisions" not in nothing[0].messages[1].text


def test_a_shortlist_is_what_the_rule_ranks_best_in_random_order() -> None:
    rule = make_selector(RECOMMENDED)
    for situation in situations(1):
        view = situation.view
        best = best_of(rule, view, None, 5, 2.0)
        assert best[0].cell == rule.choose(view, None).cell
        points = [view.frame.centre_of(*choice.cell) for choice in best]
        apart = [np.hypot(a[0] - b[0], a[1] - b[1]) for a in points for b in points if a != b]
        assert all(d >= 2.0 for d in apart)
        assert 1 <= len(best) <= 5
    view = view_of()
    nearest = best_of(make_selector("nearest-euclidean"), view, None, 5, 0.0)
    by_hand = np.argsort(view.distances_m, kind="stable")[:5]
    assert [tuple(c.cell) for c in nearest] == [tuple(view.frontiers[k].tolist()) for k in by_hand]


def test_a_shortlist_may_be_chosen_from_and_nothing_else() -> None:
    view = view_of()
    asked, choice = hold(LlmShortlist(), view, [say("B")])
    assert asked[0].schema["properties"]["choice"]["enum"] == ["A", "B", "C", "D", "E"]
    assert choice.details["place"] == 2
    best = {tuple(c.cell) for c in best_of(make_selector(RECOMMENDED), view, None, 5, 2.0)}
    assert tuple(choice.cell) in best
    other = next(k for k in range(len(view.frontiers)) if tuple(view.frontiers[k]) not in best)
    _, refused = hold(LlmShortlist(), view, [say(named(view, other)), say("F"), say("A")])
    assert [a.verdict for a in refused.attempts] == ["no candidate", "unknown id", "valid"]


def test_the_control_picks_among_the_same() -> None:
    rule = make_selector(RECOMMENDED)
    places = []
    for seed in range(40):
        view = view_of(seed=seed)
        best = [tuple(c.cell) for c in best_of(rule, view, None, 5, 2.0)]
        choice = ShortlistRandom().choose(view, None)
        places.append(best.index(tuple(choice.cell)))
        _, made = hold(LlmShortlist(), view_of(seed=seed), [say("A")])
        assert tuple(made.cell) == tuple(choice.cell), "the first that a model is shown"
    assert set(places) == {0, 1, 2, 3, 4}


@pytest.mark.parametrize("name", sorted(model_selectors()))
def test_selectors_are_sound(name: str) -> None:
    check_selector(name, missions=1)


@pytest.mark.parametrize(
    ("name", "same"), [("llm", "quantile"), ("llm-shortlist", "multi-criteria")]
)
def test_a_model_that_never_answers_leaves_the_mission_to_the_rule(name: str, same: str) -> None:
    """Bit for bit, whether it fails at once or answers nonsense six times."""

    def state(selector: str, reply: Reply | None) -> tuple[Any, Mission]:
        mission = Mission(Scenario(robots=8, steps=60, destinations=same), world=small_world(4))
        mission.destinations.selector = make_selector(selector)
        if reply is not None:
            mission.destinations.ask = lambda step, asked: [reply] * len(asked)
        mission.run()
        told = [mission.bodies.pose, mission.minds.own, mission.minds.avoided]
        return [fingerprint(x) for x in (*told, mission.swarm.evidence)], mission

    expected, _ = state(same, None)
    for reply in (Reply(failure="timeout"), Reply(text="nonsense"), Reply(failure="paused")):
        found, mission = state(name, reply)
        assert found == expected
        figures = mission.destinations.summary()
        assert figures["by_model"] == 0
        assert sum(figures["fallbacks"].values()) == figures["asked"] > 0
