"""Packets hold what was put in, in the way that the page reads them."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from swarmscout.viewing.player.packets import MAGIC, pack, smallest, with_differences
from swarmscout.viewing.player.page_text import LONGEST_TEXT, page_data


def read(data: bytes) -> list[tuple[dict, dict]]:
    """What page/packets.js does."""
    found = []
    at = 0
    while at < len(data):
        assert data[at : at + 4] == MAGIC
        text, room = struct.unpack_from("<II", data, at + 4)
        facts = json.loads(data[at + 12 : at + 12 + text])
        base = at + 12 + text
        assert base % 8 == 0
        found.append(
            (
                facts,
                {
                    name: np.frombuffer(
                        data, f"<{place['type']}", place["length"], base + place["at"]
                    )
                    for name, place in facts["arrays"].items()
                },
            )
        )
        at = base + room
    return found


tables = arrays(
    np.int64, st.tuples(st.integers(1, 6), st.integers(1, 5)), elements=st.integers(-(2**29), 2**29)
)


@given(table=tables, facts=st.dictionaries(st.text(), st.text(), max_size=3))
def test_tables_come_back(table, facts):
    facts.pop("arrays", None)
    packet = pack(facts, {**with_differences("t", table), "f": np.array([0.5, 7.0])})
    both = read(packet + packet)
    assert len(both) == 2
    for told, packed in both:
        assert {name: value for name, value in told.items() if name != "arrays"} == facts
        rows = [packed["t.first"].astype(np.int64)]
        for row in packed["t.rest"].reshape(-1, table.shape[1]).astype(np.int64):
            rows.append(rows[-1] + row)
        assert (np.array(rows) == table).all()
        assert packed["f"].tolist() == [0.5, 7.0]


@given(arrays(np.int64, st.integers(0, 5), elements=st.integers(-(2**31), 2**31 - 1)))
def test_the_smallest_type_holds_the_numbers(numbers):
    packed = smallest(numbers)
    assert (packed.astype(np.int64) == numbers).all()
    if len(numbers) and numbers.min() >= -128 and numbers.max() < 128:
        assert packed.dtype == np.int8


def test_what_no_type_holds_is_refused():
    with pytest.raises(OverflowError):
        smallest(np.array([2**31]))


def test_long_texts_are_cut_wherever_they_are():
    long = "y" * (LONGEST_TEXT + 1)
    told = page_data({"a": [long, {"b": long}], "n": float("nan"), "k": 3, "s": "short"})
    assert told["n"] is None
    assert (told["k"], told["s"]) == (3, "short")
    for text in (told["a"][0], told["a"][1]["b"]):
        assert text.startswith("yyy")
        assert text.endswith("(20,001 characters, cut)")
