"""Rules that choose for all leaders of a map at once choose what they would one by one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from swarmscout import Mission, Scenario
from swarmscout.core.recorder import Decision
from swarmscout.destinations.multi_criteria import MultiCriteria
from swarmscout.destinations.quantile import Quantile
from swarmscout.destinations.quantile_local import QuantileLocal
from swarmscout.destinations.selector import Selector
from swarmscout.testing import small_world


class OneByOne(MultiCriteria):
    """A rule of a user's own: it is asked with views."""


class QuantileOneByOne(Quantile):
    """The same for the baseline."""


class LocalOneByOne(QuantileLocal):
    """The same for the local baseline."""


def decisions(selector: Selector, seed: int, **keys: Any) -> list[Decision]:
    """All decisions of a mission, and how it went on."""
    flapping = keys.pop("flapping", False)
    rng = np.random.default_rng(seed)

    def links(step: int) -> Any:
        return rng.random((keys["robots"], keys["robots"])) < 0.1

    scenario = Scenario(steps=90, seed=seed, **keys)
    mission = Mission(
        scenario, world=small_world(seed), selector=selector, links=links if flapping else None
    )
    found = []
    while not mission.done:
        mission.step()
        found += [replace(decision, selector="") for decision in mission.decisions]
        assert (mission.minds.own["look_at"] <= mission.step_number + 5).all()
    return found


SETTINGS: dict[str, dict[str, Any]] = {
    "few": {"robots": 3},
    "one place": {"robots": 12},
    "spread": {"robots": 25, "start": "spread"},
    "partial links": {"robots": 10, "start": "spread", "flapping": True},
    "short of charge": {
        "robots": 8,
        "battery": {"capacity_steps": 120, "start_min": 0.3, "return_rule": "distance"},
    },
    "fine cells": {"robots": 6, "map": {"cell_m": 0.1}, "body": {"radius_m": 0.2}},
    "coarse cells": {"robots": 8, "map": {"cell_m": 0.7}},
    "long memory": {"robots": 9, "renewal": {"avoid_steps": 80, "overdue_factor": 1.0}},
    "noisy": {"robots": 9, "body": {"position_noise_m": 0.3, "heading_noise_deg": 5.0}},
}


@pytest.mark.parametrize("name", SETTINGS)
@pytest.mark.parametrize("seed", [1, 2])
def test_criteria(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    weights = {
        "way": rng.uniform(0.0, 1.0),
        "front": rng.uniform(0.0, 1.5),
        "open_m": rng.uniform(0.4, 4.0),
        "wall": rng.uniform(0.0, 8.0),
        "apart": rng.uniform(0.0, 8.0),
        "apart_m": rng.uniform(0.3, 9.0),
        "ahead": rng.uniform(-2.0, 4.0),
    }
    at_once = decisions(MultiCriteria(**weights), seed, **SETTINGS[name])
    assert at_once == decisions(OneByOne(**weights), seed, **SETTINGS[name])
    assert len(at_once) > 5


@pytest.mark.parametrize("name", SETTINGS)
def test_baselines(name: str) -> None:
    assert decisions(Quantile(), 3, **SETTINGS[name]) == decisions(
        QuantileOneByOne(), 3, **SETTINGS[name]
    )
    assert decisions(QuantileLocal(), 4, **SETTINGS[name]) == decisions(
        LocalOneByOne(), 4, **SETTINGS[name]
    )


def test_weights_that_bounds_do_not_hold_for_are_asked_one_by_one() -> None:
    assert MultiCriteria().chooses_in_batches()
    assert not MultiCriteria(way=-0.1).chooses_in_batches()
    assert not OneByOne().chooses_in_batches()
