"""Which cell each member of a team drives to: the team's destination, or one of its own near it.

Deviation: with ``members = "fan"`` the members of a team take different candidates of the task
round the team's destination. The paper sends all of them to the same cell, where they stand in each
other's way and see the same; that is ``members = "shared"``, the default.
"""

from __future__ import annotations

import math

import numpy as np

from swarmscout.core.cells import offset
from swarmscout.core.grid import GRID
from swarmscout.core.jit import inlined, kernel
from swarmscout.minds.modes import is_on_task

__all__ = ["FAN", "fan_out"]

FAN = np.dtype(
    [
        *GRID.descr,  # the frame of the map
        ("candidate_bit", "i8"),  # in a cell's mark, see CheckedTask
        ("reach_m", "f8"),  # this near to a target's centre it is reached
        ("fan_m", "f8"),  # targets lie this near to the destination …
        ("apart_m", "f8"),  # … and at least this far apart
        ("turn_m", "f8"),  # what a turn by a radian costs, in metres
        ("keep_m", "f8"),  # another cell than the one that a member drives to costs so much more
    ],
    align=True,
)
"""How members fan out."""


@inlined
def _squared(a, b, columns):  # type: ignore[no-untyped-def]
    """Squared distance of two flat cells, in cells."""
    down = a // columns - b // columns
    across = a % columns - b % columns
    return down * down + across * across


@inlined
def _list_cells(marks, candidate_bit, centre, reach_cells, columns, rows, cells):  # type: ignore[no-untyped-def]
    """Candidates in a disc round a cell, by row and then by column; returns how many."""
    n = 0
    row, col = centre // columns, centre % columns
    for near_row in range(max(0, row - reach_cells), min(rows, row + reach_cells + 1)):
        for near_col in range(max(0, col - reach_cells), min(columns, col + reach_cells + 1)):
            cell = near_row * columns + near_col
            if (
                marks[cell] & candidate_bit != 0
                and _squared(cell, centre, columns) <= reach_cells * reach_cells
            ):
                cells[n] = cell
                n += 1
    return n


@inlined
def _effort(mate, cell, rules, headings):  # type: ignore[no-untyped-def]
    """Distance, turn and change of mind, in metres, of a robot as heard; and the distance alone."""
    dx, dy = offset(cell, mate.x_m, mate.y_m, rules)
    away = math.sqrt(dx * dx + dy * dy)
    change = 0.0 if cell == mate.target else rules.keep_m
    if away == 0.0:
        return change, 0.0
    along = (dx * headings[mate.heading, 0] + dy * headings[mate.heading, 1]) / away
    # The chord of the angle: as long as the angle where it is small, 2 for about-turns.
    turn = rules.turn_m * math.sqrt(max(0.0, 2.0 - 2.0 * along))
    return change + away + turn, away


@inlined
def _is_apart(targets, n, cell, apart, columns):  # type: ignore[no-untyped-def]
    """Whether a cell keeps its distance (squared, in cells) from all targets that are taken."""
    for b in range(n):
        if targets[b] >= 0 and _squared(targets[b], cell, columns) < apart:
            return False
    return True


@inlined
def _list_members(own, heard, notices, i, step, members):  # type: ignore[no-untyped-def]
    """The robots of i's team that i hears, itself too, ascending; returns how many."""
    n = 0
    for j in range(heard.shape[0]):
        if j == i or (
            heard[j].step == step and notices[j].step == step and notices[j].team == own[i].team
        ):
            members[n] = j
            n += 1
    return n


@inlined
def _assign(heard, goal, members, cells, efforts, targets, rules, headings):  # type: ignore[no-untyped-def]
    """Give members cells, the cheapest pair of both first; targets of the others are -1."""
    n = members.shape[0]
    apart2 = (rules.apart_m / rules.cell_m) ** 2
    # Cells that a member has reached already are not worth going to.
    left = 0
    for c in range(cells.shape[0]):
        reached = False
        for a in range(n):
            efforts[a, left], away = _effort(heard[members[a]], cells[c], rules, headings)
            reached = reached or away <= rules.reach_m
        if not reached:
            cells[left] = cells[c]
            left += 1
    best = math.inf
    first = 0
    for a in range(n):
        targets[a] = -1
        effort, _ = _effort(heard[members[a]], goal, rules, headings)
        if effort < best:
            best, first = effort, a
    targets[first] = goal
    # Each round gives one member a cell.
    for _ in range(n - 1):
        best = math.inf
        best_a = -1
        best_cell = goal
        for a in range(n):
            if targets[a] >= 0:
                continue
            for c in range(left):
                if efforts[a, c] < best and _is_apart(targets, n, cells[c], apart2, rules.columns):
                    best, best_a, best_cell = efforts[a, c], a, cells[c]
        if best_a < 0:
            break
        targets[best_a] = best_cell


@kernel
def fan_out(own, ear, heard, notices, marks, headings, rules, step):  # type: ignore[no-untyped-def]
    """Each robot takes a candidate near its team's destination, alone, from what it knows.

    Every member solves the same small assignment on what it has heard and takes its own part, so
    members that have heard the same never take the same cell. Who gets to the destination with the
    least effort takes it, and the others take what costs them least: always the cheapest pair of
    member and cell first, and no cell nearer than `apart_m` to another member's. A member for which
    no cell is left takes the destination. All is decided anew in each step, but turning has its
    price, and so has any other cell than the one that a member drives to, which it tells in its
    beacon: two members for which two cells are about as good do not swap them for ever.

    Args:
        own: MIND[N], `target` is written; ear, heard, notices: see ``Knowledge``.
        marks: uint8[R, C'], which cells are candidates, see ``CheckedTask``.
        headings: float64[ticks, 2], ``heading_table()``.
        rules: FAN[1]; step: the current step.
    """
    rules = rules[0]
    robots = own.shape[0]
    reach_cells = int(rules.fan_m / rules.cell_m)
    disc = (2 * reach_cells + 1) ** 2
    cells = np.empty(disc, dtype=np.int64)
    efforts = np.empty((robots, disc))
    members = np.empty(robots, dtype=np.int64)
    targets = np.empty(robots, dtype=np.int64)
    for i in range(robots):
        me = own[i]
        goal = me.destination
        if not me.thinks or goal < 0 or not is_on_task(me.mode):
            continue
        row = heard[ear[i]]
        n = _list_members(own, row, notices, i, step, members)
        if n == 1:
            continue
        found = _list_cells(
            marks[ear[i]], rules.candidate_bit, goal, reach_cells, rules.columns, rules.rows, cells
        )
        _assign(row, goal, members[:n], cells[:found], efforts, targets, rules, headings)
        for a in range(n):
            if members[a] == i and targets[a] >= 0:
                me.target = targets[a]
