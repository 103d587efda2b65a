"""Answers are read strictly on meaning and forgivingly on form, and never guessed."""

from __future__ import annotations

import json

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from swarmscout.destinations.llm.parse import Answer, InvalidAnswer, read_answer

GOOD = [
    '{"choice": "12,34", "reason": "near"}',
    'Sure! Here it is: {"choice": "12,34", "reason": "near"} Hope that helps.',
    '```json\n{"choice": "12,34", "reason": "near"}\n```',
    '```\n{"choice": [12, 34], "reason": "near"}\n```',
    '<think>Is it (3,4)? {"choice": "3,4"}</think>{"choice": "(12, 34)", "reason": "near"}',
    'I wonder about 3,4 …</think>\n{"choice": "12, 34", "reason": "near"}',
    '{"choice": (12, 34), "reason": "near"}',
    '{"choice": [12, 34}, "reason": "near"]',
    '{"choice": {"x": 12, "y": 34}, "reason": "near"}',
    '{"choice": {"y": 34, "x": 12}, "reason": "near"}',
    '{"Choice": "x=12, y=34", "reason": "near"}',
    '{"choice": ["12,34"], "reason": "near",}',
    '{"candidates": [{"id": "3,4", "for": "a {b}", "against": "c"}], "choice": "12,34", '
    '"reason": "near"}',
    '{"destination": [12.0, 34.0], "reason": "near"}',
    '{"choice": "12,34", "reason": "near"}\n{"choice": [12,34], "reason": "again"}',
    '{"x": 12, "y": 34, "reason": "near"}',
]


@pytest.mark.parametrize("text", GOOD)
def test_forms_that_mean_one_cell(text: str) -> None:
    assert read_answer(text) == Answer((12, 34), reason="near")


@pytest.mark.parametrize(
    "text",
    ["12,34", "(12, 34)", "[12,34].", '"12,34"', "**12,34**", "Choice: (12, 34)", "x=12, y=34"],
)
def test_a_cell_and_nothing_else(text: str) -> None:
    assert read_answer(text) == Answer((12, 34))


@pytest.mark.parametrize(
    "text",
    ["B", "b", "B.", "candidate B", '{"choice": "B"}', '{"choice": "id: b"}', "Final answer: B"],
)
def test_ids(text: str) -> None:
    assert read_answer(text) == Answer(None, "B")
    assert read_answer(text.replace("B", "C12").replace("b", "c12")) == Answer(None, "C12")


BAD = [
    ("", "empty"),
    (" \n\t", "empty"),
    ("```json\n```", "empty"),
    ("<think>hm</think>", "empty"),
    ("<think>hm, 12,34", "cut off"),
    ('{"choice": "12,34", "reason": "because it', "cut off"),
    ('{"candidates": [{"id": "3,4", "for": "a"', "cut off"),
    ("7", "bare number"),
    ('{"choice": 7}', "bare number"),
    ('{"choice": "7"}', "bare number"),
    ('{"choice": [7]}', "bare number"),
    ("I'm sorry, but I can't help with that.", "refusal"),
    ("As an AI I cannot drive robots.", "refusal"),
    ("I choose the cell 12,34 because it is near.", "no answer"),
    ("We should avoid (12, 34).", "no answer"),
    ("12,34 or 13,34", "no answer"),
    ("hm", "no answer"),
    ('{"choice": "12,34"} or rather {"choice": "13,34"}', "several answers"),
    ('{"choice": "12,34", "choice": "13,34"}', "several answers"),
    ('{"choice": [[12,34],[13,34]]}', "several answers"),
    ('{"choice": ["12,34","13,34"]}', "several answers"),
    ('{"choice": "12,34 or 13,34"}', "several answers"),
    ("Choice: 12,34\nChoice: 13,34", "several answers"),
    ('{"destination": "12,34", "target": "13,34"}', "several answers"),
    ('{"reason": "near"}', "no choice"),
    ('{"choice": null}', "no choice"),
    ('{"choice": ""}', "no choice"),
    ('{"choice": true}', "no choice"),
    ('{"choice": [12.5, 34]}', "no choice"),
    ('{"choice": [12, 34, 1]}', "no choice"),
    ('{"choice": {}}', "no choice"),
    ('{"choice": "the nearest one"}', "no choice"),
    ('{"choice": "<frontier>", "reason": "<why>"}', "placeholder"),
    ('{"choice": "12,34" "reason": x}', "malformed JSON"),
]


@pytest.mark.parametrize(("text", "name"), BAD)
def test_what_is_no_answer_has_a_name(text: str, name: str) -> None:
    with pytest.raises(InvalidAnswer) as caught:
        read_answer(text)
    assert caught.value.name == name
    assert caught.value.problem


@pytest.mark.parametrize(("finish", "name"), [("length", "cut off"), ("filter", "refusal")])
def test_the_end_counts_more_than_the_words(finish: str, name: str) -> None:
    with pytest.raises(InvalidAnswer) as caught:
        read_answer('{"choice": "12,34"}', finish)
    assert caught.value.name == name


coordinates = st.tuples(st.integers(-5, 999), st.integers(-5, 999))
harmless = st.text(alphabet="abc .,!?\n", max_size=30)


@given(coordinates, harmless, harmless, st.sampled_from(["{}", "[]", "()"]), st.booleans())
def test_prose_and_brackets_do_not_change_what_is_meant(point, before, after, brackets, fence):
    x, y = point
    inner = f"{brackets[0]}{x}, {y}{brackets[1]}" if brackets != "{}" else f'"{x},{y}"'
    body = f'{{"choice": {inner}, "reason": "r"}}'
    text = f"{before}\n```json\n{body}\n```\n{after}" if fence else f"{before}{body}{after}"
    assert read_answer(text).point == point


def answer_or_name(text: str) -> None:
    try:
        answer = read_answer(text)
    except InvalidAnswer as invalid:
        told = invalid.name
    else:
        told = str(answer.point or answer.id)
    assert told


@given(st.text(max_size=200))
@example('{"choice": ' * 500)
@example("[" * 5000 + "{")
@example('{"choice": "\\')
def test_any_text_gives_an_answer_or_a_name(text: str) -> None:
    answer_or_name(text)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["choice", "x", "y", "id", "reason"]), inner, max_size=3)
    ),
    max_leaves=6,
)


@given(json_values)
def test_any_json_gives_an_answer_or_a_name(value) -> None:
    answer_or_name(json.dumps(value))


@given(coordinates, st.integers(1, 40))
def test_a_cut_never_becomes_another_choice(point, cut):
    """However a constrained answer is cut off, it is never read as something else."""
    whole = json.dumps({"choice": f"{point[0]},{point[1]}", "reason": "it is near and open"})
    text = whole[: max(1, len(whole) - cut)]
    try:
        answer = read_answer(text)
    except InvalidAnswer:
        return
    assert answer.point == point
