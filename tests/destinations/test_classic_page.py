"""docs/selectors.md: its example runs and is short, and it names every selector."""

from __future__ import annotations

import re
from pathlib import Path

from swarmscout.destinations.registry import selectors
from swarmscout.testing import check_selector

PAGE = (Path(__file__).parents[2] / "docs" / "selectors.md").read_text(encoding="utf-8")


def test_the_example_is_short_and_sound(tmp_path: Path) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
    assert len(example.splitlines()) < 30
    path = tmp_path / "my.py"
    path.write_text(example, encoding="utf-8")
    assert "Wide" in example
    assert check_selector(f"{path}:Wide", missions=1).answers > 10


def test_every_selector_is_described_and_measured() -> None:
    tables = ("explored area", "cost", "settings", "members")
    for name in selectors():
        assert f"- **`{name}`**: " in PAGE, name
        for table in tables:
            section = PAGE.split(f"<!-- {table} begin -->")[1].split(f"<!-- {table} end -->")[0]
            assert section.count(f"\n| `{name}` |") == 1, (name, table)


def test_attributes_of_the_view_exist() -> None:
    from swarmscout.destinations.view import LeaderView

    table = PAGE.split("| of the view | what |")[1].split("\n\n")[0]
    named = re.findall(r"`(\w+)(?:\([^`]*\))?`", table)
    assert "path_length_m" in named
    known = {*dir(LeaderView), *LeaderView.__dataclass_fields__}
    assert [name for name in named if name not in known] == []
