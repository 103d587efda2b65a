"""Messages: all that crosses from one robot to another.

- A **beacon** is sent once a step. Later phases of the step read the beacons heard in it, the same
  snapshot for all robots.
- A **team notice** follows in the same step, along the same links: it tells what its sender has
  changed since its beacon. A robot reads the notices of those whose beacon it heard in this step.
- **Evidence packets**, slices of one robot's log of evidence, are exchanged in
  :mod:`swarmscout.comms.exchange`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.jit import kernel

__all__ = ["BEACON", "NOTICE", "blank_notices", "send_beacons", "send_notices"]

BEACON = np.dtype(
    [
        ("step", "i8"),  # when it was sent; -1: never heard
        ("x_m", "f8"),
        ("y_m", "f8"),
        ("charge", "f8"),
        ("heading", "i8"),
        ("team", "i8"),
        ("leader", "i8"),
        ("mode", "i8"),
        ("size", "i8"),
        ("desired", "i8"),
        ("partner", "i8"),
        ("destination", "i8"),
        ("target", "i8"),
        ("aim", "i8"),
        ("still", "i8"),
        ("station", "i8"),
        ("place", "i8"),
    ],
    align=True,
)
"""What a robot tells all that hear it; the fields are those of ``MIND``."""

NOTICE = np.dtype(
    [
        ("step", "i8"),  # when it was sent; -1: never
        ("team", "i8"),
        ("leader", "i8"),
        ("charge", "f8"),
        ("destination", "i8"),
        ("due_at", "i8"),
        ("reached", "i8"),  # to its leader: it has reached this destination, or -1
        ("given_up", "i8"),  # a destination that its team gave up, or -1 …
        ("why", "i8"),  # … and the cause, a code of CAUSES
    ],
    align=True,
)
"""What a robot tells in the same step, most of it to its team."""


def blank_notices(robots: int) -> NDArray[np.void]:
    """NOTICE[N]: nothing has been said yet."""
    notices = np.zeros(robots, dtype=NOTICE)
    notices["step"] = notices["reached"] = notices["given_up"] = -1
    return notices


@kernel
def send_beacons(own, step, beacons):  # type: ignore[no-untyped-def]
    """Each robot that can send says what it is and wants.

    Args:
        own: MIND[N]; step: the current step.
        beacons: BEACON[N], written; a robot's own record is current even if it cannot send.

    Returns:
        Whether each robot hears, and each that thinks sends.
    """
    sound = True
    for i in range(own.shape[0]):
        me = own[i]
        sound = sound and me.hears and (me.sends or not me.thinks)
        if not me.thinks:
            continue
        beacon = beacons[i]
        beacon.step = step
        beacon.x_m = me.x_m
        beacon.y_m = me.y_m
        beacon.charge = me.charge
        beacon.heading = me.heading
        beacon.team = me.team
        beacon.leader = me.leader
        beacon.mode = me.mode
        beacon.size = me.size
        beacon.desired = me.desired
        beacon.partner = me.partner
        beacon.destination = me.destination
        beacon.target = me.target
        beacon.aim = me.aim
        beacon.still = me.still
        beacon.station = me.station
        beacon.place = me.place
    return sound


@kernel
def send_notices(own, step, notices):  # type: ignore[no-untyped-def]
    """Each robot that thinks tells its team what it has decided since its beacon.

    Args:
        own: MIND[N]; step: the current step.
        notices: NOTICE[N]: step, team, leader, charge, destination and due_at are written.
    """
    for i in range(own.shape[0]):
        me = own[i]
        if not me.thinks:
            continue
        notice = notices[i]
        notice.step = step
        notice.team = me.team
        notice.leader = me.leader
        notice.charge = me.charge
        notice.destination = me.destination
        notice.due_at = me.due_at
