"""Knowledge made by hand: what robots have heard in a step, without a mission."""

from __future__ import annotations

from typing import Any

import numpy as np

from swarmscout.comms.knowledge import Knowledge
from swarmscout.core.links import Links
from swarmscout.mapping.evidence import EvidenceLog
from swarmscout.mapping.occupancy import OccupancyGrids
from swarmscout.minds.minds import Minds


def exchange(knowledge: Knowledge, minds: Minds, step: int, links: Any = None) -> None:
    """Beacons of a step flow along a matrix of links, by default to all robots; no evidence."""
    robots = len(minds)
    given = Links.full(robots) if links is None else Links.of_matrix(links, robots, "links")
    knowledge.send(minds, step)
    knowledge.receive(minds, EvidenceLog(robots, 1, 0.5, 0.5), given, step)


def knowledge_of(minds: Minds, grids: OccupancyGrids) -> Knowledge:
    """Robots that have heard nothing; one map is shared, of several each robot has its own."""
    knowledge, maps = Knowledge(len(minds), grids), len(grids.evidence)
    if maps > 1:
        knowledge.ear[:] = np.arange(maps)
        knowledge.rows = np.arange(maps)
        knowledge.heard = np.repeat(knowledge.heard, maps, axis=0)
        knowledge.still = np.repeat(knowledge.still, maps, axis=0)
        knowledge.versions = np.repeat(knowledge.versions, maps, axis=0)
    return knowledge


def place(minds: Minds, where: Any, who: Any = slice(None)) -> None:
    """Set where robots believe to be, float64[n, 2] or one point."""
    points = np.broadcast_to(np.asarray(where, dtype=np.float64), (len(minds.own[who]), 2))
    minds.own["x_m"][who], minds.own["y_m"][who] = points[:, 0], points[:, 1]
