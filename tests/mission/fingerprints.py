"""Fingerprints of whole missions: a change of behaviour that was not intended shows at once.

Each mission's trajectory is hashed part by part, so that a difference says where it lies. After an
intended change raise RULES_VERSION and run ``python tests/mission/fingerprints.py``.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from swarmscout import Mission, Scenario, World
from swarmscout.core.language_model import Reply, Request
from swarmscout.mission.mission import RULES_VERSION
from swarmscout.testing import small_world
from swarmscout.worlds import Mesh, world_from_array

FILE = Path(__file__).with_name("fingerprints.json")
SELECTORS = (
    "random", "quantile", "quantile-local", "nearest", "nearest-euclidean", "utility",
    "information-gain", "minpos", "hungarian", "voronoi", "potential", "llm-like", "multi-criteria",
)  # fmt: skip
BATTERY = {"capacity_steps": 150, "start_min": 0.3}
FAN = {"teams": {"members": "fan"}}
LITERAL = {"routes": {"cost": "probability"}, "renewal": {"rule": "reached", "avoid_steps": 0}}
Case = dict[str, Any]


class LastCandidate:
    """A model that always answers with the last candidate it is offered."""

    def complete(self, request: Request) -> Reply:
        text = request.messages[-1].text
        offered = re.findall(r"\(\((\d+,\d+)\),3,", text) or re.findall(r"^([A-Z]): ", text, re.M)
        answer = {"candidates": [], "choice": offered[-1] if offered else "A", "reason": "last"}
        return Reply(text=json.dumps(answer), tokens_in=10, tokens_out=5)


def cases() -> dict[str, Case]:
    """Names of the missions, each with what it is run with."""
    found: dict[str, Case] = {}

    def add(
        name: str, links: str = "", world: int | str = 1, steps: int = 120, **keys: Any
    ) -> None:
        scenario = {"robots": 10, "steps": steps, "seed": len(found), "battery": BATTERY, **keys}
        found[name] = {"links": links, "world": world, "scenario": scenario}

    for selector in SELECTORS:
        add(f"{selector}, shared", destinations=selector)
    for selector in ("quantile", "nearest", "hungarian", "multi-criteria"):
        add(f"{selector}, separate, all linked", "all", destinations=selector)
        add(f"{selector}, partial links", "flapping", world=2, destinations=selector)
    for links in ("none", "one-way", "halves", "sparse"):
        add(f"multi-criteria, {links} links", links, world=3, destinations="multi-criteria")
    for policy in ("by-mode", "by-crowd"):
        for links in ("", "flapping"):
            teams = {"policy": policy, "leave_rule": "general", "desired_size": 4}
            add(f"{policy}, {links or 'shared'}", links, teams=teams, destinations="nearest")
    for links in ("", "all", "flapping"):
        add(f"fan, {links or 'shared'}", links, destinations="multi-criteria", **FAN)
        add(f"paper-literal, {links or 'shared'}", links, **LITERAL)
    add("team position center", teams={"position": "center"}, destinations="minpos")
    add("spread", start="spread", destinations="multi-criteria", world=4)
    add("return by distance", battery={**BATTERY, "return_rule": "distance"}, steps=200)
    noisy = {"position_noise_m": 0.05, "heading_noise_deg": 3.0, "turn_deg": 30, "radius_m": 0.2}
    add("noisy poses", body=noisy, sensor={"range_m": 2, "rays": 5, "noise_m": 0.05})
    add("cells of 1 m", map={"cell_m": 1.0, "frontier_neighbours": 4})
    add("mesh", world="mesh", sensor={"sensing": "mesh"}, destinations="multi-criteria")
    add("mesh, flapping", "flapping", "mesh", sensor={"sensing": "mesh"})
    add("language model", destinations="llm", selector={"warm_up_steps": 5})
    add("language model, late", destinations="llm-shortlist", llm={"latency_steps": 3})
    for robots, steps in ((1, 200), (2, 200), (50, 120), (100, 60), (300, 40)):
        for start in ("one-place", "spread"):
            keys = {"robots": robots, "start": start, "destinations": "multi-criteria"}
            add(f"N = {robots}, {start}", world="lava-tube", steps=steps, battery={}, **keys)
    add("lava-maze", world="lava-maze", steps=200, battery={}, start="spread", robots=30)
    return found


def links_of(kind: str, robots: int) -> Callable[[int], np.ndarray] | None:
    """Who hears whom in a step, the same whenever asked."""
    everybody = np.ones((robots, robots), dtype=np.bool_)

    def flapping(step: int, share: float = 0.4) -> np.ndarray:
        draws = np.random.default_rng((robots, step // 5)).random((robots, robots))
        upper = np.triu(draws < share, 1)
        return upper | upper.T

    def one_way(step: int) -> np.ndarray:
        return np.random.default_rng((robots, step // 3)).random((robots, robots)) < 0.5

    def halves(step: int) -> np.ndarray:
        half = np.arange(robots) < robots // 2
        return everybody if step % 40 < 10 else half[:, None] == half[None, :]

    kinds: dict[str, Callable[[int], np.ndarray]] = {
        "all": lambda step: everybody,
        "none": lambda step: ~everybody,
        "flapping": flapping,
        "sparse": lambda step: flapping(step, 0.1),
        "one-way": one_way,
        "halves": halves,
    }
    return kinds.get(kind)


@cache
def world_of(name: int | str) -> World | str:
    """A small world by its seed, a hall with a wall of triangles, or a name."""
    if isinstance(name, int):
        return small_world(name)
    if name == "mesh":
        room = np.ones((90, 90), dtype=np.uint8)
        slab = Mesh([[4, 0, -1], [4, 5, -1], [4, 0, 2]], [[0, 1, 2]])
        ground = np.zeros(room.shape, dtype=np.float32)
        return world_from_array(room, ground_m=ground, mesh=slab)
    return name


def mission_of(case: Case) -> Mission:
    """The mission of a case, before its first step."""
    world, keys = world_of(case["world"]), dict(case["scenario"])
    given: dict[str, Any] = {"links": links_of(case["links"], keys["robots"])}
    if isinstance(world, World):
        given["world"] = world
    else:
        keys |= {"world": world, "world_seed": 0}
    if str(keys.get("destinations")).startswith("llm") and keys["destinations"] != "llm-like":
        given["model"] = LastCandidate()
    return Mission(Scenario.model_validate(keys), **given)


class Digest:
    """Running hashes of a mission's parts."""

    def __init__(self) -> None:
        self._parts: dict[str, Any] = {}

    def add(self, part: str, *values: Any) -> None:
        """Take values into a part's hash."""
        part_hash = self._parts.setdefault(part, hashlib.sha256())
        for value in values:
            array = np.ascontiguousarray(value) if isinstance(value, np.ndarray) else None
            part_hash.update(repr(value).encode() if array is None else array.tobytes())

    def parts(self) -> dict[str, str]:
        """The first digits of each part's hash."""
        return {name: part.hexdigest()[:12] for name, part in self._parts.items()}


