"""Charge stays within its bounds, is spent step by step, and is refilled near stations only."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from swarmscout.core.enums import STRANDED
from swarmscout.core.events import EventLog
from swarmscout.robots.battery import CHARGER, spend_or_charge
from swarmscout.robots.bodies import CAPABILITIES


@given(
    seed=st.integers(0, 2**32 - 1),
    stations=st.integers(0, 3),
    capacity=st.sampled_from([1.0, 5.0, 7.5, 20.0]),
    per_step=st.sampled_from([0.5, 1.0, 10.0]),
)
def test_charge_follows_its_definition(
    seed: int, stations: int, capacity: float, per_step: float
) -> None:
    rng = np.random.default_rng(seed)
    robots, reach = 6, 1.5
    places = rng.uniform(0.0, 5.0, (stations, 2))
    charge = rng.uniform(0.0, capacity, robots)
    whole = rng.random(robots) < 0.5
    charge[whole] = np.ceil(charge[whole])
    alive = np.ones(robots, dtype=np.bool_)
    alive[0] = False
    charge[0] = 0.0
    can = np.ones(robots, dtype=CAPABILITIES)
    charger = np.array([(capacity, per_step, reach)], dtype=CHARGER)
    log = EventLog(robots)
    for _ in range(30):
        position = rng.uniform(0.0, 5.0, (robots, 2))
        docking = rng.random(robots) < 0.4
        before, lived = charge.copy(), alive.copy()
        log.clear()
        spend_or_charge(position, charge, alive, can, docking, places, charger, log.rows)
        stranded = []
        for i in range(robots):
            near = any(np.hypot(*(position[i] - place)) <= reach for place in places)
            if not lived[i]:
                expected = before[i]
            elif docking[i] and near:
                expected = min(capacity, before[i] + per_step)
            else:
                expected = max(0.0, before[i] - 1.0)
                if expected == 0.0:
                    stranded.append(i)
            assert charge[i] == expected
        assert ((charge >= 0.0) & (charge <= capacity)).all()
        assert np.array_equal(lived & ~alive, np.isin(np.arange(robots), stranded))
        assert not (alive & ~lived).any()
        for i in stranded:
            assert can[i].tolist() == (False, False, False, True, False), "it can only hear"
        assert log.entries.tolist() == [[STRANDED, i, -1, -1] for i in stranded]
