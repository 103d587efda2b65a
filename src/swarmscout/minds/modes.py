"""The two modes of a robot: EXP (explore) and CHR (charge) (paper, "Task description")."""

from __future__ import annotations

from swarmscout.core.enums import CHARGE, EXPLORE
from swarmscout.core.enums import MODE as MODE_EVENT
from swarmscout.core.jit import kernel
from swarmscout.minds.minds import MODE

__all__ = ["choose_modes"]


@kernel
def choose_modes(  # type: ignore[no-untyped-def]
    state, reading, sending, stations, below, share_per_m, share_reserve, events, count
):
    """Each robot looks at its own charge: low → CHR, full again → EXP.

    Args:
        state: int64[N, columns]; reading: float64[N, 4]; sending: bool[N], see ``Minds``.
        stations: float64[k, 2], where the charging stations are: known to all from the start.
        below: share of the capacity under which CHR mode begins.
        share_per_m, share_reserve: charge that the way back takes per metre of straight distance,
            and a reserve; both 0 under the rule "threshold".
    """
    for i in range(state.shape[0]):
        if not sending[i]:
            continue
        charge = reading[i, 3]
        needed = below
        if share_per_m > 0.0:
            nearest2 = 1e300
            for s in range(stations.shape[0]):
                dx = reading[i, 0] - stations[s, 0]
                dy = reading[i, 1] - stations[s, 1]
                nearest2 = min(nearest2, dx * dx + dy * dy)
            needed = max(below, nearest2**0.5 * share_per_m + share_reserve)
        mode = state[i, MODE]
        if mode == EXPLORE and charge < min(needed, 1.0):
            mode = CHARGE
        elif mode == CHARGE and charge >= 1.0:
            mode = EXPLORE
        if mode != state[i, MODE]:
            state[i, MODE] = mode
            events[count[0], 0] = MODE_EVENT
            events[count[0], 1] = i
            events[count[0], 2] = mode
            events[count[0], 3] = -1
            count[0] += 1
