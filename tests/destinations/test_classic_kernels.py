"""Kernels of the selectors: each is used, and with one signature, whichever way maps are shared."""

from __future__ import annotations

import json
import subprocess
import sys

FLY = """
import json
import numpy as np
from swarmscout import Mission, Scenario
from swarmscout.core.jit import kernels
from swarmscout.destinations.registry import selectors
from swarmscout.testing import small_world

for name in selectors():
    scenario = Scenario(destinations=name, robots=6, steps=40)
    Mission(scenario, world=small_world(1)).run()
    Mission(scenario, world=small_world(1), links=lambda _: np.eye(6, k=1, dtype=bool)).run()
# With a negative weight it is asked with views.
apart = Scenario(destinations="multi-criteria", selector={"apart": -1.0}, robots=6, steps=40)
Mission(apart, world=small_world(1)).run()
fan = Scenario.model_validate({"robots": 6, "steps": 40, "teams": {"members": "fan"}})
Mission(fan, world=small_world(1)).run()
found = {n: [str(s) for s in k.signatures] for n, k in kernels.items() if ".destinations." in n}
print(json.dumps(found))
"""


def test_each_kernel_of_a_selector_has_one_signature() -> None:
    done = subprocess.run([sys.executable, "-c", FLY], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    signatures: dict[str, list[str]] = json.loads(done.stdout.splitlines()[-1])
    assert len(signatures) >= 8
    assert {name: kinds for name, kinds in signatures.items() if len(kinds) != 1} == {}
