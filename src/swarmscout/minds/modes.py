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


is_on_task = inlined(on_task)
"""The same for kernels, of one robot's mode."""


@kernel
def choose_modes(own, stations, below, share_per_m, share_reserve, events):  # type: ignore[no-untyped-def]
    """Each robot compares its own charge with what it needs: low → CHR, full again → EXP.

    Args:
        own: MIND[N].
        stations: float64[k, 2], where the charging stations are: known to all from the start.
        below: share of the capacity under which CHR mode begins.
        share_per_m, share_reserve: charge that the way back takes per metre of straight distance,
            and a reserve; both 0 under the rule "threshold".
        events: EVENT[capacity + 1], see ``EventLog``.
    """
    for i in range(own.shape[0]):
        me = own[i]
        if not me.thinks:
            continue
        needed = below
        if share_per_m > 0.0:
            nearest2 = 1e300
            for s in range(stations.shape[0]):
                dx = me.x_m - stations[s, 0]
                dy = me.y_m - stations[s, 1]
                nearest2 = min(nearest2, dx * dx + dy * dy)
            needed = max(below, nearest2**0.5 * share_per_m + share_reserve)
        mode = me.mode
        if mode == EXPLORE and me.charge < min(needed, 1.0):
            mode = CHARGE
        elif mode == CHARGE and me.charge >= 1.0:
            mode = EXPLORE
        if mode != me.mode:
            me.mode = mode
            note(events, MODE_EVENT, i, mode, -1)
