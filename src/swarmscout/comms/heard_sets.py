"""Which robots hear exactly the same others in a step, and the groups that follow from it.

Two robots that knew the same and hear the same know the same afterwards. So the groups of robots
that share one row of tables and maps are refined step by step: a group parts where its members
hear different others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.jit import inlined, kernel
from swarmscout.core.links import Links

__all__ = ["HeardSets", "find_heard_sets", "split_groups"]


@dataclass(frozen=True, slots=True)
class HeardSets:
    """The different sets of robots that robots hear in a step.

    Attributes:
        set_of: int64[N], the set that each robot hears.
        bounds: int64[S, 2], where each set begins and ends in `members`.
        members: int64[M], robots of each set, ascending; a robot that thinks hears itself.
    """

    set_of: NDArray[np.int64]
    bounds: NDArray[np.int64]
    members: NDArray[np.int64]

    @staticmethod
    def of(links: Links, own: NDArray[np.void]) -> HeardSets:
        """The sets of a step.

        Args:
            links: who is in whose range.
            own: MIND[N]: who hears, sends and thinks.
        """
        robots = len(own)
        impaired = int(np.count_nonzero(~(own["sends"] & own["hears"])))
        most = (impaired + 2) * robots if links.complete else len(links.senders) + robots
        set_of = np.empty(robots, dtype=np.int64)
        bounds = np.empty((robots, 2), dtype=np.int64)
        # Room for one more set behind the last one, where each is written before it is compared.
        members = np.empty(most + robots, dtype=np.int64)
        table = np.full(1 << (2 * robots).bit_length(), -1, dtype=np.int64)
        count = find_heard_sets(
            own, links.complete, links.start, links.senders, table, set_of, bounds, members
        )
        return HeardSets(set_of, bounds[:count], members)


@inlined
def _same(members, a, b, end):  # type: ignore[no-untyped-def]
    """Whether the list that begins at b and ends at `end` stands at a too."""
    n = 0
    while b + n < end and members[a + n] == members[b + n]:
        n += 1
    return b + n == end


@kernel
def find_heard_sets(own, complete, start, senders, table, set_of, bounds, members):  # type: ignore[no-untyped-def]
    """List whom each robot hears, each different set once.

    Args:
        own: MIND[N]; complete, start, senders: see ``Links``.
        table: int64[power of two > N], scratch, all -1: a hash table of sets.
        set_of, bounds, members: written, see ``HeardSets``.

    Returns:
        How many sets there are.
    """
    robots = own.shape[0]
    count = 0
    begin = 0
    for i in range(robots):
        end = begin
        if not own[i].hears:
            if own[i].thinks:
                members[end] = i
                end += 1
        elif complete:
            for j in range(robots):
                if own[j].sends or (j == i and own[i].thinks):
                    members[end] = j
                    end += 1
        else:
            placed = not own[i].thinks
            for e in range(start[i], start[i + 1]):
                j = senders[e]
                if not placed and j > i:
                    members[end] = i
                    end += 1
                    placed = True
                if own[j].sends:
                    members[end] = j
                    end += 1
            if not placed:
                members[end] = i
                end += 1
        code = end - begin
        for k in range(begin, end):
            code = (code * 1000003) ^ members[k]
        slot = code & (table.shape[0] - 1)
        while table[slot] >= 0:
            s = table[slot]
            if bounds[s, 1] - bounds[s, 0] == end - begin and _same(
                members, bounds[s, 0], begin, end
            ):
                break
            slot = (slot + 1) & (table.shape[0] - 1)
        if table[slot] < 0:
            table[slot] = count
            bounds[count, 0] = begin
            bounds[count, 1] = end
            count += 1
            begin = end
        set_of[i] = table[slot]
    return count


@kernel
def split_groups(ear, set_of, fresh, table, claimed, copies):  # type: ignore[no-untyped-def]
    """Part the groups whose members hear different sets of robots.

    Args:
        ear: int64[N], written: the row of each robot; the first part of a group keeps its row.
        set_of: int64[N], see ``HeardSets``.
        fresh: int64[N], rows that are not in use, in the order in which to take them.
        table: int64[power of two > N, 2], scratch, all -1: a hash table of parts and their rows.
        claimed: bool[rows], scratch, all False.
        copies: int64[N, 2], written: rows to be copied, from and to.

    Returns:
        How many copies there are.
    """
    robots = ear.shape[0]
    taken = 0
    for i in range(robots):
        key = ear[i] * robots + set_of[i]
        slot = (key * 1000003) & (table.shape[0] - 1)
        while table[slot, 0] >= 0 and table[slot, 0] != key:
            slot = (slot + 1) & (table.shape[0] - 1)
        if table[slot, 0] < 0:
            table[slot, 0] = key
            table[slot, 1] = ear[i]
            if claimed[ear[i]]:
                table[slot, 1] = fresh[taken]
                copies[taken, 0] = ear[i]
                copies[taken, 1] = fresh[taken]
                taken += 1
            claimed[ear[i]] = True
        ear[i] = table[slot, 1]
    return taken
