"""Beacons: who hears what, and that silence tells nothing else."""

import numpy as np

from swarmscout.comms.beacons import exchange_beacons
from swarmscout.minds.minds import STEP, blank_minds


def links(*pairs, robots=3):
    matrix = np.zeros((robots, robots), dtype=np.bool_)
    for i, j in pairs:
        matrix[i, j] = matrix[j, i] = True
    return matrix


def test_out_of_range_and_out_of_charge_look_the_same():
    talking, silent = (blank_minds(3, shared=False) for _ in range(2))
    for minds in (talking, silent):
        exchange_beacons(minds, links((0, 1), (0, 2)), 1)
    silent.sending[1] = False
    for step in range(2, 15):
        for minds in (talking, silent):
            exchange_beacons(minds, links((0, 2)), step)
    # Robot 0 lost sight of 1 in both; 2 has never heard it.
    np.testing.assert_array_equal(talking.still[[0, 2]], silent.still[[0, 2]])
    assert silent.still[0, 1] == 13
    assert silent.still[2, 1] == 0
    assert silent.heard_state[2, 1, STEP] == -1


def test_a_beacon_is_heard_along_links_alone():
    minds = blank_minds(3, shared=False)
    minds.reading[:, 0] = [1.0, 2.0, 3.0]
    exchange_beacons(minds, links((0, 1)), 5)
    np.testing.assert_array_equal(minds.heard_state[0, :, STEP], [5, 5, -1])
    np.testing.assert_array_equal(minds.heard_state[2, :, STEP], [-1, -1, 5])
    assert minds.heard_reading[1, 0, 0] == 1.0


def test_who_moves_is_not_still():
    minds = blank_minds(2, shared=True)
    nobody = np.zeros((1, 1), dtype=np.bool_)
    for step in range(1, 5):
        minds.reading[0, 0] += 0.2
        exchange_beacons(minds, nobody, step)
    np.testing.assert_array_equal(minds.still[0], [0, 3])
