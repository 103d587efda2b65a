from __future__ import annotations

import subprocess
import sys
from types import ModuleType

import swarmscout


def test_all_is_what_the_module_shows() -> None:
    for name in swarmscout.__all__:
        assert getattr(swarmscout, name) is not None
    assert dir(swarmscout) == sorted(swarmscout.__all__)
    shown = {
        name
        for name, value in vars(swarmscout).items()
        if not name.startswith("_")
        and not isinstance(value, ModuleType)
        and name not in ("annotations", "TYPE_CHECKING", "Any")
    }
    assert shown == set(swarmscout.__all__) - {"__version__"}


def test_names_are_sorted_and_lead_home() -> None:
    assert list(swarmscout.__all__) == sorted(swarmscout.__all__)
    assert set(swarmscout._HOME) == set(swarmscout.__all__) - {"__version__"}


def test_an_unknown_name_is_an_attribute_error() -> None:
    assert not hasattr(swarmscout, "Missions")


def test_importing_costs_nothing() -> None:
    program = (
        "import sys, swarmscout; dir(swarmscout); swarmscout.SwarmscoutError; print(*sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert not {"numpy", "numba", "polars", "pydantic", "cyclopts"} & set(done.stdout.split())
