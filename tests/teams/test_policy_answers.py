"""Every policy answers what it answered before, and each term of its rule has its effect."""

from __future__ import annotations

import numpy as np
import pytest

from swarmscout.core.enums import FREE, UNKNOWN
from swarmscout.teams.by_crowd import ByCrowd
from swarmscout.teams.by_mode import ByMode
from swarmscout.teams.registry import POLICIES, make_policy
from swarmscout.teams.robots_view import RobotsView
from swarmscout.testing import robots_view

# A crowd, a pair 5 m to the right of it, and one robot that is far from all, in cells of 0.5 m.
PLACES = [(5, 5), (5, 6), (6, 5), (6, 6), (4, 5), (4, 6), (5, 20), (5, 22), (30, 38)]
GOLDEN = {"by-mode": [5] * 9, "by-crowd": [2, 2, 2, 2, 2, 2, 1, 1, 1]}


def swarm(places: list[tuple[int, int]] = PLACES, desired_size: int = 5) -> RobotsView:
    labels = np.full((36, 40), FREE, dtype=np.uint8)
    labels[0, :] = UNKNOWN
    return robots_view(labels, places, charging=(1,), desired_size=desired_size)


def line(*gaps: int) -> RobotsView:
    """Robots in a row with these gaps, in cells."""
    columns = np.cumsum([2, *gaps]).tolist()
    return swarm([(5, column) for column in columns])


@pytest.mark.parametrize("name", sorted(POLICIES.built_in))
def test_answers_are_those_kept(name: str) -> None:
    assert make_policy(name).desired(swarm()).tolist() == GOLDEN[name]


def test_by_mode_answers_the_scenarios_desired_size() -> None:
    for size in (1, 3, 7):
        assert ByMode().desired(swarm(desired_size=size)).tolist() == [size] * 9


def test_by_crowd_desires_one_more_for_each_group_of_robots_within_reach() -> None:
    # Robot 0 has 6 others within 3 m (6 cells), and itself does not count.
    view = line(1, 1, 1, 1, 1, 1, 1)
    assert view.robots_within(3.0)[0] == 6
    assert ByCrowd(reach_m=3.0, per=3).desired(view)[0] == 3
    assert ByCrowd(reach_m=3.0, per=2).desired(view)[0] == 4
    assert ByCrowd(reach_m=3.0, per=6).desired(view)[0] == 2
    assert ByCrowd(reach_m=3.0, per=7).desired(view)[0] == 1
    assert ByCrowd(reach_m=1.0, per=2).desired(view)[0] == 2
    assert ByCrowd(reach_m=0.4, per=1).desired(view)[0] == 1


def test_by_crowd_desires_no_more_than_the_scenarios_desired_size() -> None:
    for most in (1, 2, 4):
        sizes = ByCrowd(reach_m=3.0, per=1).desired(swarm(desired_size=most))
        assert sizes.tolist() == [most] * 6 + [min(most, 2)] * 2 + [1]


def test_a_view_can_be_made_up() -> None:
    labels = np.full((6, 12), FREE, dtype=np.uint8)
    labels[:, 11] = UNKNOWN
    view = robots_view(labels, [(2, 2), (2, 4), (3, 9)], teams=[0, 0, 2], charging=[2], step=7)
    assert view.step == 7
    assert view.team_size.tolist() == [2, 2, 1]
    assert view.leads.tolist() == [True, False, True]
    assert view.exploring.tolist() == [True, True, False]
    assert view.strangers_within(3.0).tolist() == [0, 1, 1]
    assert view.frontiers.tolist() == [6, 6, 6]
