"""What every selector chooses in frozen situations, kept as cells; run this file to make them anew.

After an intended change of a selector, or of the situations, run
``python tests/destinations/golden_choices.py`` and read the difference.
"""

from __future__ import annotations

import json
from pathlib import Path

from swarmscout.destinations.registry import SELECTORS, make_selector
from swarmscout.testing import situations

FILE = Path(__file__).with_name("golden_choices.json")
SEEDS = range(3)


def choices(name: str) -> dict[str, list[list[int]]]:
    """Cells that a selector chooses at first, and then with what it remembered of that choice."""
    selector = make_selector(name)
    found = {}
    for seed in SEEDS:
        for situation in situations(seed):
            view = situation.view
            first = selector.choose(view.among(view.frontiers[:, 0] >= 0), None)
            second = selector.choose(view.among(view.frontiers[:, 0] >= 0), first.memory)
            cells = [[int(row), int(col)] for row, col in (first.cell, second.cell)]
            found[f"{situation.words}, seed {seed}"] = cells
    return found


def main() -> None:
    """Make the file anew."""
    lines = []
    for name in SELECTORS.built_in:
        rows = [f"  {json.dumps(words)}: {cells}" for words, cells in choices(name).items()]
        lines.append(f" {json.dumps(name)}: {{\n" + ",\n".join(rows) + "\n }")
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
