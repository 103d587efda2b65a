"""The paper's radio: all robots hear each other."""

from __future__ import annotations

from dataclasses import dataclass

from swarmscout.core.links import Links
from swarmscout.robots.bodies import Bodies
from swarmscout.worlds.world import World

__all__ = ["Full"]


@dataclass(frozen=True)
class Full:
    """Every robot hears every other one, wherever they are (the paper's assumption)."""

    def links(self, step: int, bodies: Bodies, world: World) -> Links:
        """All of them."""
        return Links.full(len(bodies.alive))
