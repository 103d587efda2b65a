"""Answers are read strictly on meaning and forgivingly on form, and never guessed."""

from __future__ import annotations

import json
import time

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
    "{'choice': '12,34', 'reason': 'near'}",
    "{'choice': (12, 34), 'reason': 'near', 'sure': True, 'other': None}",
    "{“choice”: “12,34”, “reason”: “near”}",
    '{choice: "12,34", reason: "near"}',
    "{choice: 12,34, reason: near}",
    """{"choice": "12,34", "reason": "near", "more": "it\\'s"}""",
    '{{"choice": "12,34", "reason": "near"}}',
    '{"response": {"choice": "12,34", "reason": "near"}}',
    '{"name": "choose", "arguments": {"choice": "12,34", "reason": "near"}}',
    '{"name": "choose", "arguments": "{\\"choice\\": \\"12,34\\", \\"reason\\": \\"near\\"}"}',
    '<tool_call>{"name": "f", "arguments": {"choice": "12,34", "reason": "near"}}</tool_call>',
    '[{"choice": "12,34", "reason": "near"}]',
    '"{\\"choice\\": \\"12,34\\", \\"reason\\": \\"near\\"}"',
    '{"choice": "frontier (12,34)", "reason": "near"}',
    '{"choice": "12,34 (nearest)", "reason": "near"}',
    '{"choice": "12,34 - the nearest", "reason": "near"}',
    '{"choice": "（12，34）", "reason": "near"}',
    '{"choice": "x: 12, y: 34", "reason": "near"}',
    '{"destination": "12,34", "cell": "12,34", "reason": "near"}',
    'Format {choice: x} as asked. {"choice": "12,34", "reason": "near"}',
    'For example {"choice": "1,2"}. Mine: {"choice": "12,34", "reason": "near"}',
    'I\'m sorry for the mistake. {"choice": "12,34", "reason": "near"}',
    '\\text{distance: 3 m} {"choice": "12,34", "reason": "near"}',
    '[THINK]{"choice": "1,2"}?[/THINK]{"choice": "12,34", "reason": "near"}',
    '◁think▷{"choice": "1,2"}?◁/think▷{"choice": "12,34", "reason": "near"}',
    '<|begin_of_thought|>1,2?<|end_of_thought|>{"choice": "12,34", "reason": "near"}',
    '<|channel|>analysis<|message|>{"choice": "1,2"}?<|end|><|start|>assistant<|channel|>final'
    '<|message|>{"choice": "12,34", "reason": "near"}<|return|>',
    '{"choice": "12,34", "reason": "near"}<|im_end|>',
    '{"choice": "12,34" /* x,y */, "reason": "near"}',
    '{"choice": "12,34", // x,y\n"reason": "near"}',
    '｛"choice"："12,34"，"reason"："near"｝',
    '{"decision": "12,34", "reason": "near"}',
    '{"decision": {"choice": "12,34", "reason": "near"}}',
    'Team 4: {"choice": "1,2"}\nMine: {"choice": "12,34", "reason": "near"}',
]


@pytest.mark.parametrize("text", GOOD)
def test_forms_that_mean_one_cell(text: str) -> None:
    assert read_answer(text) == Answer((12, 34), reason="near")


