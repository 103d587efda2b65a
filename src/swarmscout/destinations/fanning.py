"""Which cell each member of a team drives to: the team's destination, or one of its own near it.

Deviation: with ``members = "fan"`` the members of a team take different frontier cells round the
team's destination. The paper sends all of them to the same cell, where they stand in each other's
way and see the same; that is ``members = "shared"``, the default.
"""

from __future__ import annotations

import math

from swarmscout.core.codes import CHARGE
from swarmscout.core.jit import inlined, kernel
from swarmscout.minds.minds import DESTINATION, MODE, STEP, TARGET, TEAM

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
def _away(reading, j, cell, ox, oy, cell_m, columns):  # type: ignore[no-untyped-def]
    """Squared distance in m² from robot j, as heard, to a cell's centre."""
    dx = ox + (cell % columns + 0.5) * cell_m - reading[j, 0]
    dy = oy + (cell // columns + 0.5) * cell_m - reading[j, 1]
    return dx * dx + dy * dy


@inlined
def _reached(reading, members, n, cell, reach_m, ox, oy, cell_m, columns):  # type: ignore[no-untyped-def]
    """Whether any of n members, as heard, is at a cell."""
    for a in range(n):
        if _away(reading, members[a], cell, ox, oy, cell_m, columns) <= reach_m * reach_m:
            return True
    return False


@inlined
def _is_apart(targets, n, cell, apart, columns):  # type: ignore[no-untyped-def]
    """Whether a cell keeps its distance (squared, in cells) from all targets that are taken."""
    for b in range(n):
        if targets[b] >= 0 and _squared(targets[b], cell, columns) < apart:
            return False
    return True


@kernel
def fan_out(  # type: ignore[no-untyped-def]
    state, sending, links, heard_state, heard_reading, status, frontier_bit, cells, members,
    targets, ox, oy, cell_m, rows, columns, reach_m, fan_m, apart_m, step,
):  # fmt: skip
    """Each robot takes a frontier cell near its team's destination, alone, from what it knows.

    Every member solves the same small assignment on what it has heard and takes its own part, so
    members that have heard the same never take the same cell. Who has a target keeps it while the
    team keeps its destination and the target is a frontier that nobody of the team has reached.
    Then somebody has to take the destination itself, and the others take what is nearest to them:
    always the nearest pair of member and cell first, and no cell nearer than `apart_m` to another
    member's. For whom no cell is left, the destination serves.

    Args:
        state, sending, heard_state, heard_reading: see ``Minds``; state[:, TARGET], which is the
            destination before, is written.
        links: bool[N, N]; not read where all share one listener's row.
        status: uint8[K, C'] and frontier_bit: see ``OccupancyGrids``.
        cells: int64[cells in the disc or more], members: int64[N], targets: int64[N]: scratch.
        ox, oy, cell_m, rows, columns: the grid's frame.
        reach_m: this near to a target's centre is reached.
        fan_m: targets lie this near to the destination; apart_m: and at least so far apart.
        step: the current step.
    """
    shared = heard_state.shape[0] == 1
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
            if not _reached(
                heard_reading[k], members, n, cells[c], reach_m, ox, oy, cell_m, columns
            ):
                cells[left] = cells[c]
                left += 1
        taken = False
        for a in range(n):
            j = members[a]
            targets[a] = -1
            target = heard_state[k, j, TARGET]
            if heard_state[k, j, STEP] != step or heard_state[k, j, DESTINATION] != goal:
                continue
            for c in range(left):
                if cells[c] == target:
                    targets[a] = target
                    taken = taken or target == goal
                    break
        # Each round gives one member a cell.
        for _ in range(n):
            best = math.inf
            best_a = -1
            best_cell = goal
            for a in range(n):
                if targets[a] >= 0:
                    continue
                if not taken:
                    away = _away(heard_reading[k], members[a], goal, ox, oy, cell_m, columns)
                    if away < best:
                        best, best_a = away, a
                    continue
                for c in range(left):
                    away = _away(heard_reading[k], members[a], cells[c], ox, oy, cell_m, columns)
                    if away >= best:
                        continue
                    if _is_apart(targets, n, cells[c], apart, columns):
                        best, best_a, best_cell = away, a, cells[c]
            if best_a < 0:
                break
            targets[best_a] = best_cell
            taken = True
        for a in range(n):
            if members[a] == i and targets[a] >= 0:
                state[i, TARGET] = targets[a]
