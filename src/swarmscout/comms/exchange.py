"""Delivery: beacons and evidence flow along the links of a step.

What robot i knows of robot k's log is a prefix of it, so one number says it: ``versions[i, k]``. On
contact i takes from j exactly the entries ``versions[i, k] … versions[j, k]`` for every k. Exchange
is therefore idempotent, an observation never counts twice however often robots meet (plain addition
of maps counts it each time), and once all robots have heard all others their maps are equal.
"""

from __future__ import annotations

from swarmscout.core.jit import kernel

__all__ = ["deliver", "same_knowledge"]


@kernel
def deliver(beacons, log_end, bounds, members, ear, heard, still, versions, before, step):  # type: ignore[no-untyped-def]
    """Each group hears the beacons of its set, and takes over what their senders know.

    Args:
        beacons: BEACON[N], what robots say; log_end: int64[N], how long each robot's log is.
        bounds: int64[A, 3]: a row in use, and where the robots that it hears begin and end in
            members: int64[M].
        ear: int64[N], the row of each robot before groups parted.
        heard, still, versions: see ``Knowledge``; written.
        before: int64[R, N], `versions` before this exchange.
        step: the current step.
    """
    robots = beacons.shape[0]
    for a in range(bounds.shape[0]):
        row = bounds[a, 0]
        for j in range(robots):
            # Out of range and out of charge are the same to a listener: as far as it knows, the
            # robot is where it was last heard.
            if heard[row, j].step >= 0:
                still[row, j] += 1
        source = -1
        for m in range(bounds[a, 1], bounds[a, 2]):
            j = members[m]
            # Who turns to and fro, or is pushed about, stands: each robot says for how long.
            still[row, j] = beacons[j].still
            heard[row, j] = beacons[j]
            # Members of one group know the same but for their own latest entries.
            if ear[j] != source:
                source = ear[j]
                for k in range(robots):
                    versions[row, k] = max(versions[row, k], before[source, k])
            versions[row, j] = max(versions[row, j], log_end[j])


@kernel
def same_knowledge(heard, still, versions, a, b):  # type: ignore[no-untyped-def]
    """Whether two rows are equal: versions (and with them maps), beacons and standstills."""
    for j in range(versions.shape[1]):
        if versions[a, j] != versions[b, j] or still[a, j] != still[b, j]:
            return False
        mine = heard[a, j]
        theirs = heard[b, j]
        # A robot sends one beacon a step, so beacons of one step are the same.
        if mine.step != theirs.step:
            return False
    return True