@pytest.mark.parametrize(
    "text",
    [
        "12,34",
        "(12, 34)",
        "[12,34].",
        '"12,34"',
        "**12,34**",
        "Choice: (12, 34)",
        "x=12, y=34",
        "$\\boxed{12,34}$",
        "\\boxed{\\text{12,34}}",
        "**Choice:** 12,34",
        "<answer>12,34</answer>",
        "choice: 12,34\nreason: near",
        "The answer is: 12,34",
        "My choice is 12,34.",
        "Choice → 12,34",
        "1,2 is blocked.\nFinal answer: 12,34",
        '{"id": "1,2", "for": "near", "against": "crowded"}\nChoice: 12,34',
        'I am at {"x": 1, "y": 2}.\nChoice: 12,34',
        'Team 4: {"destination": "1,2"}\nChoice: 12,34',
    ],
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
    ("Team 4's plan\nDestination: 1,2\nMine: 7,8", "several answers"),
    ('Example: {"choice": "1,2"}. I am sorry, I cannot choose.', "refusal"),
    ('{"choice": "1,2"}\nI am sorry, I cannot choose.', "refusal"),
    ('{"choice": "1,2"}\nWait, that is an obstacle.', "several answers"),
    ('{"id": "1,2", "for": "near", "against": "crowded"}', "no choice"),
    ('Not {"choice": "1,2"}.', "no answer"),
    ("Choice: not 1,2", "no choice"),
    ("Choice: 1,2 or 3,4", "several answers"),
    ('{"destination": "5,6"}\nChoice: 1,2 or 3,4', "several answers"),
    ('{"choice": "≠7,8"}', "no choice"),
    ('{"choice": "7,8"} is a bad idea', "no answer"),
    ('{"choice": "7,8"}? No.', "no answer"),
    ('I am at {"x": 1, "y": 2}.', "no answer"),
    ("Choice: 7,8\nNo, wait. I choose 1,2", "several answers"),
    ('{"choice": "no 7,8"}', "no choice"),
    ('{"choice": "7,8?"}', "no choice"),
    ('{"choice": "7,8 (or 9,9)"}', "several answers"),
    ('{"choice": "A nearby frontier"}', "no choice"),
    ('{"choice": "A (not B)"}', "no choice"),
    ('{"choice": "7,8,9"}', "no choice"),
    ("<|channel|>analysis<|message|>hm, 1,2", "cut off"),
    ("[THINK]hm, 1,2", "cut off"),
    *[
        (text.replace("BIG", "8" + "3" * 400), name)
        for text, name in (
            ('{"choice": "BIG,5"}', "no choice"),
            ('{"choice": [BIG, 5]}', "no choice"),
            ('{"x": BIG, "y": 5}', "no choice"),
            ('{"choice": ["BIG", "5"]}', "several answers"),
            ('{"choice": 1e400}', "bare number"),
            ('{"choice": [1e300, 2]}', "no choice"),
            ("BIG,5", "no answer"),
        )
    ],
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


def test_minus_signs_of_all_kinds() -> None:
    for sign in "-−‐‑":
        assert read_answer(f'{{"choice": "{sign}7,8"}}').point == (-7, 8)


def test_a_whole_object_and_blanks_until_the_limit() -> None:
    whole = '{"choice": "12,34", "reason": "near"}'
    assert read_answer(whole + "\n" * 40, "length") == Answer((12, 34), reason="near")
    for text in (whole[:-1] + "\n" * 40, whole + "\nor rather", "Choice: 12,34\n", "12,34 \n"):
        with pytest.raises(InvalidAnswer) as caught:
            read_answer(text, "length")
        assert caught.value.name == "cut off"


def test_what_a_text_escapes_can_be_kept() -> None:
    answer = read_answer('{"choice": "B", "reason": "far \\ud83d \\u001b[2J"}')
    assert answer == Answer(None, "B", "far \ufffd \ufffd[2J")


SLOW = [
    "<think>\nOkay\n",
    "<think>x</think>",
    '{"choice": "1',
    '{"a": ',
    "{'a': '",
    '{"choice": "1' + " " * 99,
    "{",
    "}",
    '"',
    "[",
    "\\boxed{",
    "<answer>",
    "Choice: ",
    "choice ",
    " " * 50 + "x",
    "**",
    "```",
    "7,8 (",
    "<|channel|>analysis",
    "not {",
    "the frontier ",
    "\\",
]


@pytest.mark.parametrize("piece", SLOW)
@pytest.mark.parametrize("before", ["", '{"choice": "', '{"choice": '])
def test_time_is_linear_in_the_text(piece: str, before: str) -> None:
    """A hundred thousand characters take well under two seconds on any machine."""
    began = time.process_time()
    answer_or_name(before + piece * (100_000 // len(piece)))
    answer_or_name(before + piece * (290 // len(piece)))
    assert time.process_time() - began < 2.0


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
