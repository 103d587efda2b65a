"""Which cell each member of a team drives to: the team's destination, or one of its own near it.

Deviation: with ``members = "fan"`` the members of a team take different frontier cells round the
team's destination. The paper sends all of them to the same cell, where they stand in each other's
way and see the same; that is ``members = "shared"``, the default.
"""

from __future__ import annotations

import math

from swarmscout.core.enums import CHARGE
from swarmscout.core.jit import inlined, kernel
from swarmscout.minds.minds import DESTINATION, MODE, TARGET, TEAM

__all__ = ["fan_out"]


@inlined
def _squared(a, b, columns):  # type: ignore[no-untyped-def]
    """Squared distance of two flat cells, in cells."""
    down = a // columns - b // columns
    across = a % columns - b % columns
    return down * down + across * across


@inlined
def _list_cells(status, frontier_bit, centre, reach_cells, columns, rows, cells):  # type: ignore[no-untyped-def]
    """Frontier cells in a disc round a cell, by row and then by column; returns how many."""
    n = 0
    row, col = centre // columns, centre % columns
    for near_row in range(max(0, row - reach_cells), min(rows, row + reach_cells + 1)):
        for near_col in range(max(0, col - reach_cells), min(columns, col + reach_cells + 1)):
            cell = near_row * columns + near_col
            if (
                status[cell] & frontier_bit != 0
                and _squared(cell, centre, columns) <= reach_cells * reach_cells
            ):
                cells[n] = cell
                n += 1
    return n


@inlined
def _effort(reading, j, cell, ox, oy, cell_m, columns, turn_m, looks):  # type: ignore[no-untyped-def]
    """Distance and turn, in metres, from robot j as heard to a cell; and the distance alone."""
    dx = ox + (cell % columns + 0.5) * cell_m - reading[j, 0]
    dy = oy + (cell // columns + 0.5) * cell_m - reading[j, 1]
    away = math.sqrt(dx * dx + dy * dy)
    if away == 0.0:
        return 0.0, 0.0
    look = int(reading[j, 2])
    along = (dx * looks[look, 0] + dy * looks[look, 1]) / away
    # The chord of the angle: as long as the angle where it is small, 2 for about-turns.
    return away + turn_m * math.sqrt(max(0.0, 2.0 - 2.0 * along)), away


@inlined
def _is_apart(targets, n, cell, apart, columns):  # type: ignore[no-untyped-def]
    """Whether a cell keeps its distance (squared, in cells) from all targets that are taken."""
    for b in range(n):
        if targets[b] >= 0 and _squared(targets[b], cell, columns) < apart:
            return False
    return True


@kernel
def fan_out(  # type: ignore[no-untyped-def]
    state, sending, links, heard_reading, status, frontier_bit, looks, cells, efforts, members,
    targets, ox, oy, cell_m, rows, columns, reach_m, fan_m, apart_m, turn_m,
):  # fmt: skip
    """Each robot takes a frontier cell near its team's destination, alone, from what it knows.

    Every member solves the same small assignment on what it has heard and takes its own part, so
    members that have heard the same never take the same cell. Who gets to the destination with the
    least effort takes it, and the others take what costs them least: always the cheapest pair of
    member and cell first, and no cell nearer than `apart_m` to another member's. For whom no cell
    is left, the destination serves. All is decided anew in each step: turning has its price, so
    that robots keep going where they look.

    Args:
        state, sending, heard_reading: see ``Minds``; state[:, TARGET] is written.
        links: bool[N, N]; not read where all share one listener's row.
        status: uint8[K, C'] and frontier_bit: see ``OccupancyGrids``.
        looks: float64[ticks, 2], ``heading_table()``.
        cells: int64[cells in the disc or more], efforts: float64[N, as many], members: int64[N],
            targets: int64[N]: scratch.
        ox, oy, cell_m, rows, columns: the grid's frame.
        reach_m: this near to a target's centre is reached.
        fan_m: targets lie this near to the destination; apart_m: and at least so far apart.
        turn_m: what a turn by a radian costs, in metres.
    """
    shared = heard_reading.shape[0] == 1
    reach_cells = int(fan_m / cell_m)
    apart = (apart_m / cell_m) ** 2
    for i in range(state.shape[0]):
        goal = state[i, DESTINATION]
        if not sending[i] or goal < 0 or state[i, MODE] == CHARGE:
            continue
        k = 0 if shared else i
        # Who belongs to the team is known through the second exchange of phase 5.
        n = 0
        for j in range(state.shape[0]):
            if (
                state[j, TEAM] == state[i, TEAM]
                and sending[j]
                and (shared or j == i or links[i, j])
            ):
                members[n] = j
                n += 1
        if n == 1:
            continue
        found = _list_cells(status[k], frontier_bit, goal, reach_cells, columns, rows, cells)
        # Cells that a member has reached already are not worth going to.
        left = 0
        for c in range(found):
            reached = False
            for a in range(n):
                efforts[a, left], away = _effort(
                    heard_reading[k], members[a], cells[c], ox, oy, cell_m, columns, turn_m, looks
                )
                reached = reached or away <= reach_m
            if not reached:
                cells[left] = cells[c]
                left += 1
        best = math.inf
        first = 0
        for a in range(n):
            targets[a] = -1
            effort, _ = _effort(
                heard_reading[k], members[a], goal, ox, oy, cell_m, columns, turn_m, looks
            )
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
                    if efforts[a, c] < best and _is_apart(targets, n, cells[c], apart, columns):
                        best, best_a, best_cell = efforts[a, c], a, cells[c]
            if best_a < 0:
                break
            targets[best_a] = best_cell
        for a in range(n):
            if members[a] == i and targets[a] >= 0:
                state[i, TARGET] = targets[a]
