"""No rule of minds reads or writes another robot's own record: robots talk in messages."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import swarmscout

SOURCE = Path(swarmscout.__file__).parent
ROOMS = ("minds", "comms", "teams", "destinations", "planning", "mapping", "tasks")
OWN = {"own", "routes", "avoided", "avoided_next", "given_up", "ear"}
"""Arrays whose row i belongs to robot i alone."""

KERNELS = [
    pytest.param(node, id=f"{path.relative_to(SOURCE)}:{node.name}")
    for room in ROOMS
    for path in sorted((SOURCE / room).rglob("*.py"))
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    if isinstance(node, ast.FunctionDef)
    and any(ast.unparse(d) in ("kernel", "inlined", "allocating") for d in node.decorator_list)
]
SHARED_SEARCH = {"_start_all", "_read_all"}
"""One search serves all robots with the same map and goal; each still gets a route of its own."""

SENDING = {"find_heard_sets", "deliver"}
"""Delivery of messages: whether a robot sends, and with which evidence."""


def other_rows(function: ast.FunctionDef) -> list[str]:
    """Accesses to own rows by another index than i, the robot that the rule is for."""
    found = []
    for node in ast.walk(function):
        if not isinstance(node, ast.Subscript) or not isinstance(node.value, ast.Name):
            continue
        if node.value.id not in OWN:
            continue
        index = node.slice.elts[0] if isinstance(node.slice, ast.Tuple) else node.slice
        if ast.unparse(index) != "i":
            found.append(ast.unparse(node))
    return found


@pytest.mark.parametrize("function", KERNELS)
def test_a_rule_touches_row_i_alone(function: ast.FunctionDef) -> None:
    if function.name in SHARED_SEARCH | SENDING:
        return
    assert other_rows(function) == []


MUTANTS = {
    "elects by the others' own charge": "if own[j].charge > most: best = j",
    "asks whether the leader has really left": "return own[leader].team == own[i].team",
    "checks the partner's present team": "if heard[j].team == own[j].team: n += 1",
    "writes into its leader's record": "own[leader].cause = REACHED",
    "makes all members avoid a cell": "avoided[j, slot, 0] = cell",
    "takes the destination out of the leader's mind": "me.destination = own[me.leader].destination",
}
"""The six places that once read or wrote other robots' live rows."""


@pytest.mark.parametrize("name", MUTANTS)
def test_each_old_way_round_messages_is_found(name: str) -> None:
    function = ast.parse(f"def rule(own, heard, i, j):\n    {MUTANTS[name]}\n").body[0]
    assert isinstance(function, ast.FunctionDef)
    assert other_rows(function) != []
