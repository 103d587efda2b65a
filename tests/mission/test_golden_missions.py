"""Whole missions explore as much as they did when the numbers beside this file were made."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from golden import FILE, SEEDS_MADE, SEEDS_TESTED, areas, cases

from swarmscout.mission.mission import RULES_VERSION

GOLDEN = json.loads(FILE.read_text(encoding="utf-8"))


def test_the_numbers_are_of_these_rules() -> None:
    assert GOLDEN["rules_version"] == RULES_VERSION, "run python tests/mission/golden.py"
    assert set(GOLDEN["missions"]) == {name for name, _ in cases()}


@pytest.mark.parametrize(("name", "case"), cases(), ids=[name for name, _ in cases()])
def test_missions_explore_as_much_as_ever(name: str, case: dict[str, Any]) -> None:
    expected = GOLDEN["missions"][name]
    # The seeds that are run here are among those that made the numbers.
    spread = expected["sd_m2"] * math.sqrt(1 / SEEDS_TESTED - 1 / SEEDS_MADE)
    mean = float(np.mean(areas(case, SEEDS_TESTED)))
    assert mean == pytest.approx(expected["mean_m2"], abs=3.0 * spread)
