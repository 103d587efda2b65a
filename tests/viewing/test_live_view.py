"""A running mission on the page: complete, for late and for slow clients."""

from __future__ import annotations

import gzip
import socket
import threading

import numpy as np
import pytest
from conftest import HANG_S, wait_until
from test_packets import read

from swarmscout import Mission, Scenario, record_mission
from swarmscout.viewing.player import server as serving
from swarmscout.viewing.player.live import LiveMission
from swarmscout.viewing.player.recorded import player_data
from swarmscout.viewing.player.server import PlayerServer

SCENARIO = Scenario(world="lava-tube-small", robots=8, steps=60, seed=2, destinations="nearest")


def alike(a, b):
    """Whether two packets say the same."""
    return a[0] == b[0] and all((a[1][name] == b[1][name]).all() for name in a[1])


def test_what_is_seen_live_is_what_is_recorded(tmp_path):
    live = LiveMission()
    run = record_mission(SCENARIO, out=tmp_path / "r", watchers=[live])
    _, seen = read(gzip.decompress(live.data()))
    _, recorded = read(gzip.decompress(player_data(run)))
    assert alike(seen, recorded)
    assert live.ending()["summary"] == run.summary


def test_news_follow_on_whatever_one_has():
    live = LiveMission()
    Mission(SCENARIO, recorder=live).run()
    whole, _ = live.news(0, 0.0)
    ((facts, arrays),) = read(whole)
    assert facts["steps"] == 61
    x = np.cumsum(np.vstack([arrays["x_m.first"], arrays["x_m.rest"].reshape(-1, 8)]), axis=0)
    for first in (0, 1, 37, 60):
        packet, after = live.news(first, 0.0)
        ((facts, arrays),) = read(packet)
        assert (facts["first"], facts["steps"], after) == (first, 61 - first, 61)
        assert (arrays["x_m.first"] == x[first]).all()
    assert live.news(61, 0.0) == (b"", 61)


def test_a_page_follows_a_running_mission(watched):
    live = LiveMission("running")
    mission = Mission(SCENARIO, recorder=live)
    for _ in range(10):
        mission.step()
    with PlayerServer([live], port=0) as server:
        seen = watched()
        page = seen.open(server.url)
        seen.until("player.clock.step === 10")
        for _ in range(10):
            mission.step()
        seen.until("player.clock.step === 20")
        page.evaluate("player.draw()")
        shown = np.array(page.evaluate("player.scenes[0].shownPositions()"))
        assert np.abs(shown - mission.bodies.position).max() < 0.0006
        labels = np.array(page.evaluate("[...player.mission.labels]"))
        assert (labels == mission.map.labels.ravel()).all()

        page.keyboard.press("Home")  # A page at an earlier step stays there …
        mission.step()
        seen.until("player.mission.steps === 22")
        assert page.evaluate("player.clock.step") == 0
        page.keyboard.press("l")  # … until it goes to the newest step.
        late = watched()
        late.open(server.url)
        late.until("player.clock.step === 21")
        mission.run()
        for one in (seen, late):
            one.until("document.getElementById('state').textContent.startsWith('finished')")
            assert one.page.evaluate("[player.mission.steps, player.clock.step]") == [61, 60]
            assert one.troubles == []
            assert one.foreign == []


@pytest.mark.parametrize("limit_s", [HANG_S, 0.5])
def test_a_client_that_stops_reading_does_not_stall_the_mission(monkeypatch, limit_s):
    monkeypatch.setattr(serving._Handler, "timeout", limit_s)
    monkeypatch.setattr(serving, "SECONDS_BETWEEN_NEWS", 0.0)
    live = LiveMission()
    robots = 200
    with PlayerServer([live], port=0) as server:
        server._server.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        port = int(server.url.rstrip("/").rpartition(":")[2])
        stalled = socket.create_connection(("127.0.0.1", port))
        stalled.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        stalled.sendall(b"GET /run/0/live?from=0 HTTP/1.1\r\nHost: localhost\r\n\r\n")
        scenario = Scenario(robots=robots, steps=100, world="lava-tube-wide", start="spread")
        mission = Mission(scenario, recorder=live)
        wait_until(lambda: any("process_request" in one.name for one in threading.enumerate()))
        handlers = [thread for thread in threading.enumerate() if "process_request" in thread.name]
        mission.run()
        assert len(live.news(0, 0.0)[0]) > 100_000
        if limit_s == HANG_S:
            # The mission is over, and the client still takes nothing: it was not waited for.
            assert all(thread.is_alive() for thread in handlers)
        else:
            wait_until(lambda: not any(thread.is_alive() for thread in handlers))
        stalled.close()


def test_a_mission_that_breaks_off_says_so():
    live = LiveMission()
    mission = Mission(SCENARIO, recorder=live)
    mission.step()
    waiting = threading.Timer(0.1, live.broken_off)
    waiting.start()
    assert live.news(2, HANG_S) == (b"", 2)
    assert live.ending() == {"finished": False, "end_reason": "broken off"}
    waiting.join()


def test_recorders_take_steps_in_their_order(tmp_path):
    order = []

    class Watcher:
        def begin(self, mission):
            order.append("begin")

        def record(self, record):
            order.append(record.step)

        def end(self, summary):
            order.append("end")

    record_mission(SCENARIO.model_copy(update={"steps": 3}), watchers=[Watcher()])
    assert order == ["begin", 0, 1, 2, 3, "end"]


IN_SIGHT = """() => {
    player.draw();
    return [...player.maps, ...player.scenes].every((view) => player.now.robots.every((robot) => {
        const [x, y] = view.toPixels(robot.x, robot.y);
        return x > 0 && y > 0 && x < view.sheet.width && y < view.sheet.height;
    }));
}"""


def test_the_view_of_a_running_mission_follows_the_swarm(watched):
    live = LiveMission("running")
    mission = Mission(SCENARIO.model_copy(update={"steps": 120}), recorder=live)
    mission.step()
    with PlayerServer([live], port=0) as server:
        seen = watched()
        page = seen.open(server.url)
        first = page.evaluate("player.fitted")
        mission.run()
        seen.until("player.mission.steps === 121")
        # News that come fast share a look at the view: the end is one of its own.
        seen.until("document.getElementById('state').textContent.startsWith('finished')")
        assert page.evaluate(IN_SIGHT)
        last = page.evaluate("player.fitted")
        assert last[2] - last[0] > first[2] - first[0] + 2.0
        page.evaluate("player.maps[0].moved = { x: 0, y: 0, scale: 5 }; player.keepSwarmInView()")
        assert page.evaluate("player.maps[0].moved.scale") == 5  # A view moved by hand stays.
