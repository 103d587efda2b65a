"""A small count of what ``make fuzz-llm`` tries a hundred thousand times."""

from __future__ import annotations

from fuzz import fuzz


def test_nothing_that_a_server_or_a_cassette_says_comes_through() -> None:
    fuzz(1500)
