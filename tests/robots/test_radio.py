"""Radios: who hears whom by where robots are, and what a user's radio may answer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarmscout import Mission, Scenario, ScenarioError
from swarmscout.core.links import Links
from swarmscout.robots.bodies import place_bodies
from swarmscout.robots.radio.disc import Disc
from swarmscout.robots.radio.radio import links_now
from swarmscout.testing import small_world

WORLD = small_world(1)


@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.sampled_from([0.0, 0.5, 3.0, 100.0]))
def test_a_disc_links_exactly_the_pairs_within_range(
    seed: int, robots: int, range_m: float
) -> None:
    places = np.random.default_rng(seed).uniform(0.0, 6.0, (robots, 2)).round(1)
    bodies = place_bodies(places, np.zeros(robots, dtype=np.int64), np.ones(robots))
    away = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    linked = Disc(range_m).links(1, bodies, WORLD).matrix()
    np.testing.assert_array_equal(linked, (away <= range_m) | np.eye(robots, dtype=np.bool_))
    assert Disc(range_m).links(1, bodies, WORLD).complete == bool(linked.all())


def scenario(**radio: Any) -> Scenario:
    keys = {"robots": 6, "steps": 60, "destinations": "multi-criteria", "radio": radio}
    return Scenario.model_validate(keys)


def explored(mission: Mission) -> list[float]:
    mission.run()
    return mission.judge.area_m2


def test_an_endless_disc_is_full_communication_and_an_empty_one_is_silence() -> None:
    full = explored(Mission(scenario(), world=WORLD))
    assert explored(Mission(scenario(model="disc", range_m=1e6), world=WORLD)) == full
    silent = Mission(scenario(), world=WORLD, links=lambda step: np.eye(6, dtype=np.bool_))
    empty = Mission(scenario(model="disc", range_m=0.0), world=WORLD)
    assert explored(empty) == explored(silent) != full
    assert len(empty.knowledge.rows) == 6
    for robot in range(6):
        # Nobody spoke to it: it knows its own evidence, and has heard its own beacons.
        assert (empty.knowledge.heard[empty.knowledge.ear[robot]]["step"] >= 0).sum() == 1


def test_a_radio_from_a_file(tmp_path: Path) -> None:
    (tmp_path / "my.py").write_text(
        "import numpy as np\n"
        "class Late:\n"
        "    def __init__(self, from_step=1):\n"
        "        self.from_step = from_step\n"
        "    def links(self, step, bodies, world):\n"
        "        robots = len(bodies.position)\n"
        "        return np.full((robots, robots), step >= self.from_step)\n"
    )
    radio = {"model": "my.py:Late", "parameters": {"from_step": 30}}
    mission = Mission(scenario(**radio), world=WORLD, base=tmp_path)
    for _ in range(29):
        mission.step()
    assert len(mission.knowledge.rows) == 6
    mission.step()
    assert len({mission.map_of(i).evidence.tobytes() for i in range(6)}) == 1


@pytest.mark.parametrize(
    ("radio", "says"),
    [
        ({"model": "dics"}, "unknown radio 'dics': did you mean 'disc'"),
        ({"model": "disc", "range_m": -1}, "range_m"),
        ({"model": "no.py:Such"}, "radio file 'no.py' does not exist"),
        ({"modle": "disc"}, "unknown key 'radio.modle'"),
    ],
)
def test_what_is_wrong_with_a_radio_is_one_line(radio: dict[str, Any], says: str) -> None:
    with pytest.raises((ScenarioError, ValueError)) as caught:
        Mission(Scenario(radio=radio), world=WORLD)
    assert says in str(caught.value)


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (None, "radio 'mine' in step 3 returned None, expected bool[2, 2]"),
        (np.ones(2), "expected bool[2, 2]"),
        (Links.full(3), "returned links of 3 robots in step 3, expected 2"),
    ],
)
def test_answers_of_another_kind_are_named(answer: Any, says: str) -> None:
    class Mine:
        def links(self, step: int, bodies: Any, world: Any) -> Any:
            return answer

    bodies = place_bodies(np.zeros((2, 2)), np.zeros(2, dtype=np.int64), np.ones(2))
    with pytest.raises(ScenarioError) as caught:
        links_now(Mine(), "mine", 3, bodies, WORLD)
    assert says in str(caught.value)


def test_a_radio_that_fails_is_named() -> None:
    class Fails:
        def links(self, step: int, bodies: Any, world: Any) -> Any:
            raise RuntimeError("static")

    bodies = place_bodies(np.zeros((2, 2)), np.zeros(2, dtype=np.int64), np.ones(2))
    with pytest.raises(ScenarioError, match="radio 'mine' failed in step 3: RuntimeError: static"):
        links_now(Fails(), "mine", 3, bodies, WORLD)
