"""No module needs itself to be imported, and a registry imports no plug-in before it is used."""

from __future__ import annotations

import subprocess
import sys

import grimp
import networkx as nx
import pytest


def test_there_are_no_circles() -> None:
    """Imports inside functions count, those for type checkers do not."""
    graph = grimp.build_graph("swarmscout", exclude_type_checking_imports=True, cache_dir=None)
    imports = nx.DiGraph(
        (module, used)
        for module in graph.modules
        for used in graph.find_modules_directly_imported_by(module)
    )
    assert "swarmscout.destinations.llm.shortlist" in imports
    assert [sorted(c) for c in nx.strongly_connected_components(imports) if len(c) > 1] == []


@pytest.mark.parametrize(
    ("registry", "plug_in"),
    [
        ("swarmscout.destinations.registry", "swarmscout.destinations.multi_criteria"),
        ("swarmscout.destinations.registry", "swarmscout.destinations.llm.llm"),
        ("swarmscout.teams.registry", "swarmscout.teams.by_mode"),
    ],
)
def test_a_registry_imports_no_plug_in(registry: str, plug_in: str) -> None:
    code = f"import sys, {registry}; sys.exit({plug_in!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
