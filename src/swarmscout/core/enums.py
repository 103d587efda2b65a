"""Integer codes that arrays hold: labels, modes, actions, kinds of event, reasons for a decision.

Kernels read these as constants, and Numba's disk cache does not see a change made here: append new
codes at the end of a list and never renumber one.
"""

from __future__ import annotations

__all__ = [
    "ACTIONS",
    "CAUSES",
    "EVENTS",
    "LABELS",
    "MODES",
]

# Labels of an occupancy grid's cells (uint8).
UNKNOWN, FREE, OCCUPIED = 0, 1, 2
LABELS = ("unknown", "free", "occupied")

# Operation modes of a robot (paper, "Task description and team behavior").
EXPLORE, CHARGE = 0, 1
MODES = ("EXP", "CHR")

# Discrete actions of a step (paper, same section): rotations are 40° by default.
STOP, FORWARD, LEFT, RIGHT = 0, 1, 2, 3
ACTIONS = ("stop", "forward", "left", "right")

# What a body felt when it tried to move.
NO_CONTACT, WALL_CONTACT, ROBOT_CONTACT = 0, 1, 2

# Kinds of event; `other` and `value` of an event row mean what stands behind the kind.
JOIN = 0  # robot's team was joined with another; other: its new leader, value: its new team
LEAVE = 1  # robot left its team; other: its leader until then, value: its new team
LEADER = 2  # a team elected robot as its leader; other: the leader before, value: the team
MODE = 3  # robot changed its mode; other: the new mode, value: -1
STRANDED = 4  # robot's charge is gone; other: -1, value: -1
CONTACT = 5  # a forward move was not made; other: what was touched, value: robot or -1
ROUTE = 6  # robot planned a route; other: cells on it (-1: there is none), value: the goal's cell
DROP = 7  # a team gave up its destination; other: the cause, value: the cell
EVENTS = ("join", "leave", "leader", "mode", "stranded", "contact", "route", "drop")

# Why a leader needs a new destination (paper, same section: "after any member reaches the target").
NO_CAUSE, NONE_YET, REACHED, NOT_CANDIDATE, UNREACHABLE, OVERDUE = 0, 1, 2, 3, 4, 5
CAUSES = ("", "none yet", "reached", "no frontier any more", "unreachable", "overdue")
