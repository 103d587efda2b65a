"""The package's shape: who may import whom, one signature per kernel, files of readable length."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import swarmscout

SOURCE = Path(swarmscout.__file__).parent
ROOT = Path(__file__).parents[2]
MODULES = sorted(SOURCE.rglob("*.py"))
MINDS = ("minds", "mapping", "comms", "teams", "destinations", "planning", "tasks")
OUTSIDE = (
    "asyncio", "concurrent", "ftplib", "http", "httpx2", "multiprocessing", "openai", "requests",
    "socket", "ssl", "subprocess", "threading", "urllib", "xllamacpp",
)  # fmt: skip
BODIES = ("swarmscout.worlds", "swarmscout.robots", "swarmscout.mission", "swarmscout.recording")
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join([str(SOURCE.parent), *sys.path])}

FLY = """
import importlib, json, pkgutil, sys
import numpy as np
import swarmscout
import swarmscout as ss
for module in pkgutil.walk_packages(swarmscout.__path__, "swarmscout."):
    if not module.name.endswith("__main__"):
        importlib.import_module(module.name)
from swarmscout import Mission, Scenario
from swarmscout.core.jit import kernels
from swarmscout.destinations.registry import selectors
from swarmscout.destinations.selector import Choice
from swarmscout.tasks.task import Task
from swarmscout.teams.registry import policies
from swarmscout.testing import small_world
from swarmscout.worlds import Mesh, world_from_array

class SizedByAll:
    def desired(self, view):
        near = view.frontiers_within(2.0) + view.robots_within(2.0) + view.strangers_within(3)
        return np.clip(near + view.frontiers + view.teams, 1, 5)

def fly(links=None, world=None, sizes=None, task=None, **keys):
    given = {"robots": 6, "steps": 60, "battery": {"capacity_steps": 60, "start_min": 0.4}, **keys}
    mission = Mission(Scenario.model_validate(given), world=world or small_world(1), links=links,
                      policy=sizes, task=task)
    if keys == {}:
        mission.destinations.selector = LooksAtAll()
    mission.run()

class FreeCells(Task):
    def candidates(self, map, step):
        return map.labels == 1

class LooksAtAll:
    def choose(self, view, memory):
        for name in dir(view):
            if not name.startswith("_"):
                getattr(view, name)
        view.route_costs(), view.unknown_m2(2.0), view.neighbour_counts((3, 3))
        return Choice(tuple(view.frontiers[-1]))

room = np.ones((60, 60), dtype=np.uint8)
slab = Mesh([[4, 0, -1], [4, 5, -1], [4, 0, 2]], [[0, 1, 2]])
hill = world_from_array(room, ground_m=np.zeros(room.shape, dtype=np.float32), mesh=slab)
fly(world=hill, sensor={"sensing": "mesh"})
fly()
for name in selectors():
    fly(destinations=name)
fly(destinations="nearest", start="spread", teams={"leave_rule": "general", "position": "center"})
fly(destinations="multi-criteria", teams={"position": "center"})  # Asked with views.
for name in policies():
    fly(teams={"policy": name})
for links in (None, lambda step: np.eye(6, k=step % 3, dtype=bool)):
    fly(links=links, sizes=SizedByAll(), teams={"leave_rule": "general"})
fly(links=lambda step: np.eye(6, k=step % 3, dtype=bool))
fly(links=lambda step: np.full((6, 6), step % 4 > 1))  # Groups part, and join again.
ss.record_mission(Scenario(robots=3, steps=9), links=lambda _: np.eye(3) > 0).map_at(robot=1)
fly(teams={"members": "fan", "fan_m": 3})
fly(battery={"return_rule": "distance"})
fly(teams={"members": "fan", "fan_m": 3}, task=FreeCells())
fly(links=lambda step: np.ones((6, 6), dtype=bool), teams={"members": "fan"})
fly(
    body={"position_noise_m": 0.1, "heading_noise_deg": 5.0, "turn_deg": 30, "radius_m": 0.2},
    map={"frontier_neighbours": 4, "cell_m": 1}, routes={"cost": "probability"},
    renewal={"rule": "reached", "avoid_steps": 0}, sensor={"range_m": 2, "rays": 1, "noise_m": 0},
    battery={"enabled": False, "return_rule": "distance", "charge_per_step": 5},
    teams={"d_join_m": 3},
)
from swarmscout.worlds.arrays import world_from_array
fly(world=world_from_array(small_world(2).free, 0.1, origin_m=(3, -2), start_m=(10, 5)))
print(json.dumps({name: [str(s) for s in k.signatures] for name, k in kernels.items()}))
"""


def name_of(path: Path) -> str:
    return str(path.relative_to(SOURCE))


def test_the_contracts_on_imports_hold() -> None:
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            "from importlinter.cli import lint_imports_command as c; c()",
            "--no-cache",
        ],
        cwd=ROOT,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 broken" in done.stdout


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_a_module_is_one_idea(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 400


@pytest.mark.parametrize(
    "path", [path for path in MODULES if path.relative_to(SOURCE).parts[0] in MINDS], ids=name_of
)
def test_rooms_of_minds_do_not_name_the_truth(path: Path) -> None:
    """Stricter than the contract on imports: no string or late import leads there either."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        named = []
        if isinstance(node, ast.Import):
            named = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            named = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            named = [node.value]
        for text in named:
            assert not any(room in text for room in BODIES), f"{path.name} names {text!r}"


@pytest.mark.parametrize(
    "path", [path for path in MODULES if path.relative_to(SOURCE).parts[0] in MINDS], ids=name_of
)
def test_rooms_of_minds_use_no_network_thread_or_process(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [str(node.module)]
        for name in names:
            assert name.split(".")[0] not in OUTSIDE, f"{path.name} imports {name}"


def test_each_kernel_has_one_signature() -> None:
    done = subprocess.run(
        [sys.executable, "-c", FLY], env=ENVIRONMENT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    signatures: dict[str, list[str]] = json.loads(done.stdout.splitlines()[-1])
    many = {name: kinds for name, kinds in signatures.items() if len(kinds) > 1}
    assert many == {}
    idle = {name for name, kinds in signatures.items() if not kinds}
    # Kernels that make, load or draw worlds do not run in a mission.
    assert not {name for name in idle if not name.startswith("swarmscout.worlds.")}


def test_there_is_no_global_randomness() -> None:
    for path in MODULES:
        if "testing" in path.relative_to(SOURCE).parts:
            continue  # The check of selectors watches the global generators.
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                assert "random" not in [alias.name for alias in node.names], path.name
            if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "np.random":
                assert node.attr in ("Generator", "PCG64", "default_rng", "bit_generator")
            if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("default_rng"):
                assert node.args, f"{path.name}: a generator without a seed"
