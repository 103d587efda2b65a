"""What a model is shown: the leader's view, within a token budget."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence

import numpy as np
import pytest

from swarmscout import Mission, Scenario
from swarmscout.core.enums import FREE, OCCUPIED, UNKNOWN
from swarmscout.core.errors import SelectorError
from swarmscout.core.language_model import Reply, Request
from swarmscout.core.tokens import estimate_tokens
from swarmscout.destinations.llm.dialogue import question, schema_of
from swarmscout.destinations.llm.encodings import ENCODINGS
from swarmscout.destinations.llm.fronts import EXTENT_M, pieces_of
from swarmscout.destinations.llm.prompts import load_prompt, named_prompts
from swarmscout.destinations.registry import make_selector
from swarmscout.testing.situations import leader_view, situations

MAP = """
?????????
?...#???.
?....???.
?...#????
?????????
"""
LABELS = np.array(
    [[{"?": UNKNOWN, ".": FREE, "#": OCCUPIED}[sign] for sign in row] for row in MAP.split()],
    dtype=np.uint8,
)


def view_of(**more):
    return leader_view(LABELS, (2, 2), others=(((2, 8), (1, 8)),), **more)


def encoded(name, view, budget=100_000, features="paper"):
    return ENCODINGS[name](view, budget, np.arange(len(view.frontiers)), features)


def test_the_papers_list_of_cells() -> None:
    """Against neighbours counted by hand."""
    view = view_of()
    text = encoded("cells", view).text
    known = int((LABELS != UNKNOWN).sum())
    lines = text.splitlines()
    assert len(lines) == known
    assert all(re.fullmatch(r"\(\(\d+,\d+\),[123],\(\d,\d\),\d+\.\d\)", line) for line in lines)
    # The leader's own cell: amidst nine free cells, eight of them frontiers but one.
    assert lines[lines.index(next(x for x in lines if x.startswith("((2,2)")))].endswith(",0.0)")
    frontiers = {(x, y) for y, x in view.frontiers.tolist()}
    for line in lines:
        x, y, label, f, o, _ = re.findall(r"[\d.]+", line)
        cell = int(x), int(y)
        around = [
            (cell[0] + i, cell[1] + j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)
        ]
        assert int(f) == len(frontiers & set(around))
        assert int(o) == sum(
            LABELS[b, a] == OCCUPIED for a, b in around if 0 <= b < 5 and 0 <= a < 9
        )
        expected = {FREE: 1, OCCUPIED: 2}[int(LABELS[cell[1], cell[0]])]
        assert int(label) == (3 if cell in frontiers else expected)


def test_rows_say_the_whole_map() -> None:
    view = view_of()
    rows = encoded("rows", view).text.split("\n\n")[0]
    drawn = np.full(LABELS.shape, " ")
    for line in rows.splitlines():
        y, _, runs = line.partition(": ")
        for first, last, letter in re.findall(r"(\d+)(?:-(\d+))?([foF])", runs):
            drawn[int(y[2:]), int(first) : int(last or first) + 1] = letter
    assert (drawn != " ").sum() == (LABELS != UNKNOWN).sum()
    assert (drawn == "o").sum() == (LABELS == OCCUPIED).sum()
    assert (drawn == "F").sum() == len(view.frontiers)


def test_the_drawing_has_north_up_and_names_its_columns() -> None:
    view = view_of()
    one = encoded("ascii", view)
    drawing = one.text.split("\n\n")[0].splitlines()
    rows = [int(line[2:6]) for line in drawing]
    assert rows == sorted(rows, reverse=True)
    middle = next(line for line in drawing if line.startswith("y=2 "))
    left = int(re.search(r"x from (\d+)", one.legend).group(1))
    assert middle.split("|")[1].index("L") + left == 2
    assert middle.split("|")[1].index("T") + left == 8


def test_clusters_are_few_and_stand_for_frontiers() -> None:
    view = view_of()
    one = encoded("clusters", view)
    assert [c.id for c in one.candidates] == ["C1", "C2"]
    assert all((view.frontiers == c.cell).all(axis=1).any() for c in one.candidates)


@pytest.mark.parametrize("cell_m", [0.1, 0.25, 0.5, 1.0, 4.0])
def test_a_long_front_is_cut_along_itself(cell_m: float) -> None:
    """A straight front, a ring and a branching one; pieces touch, and none is long."""
    line = [(0, x) for x in range(60)]
    ring = [(r, c) for r in range(10, 40) for c in range(10, 40) if r in (10, 39) or c in (10, 39)]
    tree = [(r, 100) for r in range(40)] + [(20, c) for c in range(80, 120) if c != 100]
    cells = np.array(sorted(line + ring + tree), dtype=np.int64)
    pieces = pieces_of(cells, cell_m)
    assert sorted(set(pieces.tolist())) == list(range(pieces.max() + 1))
    for number in range(pieces.max() + 1):
        part = cells[pieces == number]
        assert np.ptp(part, axis=0).max() * cell_m <= 2 * max(EXTENT_M, cell_m)
    assert (pieces[:60] == np.arange(60) * (pieces[59] + 1) // 60).all(), "equal parts of a line"
    again = pieces_of(cells, cell_m)
    assert (again == pieces).all()


@pytest.mark.slow
def test_a_default_mission_has_several_candidates_to_choose_from() -> None:
    counts: list[int] = []

    def last(step: int, asked: Sequence[tuple[int, Request]]) -> list[Reply]:
        ids = [request.schema["properties"]["choice"]["enum"] for _, request in asked]
        counts.extend(map(len, ids))
        return [Reply(json.dumps({"choice": names[-1], "reason": "far"})) for names in ids]

    mission = Mission(Scenario(steps=150))
    mission.destinations.selector = make_selector("llm", {"encoding": "clusters"})
    mission.destinations.ask = last
    mission.run()
    assert len(counts) > 10
    assert min(counts) > 1, "one candidate is not a question"
    assert np.median(counts) > 3


@pytest.mark.parametrize("name", sorted(ENCODINGS))
@pytest.mark.parametrize("features", ["paper", "full"])
def test_every_situation_and_budget(name: str, features: str) -> None:
    for situation in situations(3):
        view = situation.view
        whole = encoded(name, view, features=features)
        assert whole.dropped == 0
        for budget in (200, 1000):
            part = encoded(name, view, budget, features)
            assert part.candidates, situation.words
            ids = [c.id for c in part.candidates]
            assert len(set(ids)) == len(ids)
            assert all((view.frontiers == c.cell).all(axis=1).any() for c in part.candidates)
            if part.dropped:
                assert estimate_tokens(part.text) <= budget + 60
            else:
                assert part.text == whole.text or name == "ascii"
            assert all(estimate_tokens(p.text) < estimate_tokens(part.text) + 700
                       for p in question(view, part, load_prompt("paper")))  # fmt: skip


def test_free_ground_is_left_out_first_and_frontiers_last() -> None:
    view = next(s.view for s in situations(0) if s.words == "hundreds of frontiers")
    whole = encoded("cells", view)
    labels = {re.split(r"[(),]+", line)[3] for line in whole.text.splitlines()}
    assert labels == {"1", "2", "3"}
    tokens = estimate_tokens(whole.text)
    some = encoded("cells", view, int(tokens * 0.8))
    count = {kind: sum(f"),{kind},(" in line for line in some.text.splitlines()) for kind in "123"}
    assert count["3"] == len(view.frontiers)
    assert count["2"] == int((view.labels == OCCUPIED).sum())
    assert 0 < count["1"] < int((view.labels == FREE).sum()) - len(view.frontiers)


def test_enumerations_keep_to_what_providers_take() -> None:
    view = next(s.view for s in situations(0) if s.words == "hundreds of frontiers")
    one = encoded("frontiers", view)
    assert 250 < len(one.candidates) <= 1000
    assert schema_of(one, brief=True)["properties"]["choice"]["enum"]
    long = type(one)("", "", one.candidates * 4)
    assert "enum" not in schema_of(long, brief=True)["properties"]["choice"]


def test_prompts_that_come_with_the_package() -> None:
    assert named_prompts() == ("paper", "paper-literal", "shortlist")
    view = view_of()
    for name in named_prompts():
        system, user = question(view, encoded("cells", view), load_prompt(name))
        assert (system.role, user.role) == ("system", "user")
        assert "$" not in user.text
    assert "efficient exploration" in user.text
    assert (
        "team of robot 1 at (8,2), going to (8,1)"
        in question(view, encoded("cells", view), load_prompt("paper"))[1].text
    )


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (None, "cannot be read: No such file"),
        ("version = ", "is not valid TOML"),
        ('version = "1"', "'system' is missing or not a text"),
        ("versio = '1'", "unknown key 'versio': did you mean 'version'?"),
        (
            "version='1'\nsystem='s'\nuser='$map $mapp $answer'\nanswer='a'\nretry=''",
            "unknown name '$mapp': did you mean 'map'?",
        ),
        ("version='1'\nsystem='s'\nuser='$map'\nanswer='a'\nretry=''", "it must contain '$answer'"),
        ("version='1'\nsystem='5 $'\nuser='$map $answer'\nanswer='a'\nretry=''", "write $$"),
    ],
)
def test_mistakes_in_prompt_files(tmp_path, text, says) -> None:
    file = tmp_path / "mine.toml"
    if text is not None:
        file.write_text(text)
    with pytest.raises(SelectorError) as caught:
        make_selector("llm", {"prompt": str(file)})
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "parameters", "says"),
    [
        ("llm", {"encoding": "cell"}, "encoding = 'cell' is unknown: did you mean 'cells'?"),
        ("llm", {"features": "ful"}, "did you mean 'full'?"),
        ("llm", {"prompt": "papr"}, "unknown prompt 'papr': did you mean 'paper'?"),
        ("llm", {"retries": -1}, "retries = -1 must be a whole number of at least 0"),
        ("llm", {"baseline": "quantil"}, "did you mean 'quantile'?"),
        ("llm", {"encodin": "cells"}, "no parameter 'encodin': did you mean 'encoding'?"),
        ("llm-shortlist", {"k": 0}, "k = 0 must be a whole number of at least 1"),
        ("llm-shortlist", {"k": 99}, "must be at most 26"),
        ("llm-shortlist", {"rule": "multi-criterium"}, "did you mean 'multi-criteria'?"),
        ("shortlist-random", {"apart_m": -1.0}, "apart_m = -1.0 must be at least 0"),
    ],
)
def test_mistakes_with_parameters(name, parameters, says) -> None:
    with pytest.raises(SelectorError) as caught:
        make_selector(name, parameters)
    assert says in str(caught.value)
