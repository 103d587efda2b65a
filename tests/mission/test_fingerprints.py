"""Whole missions do what they did, bit for bit, when their fingerprints were taken."""

from __future__ import annotations

import json

import pytest
from fingerprints import FILE, cases, fingerprint_of

from swarmscout.mission.mission import RULES_VERSION

KEPT = json.loads(FILE.read_text(encoding="utf-8"))
CASES = cases()


def test_the_fingerprints_are_of_these_rules() -> None:
    assert KEPT["rules_version"] == RULES_VERSION, "run python tests/mission/fingerprints.py"
    assert list(KEPT["missions"]) == list(CASES)


@pytest.mark.parametrize("name", CASES)
def test_a_mission_is_the_same_bit_for_bit(name: str) -> None:
    assert fingerprint_of(CASES[name]) == KEPT["missions"][name]
