"""Beacons: who hears what, and that silence says nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from small_swarm import FRAME, MODEL, Swarm

from swarmscout.core.errors import ScenarioError
from swarmscout.core.links import Links


def links(*pairs: tuple[int, int], robots: int = 3) -> np.ndarray:
    matrix = np.zeros((robots, robots), dtype=np.bool_)
    for i, j in pairs:
        matrix[i, j] = matrix[j, i] = True
    return matrix


def test_out_of_range_and_out_of_charge_look_the_same() -> None:
    talking, silent = Swarm(3, 0), Swarm(3, 0)
    for swarm in (talking, silent):
        swarm.meet(links((0, 1), (0, 2)))
    silent.minds.own["thinks"][1] = silent.minds.own["sends"][1] = False
    for _ in range(13):
        for swarm in (talking, silent):
            swarm.meet(links((0, 2)))
    # Robot 0 lost sight of 1 in both; 2 has never heard it.
    for robot in (0, 2):
        still = [swarm.knowledge.still[swarm.row(robot)] for swarm in (talking, silent)]
        np.testing.assert_array_equal(*still)
    assert silent.knowledge.still[silent.row(0), 1] == 13
    assert silent.knowledge.still[silent.row(2), 1] == 0
    assert silent.heard(2)["step"][1] == -1


def test_a_beacon_is_heard_along_links_alone() -> None:
    swarm = Swarm(3, 0)
    swarm.minds.own["x_m"] = [1.0, 2.0, 3.0]
    swarm.meet(links((0, 1)))
    assert swarm.heard(0)["step"].tolist() == [1, 1, -1]
    assert swarm.heard(2)["step"].tolist() == [-1, -1, 1]
    assert swarm.heard(1)["x_m"][0] == 1.0


def test_a_deaf_robot_hears_itself_and_a_mute_one_is_heard_by_none() -> None:
    swarm = Swarm(3, 0)
    swarm.minds.own["hears"][0] = swarm.minds.own["sends"][1] = False
    swarm.meet(np.ones((3, 3), dtype=np.bool_))
    assert swarm.heard(0)["step"].tolist() == [1, -1, -1]
    assert swarm.heard(1)["step"].tolist() == [1, 1, 1]
    assert swarm.heard(2)["step"].tolist() == [1, -1, 1]


def test_how_long_a_robot_has_stood_is_what_it_says_and_counts_on_in_silence() -> None:
    swarm = Swarm(2, 0)
    swarm.minds.own["still"] = [0, 7]
    swarm.meet(None)
    np.testing.assert_array_equal(swarm.knowledge.still[0], [0, 7])
    swarm.minds.own["sends"][1] = False
    for _ in range(4):
        swarm.meet(None)
    np.testing.assert_array_equal(swarm.knowledge.still[swarm.row(0)], [0, 11])


def test_links_keep_what_a_matrix_says() -> None:
    rng = np.random.default_rng(0)
    for robots in (1, 2, 7):
        matrix = rng.random((robots, robots)) < 0.4
        given = Links.of_matrix(matrix, robots, "links")
        np.fill_diagonal(matrix, True)
        np.testing.assert_array_equal(given.matrix(), matrix)
    assert Links.full(3).matrix().all()


@pytest.mark.parametrize("wrong", [None, np.ones(3), np.ones((2, 3)), [[1], [1, 2]], "links"])
def test_links_of_another_kind_are_named(wrong: object) -> None:
    with pytest.raises(ScenarioError, match=r"links\(4\) returned .*, expected bool\[3, 3\]"):
        Links.of_matrix(wrong, 3, "links(4)")


__all__ = ["FRAME", "MODEL"]