def fingerprint_of(case: Case) -> Mapping[str, str]:
    """Run a mission and hash what it does.

    Returns:
        Hashes of bodies, teams, destinations, decisions and maps.
    """
    mission, digest = mission_of(case), Digest()
    while not mission.done:
        mission.step()
        bodies, minds = mission.bodies, mission.minds
        digest.add("bodies", bodies.position, bodies.heading, bodies.charge, bodies.alive)
        digest.add("actions", mission.action, bodies.contact)
        living = bodies.alive
        digest.add("teams", minds.team[living], minds.leader[living], minds.mode[living])
        digest.add("teams", minds.desired[living])
        digest.add("destinations", minds.destination[living], minds.target[living])
        for d in mission.decisions:
            digest.add("decisions", (d.step, d.team, d.leader, d.cause, d.cell, d.frontiers))
            digest.add("decisions", (d.frontier_neighbours, d.obstacle_neighbours, d.distance_m))
    digest.add("maps", mission.map.evidence)
    for robot in np.flatnonzero(mission.bodies.alive):
        digest.add("maps", mission.map_of(int(robot)).evidence)
    digest.add("summary", mission.step_number, mission.end_reason, mission.explored_m2)
    return digest.parts()


def main() -> None:
    """Make the file anew."""
    missions = {}
    for name, case in cases().items():
        missions[name] = dict(fingerprint_of(case))
        print(name, missions[name]["summary"], file=sys.stderr)
    content = {
        "made_by": "python tests/mission/fingerprints.py",
        "rules_version": RULES_VERSION,
        "missions": missions,
    }
    FILE.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
