"""One robot's own map: what is shown is what that robot knew."""

from __future__ import annotations

import gzip
from typing import Any

import numpy as np
import pytest
from test_packets import read

from swarmscout import Mission, Run, RunError, Scenario, record_mission
from swarmscout.core.errors import ViewError
from swarmscout.viewing.map_image import labels_at
from swarmscout.viewing.mission_figures.catalogue import make_figures
from swarmscout.viewing.mission_figures.maps import team_map
from swarmscout.viewing.player.beliefs import chosen_robots, packed_beliefs
from swarmscout.viewing.player.export import export_page
from swarmscout.viewing.player.live import LiveMission
from swarmscout.viewing.player.recorded import player_data
from swarmscout.viewing.player.server import PlayerServer, Recorded
from swarmscout.viewing.replay import Replay

ROBOTS = 6
SCENARIO = Scenario(
    world="lava-tube-small", robots=ROBOTS, steps=60, seed=4, destinations="nearest"
)


def links(step: int) -> np.ndarray:
    """Neighbours in a row hear each other now and then, in one direction."""
    return np.eye(ROBOTS, k=step % 3 - 1, dtype=bool) & (step % 7 < 3)


@pytest.fixture(scope="module")
def apart(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return record_mission(SCENARIO, out=tmp_path_factory.mktemp("runs") / "apart", links=links)


def shown(page: Any, frame: Any) -> np.ndarray:
    page.evaluate("player.draw()")
    return np.array(page.evaluate("[...player.mission.labels]")).reshape(frame.shape)


def assert_shows_own_maps(seen: Any, run: Run) -> None:
    page = seen.page
    note = "document.querySelector('#maps .whose').textContent"
    assert page.evaluate(note) == "all maps together"
    assert page.locator("#own").is_visible()
    assert page.locator("#own").is_disabled()
    np.testing.assert_array_equal(shown(page, run.frame), labels_at(run, 40))
    page.keyboard.press("n")
    page.keyboard.press("o")
    for robot in (0, 1, 2):
        seen.until(f"player.mission.shownMap.robot === {robot}")
        assert page.evaluate(note) == f"the map of robot {robot}"
        for step in (40, 9, run.last_step):
            page.evaluate(f"player.clock.goTo({step})")
            own = labels_at(run, step, robot)
            assert (own != labels_at(run, step)).any(), "a test of nothing"
            np.testing.assert_array_equal(shown(page, run.frame), own)
        page.keyboard.press("n")
    page.keyboard.press("o")
    page.evaluate("player.clock.goTo(40)")
    np.testing.assert_array_equal(shown(page, run.frame), labels_at(run, 40))
    assert page.evaluate(note) == "all maps together"
    assert seen.troubles == []
    assert seen.foreign == []


def test_in_a_replay(apart, watched):
    with PlayerServer([Recorded(player_data(apart), apart)], port=0) as server:
        seen = watched()
        seen.open(f"{server.url}#t=40")
        assert_shows_own_maps(seen, apart)


def test_in_one_file(apart, watched, tmp_path):
    file = export_page([apart], tmp_path / "m.html")
    seen = watched()
    seen.open(f"{file.as_uri()}#t=40")
    assert_shows_own_maps(seen, apart)


def test_a_link_and_a_file_with_some_robots_only(apart, watched, tmp_path):
    file = export_page([apart], tmp_path / "m.html", own_maps="2")
    seen = watched()
    page = seen.open(f"{file.as_uri()}#t=30&robot=2&map=own")
    seen.until("player.mission.shownMap.robot === 2")
    np.testing.assert_array_equal(shown(page, apart.frame), labels_at(apart, 30, 2))
    page.keyboard.press("n")
    seen.until("/no own map/.test(document.querySelector('#maps .whose').textContent)")
    np.testing.assert_array_equal(shown(page, apart.frame), labels_at(apart, 30))
    page.keyboard.press("Escape")
    seen.until("player.draw() || !player.ownMap.on")
    assert page.evaluate("document.querySelector('#maps .whose').textContent") == (
        "all maps together"
    )
    assert seen.troubles == []


def test_while_a_mission_runs(apart, watched):
    live = LiveMission()
    mission = Mission(SCENARIO, recorder=live, links=links)
    for _ in range(20):
        mission.step()
    with PlayerServer([live], port=0) as server:
        seen = watched()
        page = seen.open(f"{server.url}#robot=3&map=own")
        for until in (20, 35, 60):
            while mission.step_number < until:
                mission.step()
            page.evaluate("player.stayAtEnd()")
            seen.until(f"player.mission.shownMap.robot === 3 && player.clock.step === {until}")
            seen.until(f"player.mission.shownMap.steps === {until + 1}")
            labels = shown(page, mission.frame)
            np.testing.assert_array_equal(labels, mission.map_of(3).labels)
        assert seen.troubles == []


def test_live_and_recorded_say_the_same(apart):
    live = LiveMission()
    record_mission(SCENARIO, links=links, watchers=[live])
    recorded = packed_beliefs(apart, range(ROBOTS))
    for robot in range(ROBOTS):
        for packet in (live.belief(robot, 0), Recorded(b"", apart).belief(robot, 0)):
            ((facts, arrays),) = read(gzip.decompress(packet))
            ((known, kept),) = read(gzip.decompress(recorded[robot]))
            assert facts == known
            assert all((arrays[name] == kept[name]).all() for name in kept)
    ((facts, arrays),) = read(gzip.decompress(live.belief(1, 61)))
    assert (facts["steps"], arrays["map.cells"].size) == (0, 0)
    assert live.belief(ROBOTS, 0) is None


def test_where_one_map_serves_all_there_is_no_own_map(run, watched):
    live = LiveMission()
    Mission(SCENARIO, recorder=live).step()
    assert live.belief(0, 0) is None
    assert Recorded(b"", run).belief(0, 0) is None
    with PlayerServer([Recorded(player_data(run), run)], port=0) as server:
        seen = watched()
        page = seen.open(f"{server.url}#t=20&robot=3&map=own")
        assert page.locator("#own").is_hidden()
        assert page.locator(".whose").count() == 0
        assert not page.evaluate("player.ownMap.on")
        assert seen.troubles == []


def test_figures_of_one_robots_map(apart, tmp_path):
    replay = Replay(apart, 2)
    for step in (50, 10, 60):
        np.testing.assert_array_equal(replay.moment(step).labels, labels_at(apart, step, 2))
    assert replay.window() == Replay(apart).window()
    (file,) = make_figures(apart, tmp_path / "own", names=["team-map"], robot=2, dpi=60)
    (whole,) = make_figures(apart, tmp_path / "all", names=["team-map"], dpi=60)
    assert file.read_bytes() != whole.read_bytes()
    axes = team_map(replay, 60).axes[0]
    assert axes.get_title() == "step 60 · the map of robot 2"
    assert (
        axes.images[0].get_array() != team_map(Replay(apart), 60).axes[0].images[0].get_array()
    ).any()
    with pytest.raises(RunError, match="robots 0 to 5"):
        make_figures(apart, tmp_path, robot=6)


def test_whose_maps_a_file_holds(apart, run):
    everybody = list(range(ROBOTS))
    for text, robots in ((None, everybody), ("all", everybody), ("none", []), ("4, 1,4", [1, 4])):
        assert chosen_robots(apart, text) == robots
    assert chosen_robots(run, None) == []
    with pytest.raises(ViewError, match="one map served all"):
        chosen_robots(run, "3")
    with pytest.raises(RunError, match="robots 0 to 5"):
        chosen_robots(apart, "3,6")
    for text in ("some", "1-3", "", "1,,2", "²"):
        with pytest.raises(ViewError, match="all, none, or"):
            chosen_robots(apart, text)
