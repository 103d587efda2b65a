"""The lists of columns in the documentation, made from the table of what is recorded.

python -m swarmscout.recording.table_page docs/recordings.md
"""

from __future__ import annotations

import sys
from pathlib import Path

from swarmscout.recording.tables import LEVELS, TABLES, Column

__all__ = ["page_with_tables"]

_BEGIN, _END = "<!-- columns: begin -->\n", "<!-- columns: end -->\n"


def page_with_tables(page: str) -> str:
    """A page whose text between the two marks is replaced by what is recorded today."""
    before, _, rest = page.partition(_BEGIN)
    _, _, after = rest.partition(_END)
    return f"{before}{_BEGIN}{_lists()}{_END}{after}"


def _lists() -> str:
    lines: list[str] = []
    for name, table in TABLES.items():
        levels = ", ".join(f"`{level}`" for level, tables in LEVELS.items() if name in tables)
        lines += ["", f"### `{name}`", "", f"{table.meaning[0].upper()}{table.meaning[1:]}.", ""]
        lines += [f"Recorded at level {levels}.", "", "| column | type | unit | meaning |"]
        lines += ["|---|---|---|---|", *map(_line, table.columns)]
    return "\n".join([*lines, "", ""])


def _line(column: Column) -> str:
    kind = column.kind if isinstance(column.kind, str) else "word"
    words = () if isinstance(column.kind, str) else [f"`{word}`" for word in column.kind if word]
    meaning = "; ".join(filter(None, (column.meaning, ", ".join(words))))
    return f"| `{column.name}` | {kind} | {column.unit} | {meaning} |"


if __name__ == "__main__":
    path = Path(sys.argv[1])
    path.write_text(page_with_tables(path.read_text(encoding="utf-8")), encoding="utf-8")
