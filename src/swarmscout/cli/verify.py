"""``swarmscout verify``: is a run what was written?"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

__all__ = ["verify"]


def verify(*runs: Annotated[Path, Parameter(name="RUN")]) -> int:
    """Read all of some runs and compare them with their checksums.

    The exit code is 2 if anything is damaged.

    Args:
        runs: run folders, of finished missions or of killed ones.
    """
    from swarmscout.core.errors import RunError
    from swarmscout.recording.verify import verify_run

    if not runs:
        raise RunError("give one run or more to verify")
    damaged = 0
    for run in runs:
        verdict = verify_run(run)
        damaged += bool(verdict.faults)
        for fault in verdict.faults:
            print(f"{run}: {fault}", file=sys.stderr)
        if not verdict.faults:
            print(f"{run}: {verdict.checked} checks, no damage")
        for note in verdict.notes:
            print(f"{run}: {note}")
    return 2 if damaged else 0
