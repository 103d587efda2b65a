"""The two modes of a robot: EXP (explore) and CHR (charge) (paper, "Task description")."""

from __future__ import annotations

from swarmscout.core.enums import CHARGE, EXPLORE
from swarmscout.core.enums import MODE as MODE_EVENT
from swarmscout.core.events import note
from swarmscout.core.jit import inlined, kernel

__all__ = ["choose_modes", "is_on_task", "on_task"]


def on_task(mode):  # type: ignore[no-untyped-def]
    """Whether robots work on the swarm's task; those that charge do not.

    Args:
        mode: a code of MODES, or an array of them.
    """
    return mode == EXPLORE


MOST_NEEDED = 0.9
"""A robot with more than this share of its capacity explores, wherever it is."""

is_on_task = inlined(on_task)
"""The same for kernels, of one robot's mode."""


@kernel
def choose_modes(own, below, share_per_m, share_reserve, events):  # type: ignore[no-untyped-def]
    """Each robot compares its own charge with what it needs: low → CHR, full again → EXP.

    Args:
        own: MIND[N].
        below: share of the capacity under which CHR mode begins.
        share_per_m, share_reserve: charge that the way to a station takes per metre, and a reserve;
            both 0 where that does not matter: under the rule "threshold", or if nobody has looked
            its way up in this step.
        events: EVENT[capacity + 1], see ``EventLog``.
    """
    for i in range(own.shape[0]):
        me = own[i]
        if not me.thinks:
            continue
        needed = below
        if share_per_m > 0.0:
            needed = max(below, min(MOST_NEEDED, me.way_m * share_per_m + share_reserve))
        mode = me.mode
        if mode == EXPLORE and me.charge < needed:
            mode = CHARGE
        elif mode == CHARGE and me.charge >= 1.0:
            mode = EXPLORE
        if mode != me.mode:
            me.mode = mode
            note(events, MODE_EVENT, i, mode, -1)
