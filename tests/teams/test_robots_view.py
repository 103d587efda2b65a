"""What robots' view shows is what each knows, against plain loops."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmscout.core.enums import CHARGE
from swarmscout.mission.mission import Mission
from swarmscout.teams.robots_view import RobotsView
from swarmscout.testing.small_worlds import short_mission


def view_of(mission: Mission) -> RobotsView:
    return RobotsView(mission.minds, mission.knowledge, mission.step_number, 5, 5)


def heard_now(mission: Mission, i: int) -> list[tuple[int, bool, float]]:
    """Of each other robot that i hears: who it is, whether a stranger, how far away."""
    minds = mission.minds
    heard = mission.knowledge.heard[mission.knowledge.ear[i]]
    found = []
    for j in range(len(minds)):
        if j != i and heard["step"][j] == mission.step_number:
            distance_m = math.dist((heard["x_m"][j], heard["y_m"][j]), minds.position_m[i])
            found.append((j, bool(heard["team"][j] != heard["team"][i]), distance_m))
    return found


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 3),
    steps=st.sampled_from([1, 5, 30, 60]),
    own_maps=st.booleans(),
    reach_m=st.floats(0.0, 30.0),
)
def test_against_plain_loops(seed: int, steps: int, own_maps: bool, reach_m: float) -> None:
    mission = short_mission(seed, own_maps=own_maps)
    for _ in range(steps):
        mission.step()
    view, minds = view_of(mission), mission.minds
    assert len(view) == len(minds) == 8
    for i in range(8):
        others = heard_now(mission, i)
        near = [(j, stranger) for j, stranger, distance_m in others if distance_m <= reach_m]
        assert view.robots_within(reach_m)[i] == len(near)
        assert view.strangers_within(reach_m)[i] == sum(stranger for _, stranger in near)
        strangers = [distance_m for _, stranger, distance_m in others if stranger]
        assert view.nearest_stranger_m[i] == pytest.approx(min(strangers, default=math.inf))
        cells = mission.map_of(i).frontiers()
        assert view.frontiers[i] == len(cells)
        centres = mission.frame.centres_of(cells).reshape(-1, 2)
        far_m = np.hypot(*(centres - minds.position_m[i]).T)
        # A cell that lies at the very reach may count or not.
        assert (far_m < reach_m - 1e-9).sum() <= view.frontiers_within(reach_m)[i]
        assert view.frontiers_within(reach_m)[i] <= (far_m <= reach_m + 1e-9).sum()
        heard = mission.knowledge.heard[mission.knowledge.ear[i]]
        lead = [j for j in range(8) if heard["step"][j] >= 0 and heard["leader"][j] == j]
        assert view.teams[i] == sum(heard["mode"][j] != CHARGE for j in lead)
        assert view.leads[i] == (minds.leader[i] == i)
        assert view.exploring[i] == (minds.mode[i] != CHARGE)
    assert view.robot.tolist() == list(range(8))
    assert view.previous.tolist() == minds.desired.tolist()
    np.testing.assert_array_equal(view.charge, minds.own["charge"])
    np.testing.assert_array_equal(view.position_m, minds.position_m)


def test_all_of_it_is_read_only_and_worked_out_once() -> None:
    mission = short_mission(0)
    mission.step()
    view = view_of(mission)
    names = [name for name in dir(RobotsView) if not name.startswith("_")]
    arrays = [value for name in names if isinstance(value := getattr(view, name), np.ndarray)]
    arrays += [view.frontiers_within(3.0), view.robots_within(3.0), view.strangers_within(3.0)]
    assert len(arrays) == 13
    for array in arrays:
        assert len(array) == 8
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    mission.minds.own["desired"][0] = 3  # Minds themselves stay writable.
    assert view.frontiers_within(3.0) is view.frontiers_within(3.0)
    assert view.robots_within(3.0) is view.robots_within(3.0)
    with pytest.raises(AttributeError, match="no setter"):
        view.step = 3  # type: ignore[misc]
