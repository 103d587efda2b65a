"""Mutation testing: how many small faults in a room's code do the room's tests notice?

A copy of the tree is changed in one place, the tests of the changed room run until one fails, and
the outcome is kept: killed, timeout (counts as killed) or survived. A run that was stopped goes on
where it was; `make mutants` calls this script.

    python tests/mutation/run.py --rooms comms,teams --sample 40 --seed 1

Cosmic Ray makes the mutants. Its own runner takes no samples and has one command for all rooms.
mutmut leaves decorated functions alone, and so every kernel.
"""

from __future__ import annotations

import argparse
import contextlib
import filecmp
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

from mutants import Mutant, mutants_of

ROOT = Path(__file__).parents[2]
PACKAGE = "src/swarmscout"
MISSIONS = (
    "mission/test_fingerprints.py",
    "mission/test_explored_area_and_end.py",
    "mission/test_capabilities.py",
    "mission/test_shared_and_separate_maps.py",
)
ROOMS: dict[str, tuple[str, ...]] = {
    "core": ("core", *MISSIONS, "destinations/test_registry.py", "studies/test_study_file.py"),
    "comms": ("comms", *MISSIONS, "architecture/test_blindfold.py"),
    "mapping": ("mapping", *MISSIONS),
    "minds": (*MISSIONS, "teams"),
    "teams": ("teams", *MISSIONS, "testing/test_check_policy.py", "architecture"),
    "planning": ("planning", *MISSIONS),
    "destinations": ("destinations", *MISSIONS, "testing/test_check_selector.py", "architecture"),
    "robots": ("robots", *MISSIONS, "testing/test_check_sensor.py"),
    "mission": (*MISSIONS, "mission", "cli/test_cli_explore.py", "recording"),
}
"""The tests of each room, in the order in which they run; those of the first fail soonest."""

KEPT = ("src", "tests", "pyproject.toml", "README.md", "docs", "Makefile", "CHANGELOG.md")


def main() -> None:
    given = arguments()
    given.work.mkdir(parents=True, exist_ok=True)
    tree = given.work / "tree"
    copy_tree(tree)
    results = given.work / "results.jsonl"
    known = {row["source"]: row for row in read(results)}
    shown = []
    for room in given.rooms:
        chosen = choose(tree / PACKAGE, room, given)
        if given.list:
            print(*(mutant.name for mutant in chosen), sep="\n")
            continue
        if not given.trust:
            check_green(tree, room, given)
        for mutant in chosen:
            text = mutant.source(tree / PACKAGE)
            source = hashlib.blake2b(text.encode(), digest_size=12).hexdigest()
            if source not in known:
                tried = try_mutant(tree, room, mutant.file, text, given)
                row = {"room": room, "mutant": mutant.name, "source": source, **tried}
                known[source] = row
                with results.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(row) + "\n")
                print(f"{row['outcome']:9}{row['seconds']:6.0f} s  {mutant.name}", flush=True)
            shown.append(known[source])
    if not given.list:
        report(shown)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rooms", default=",".join(ROOMS), help="comma-separated; default: all")
    parser.add_argument("--sample", type=int, help="mutants per room; default: all")
    parser.add_argument("--seed", type=int, default=0, help="of the sample")
    parser.add_argument("--files", default="", help="only files whose path contains this text")
    parser.add_argument("--timeout", type=float, default=900.0, help="seconds for one mutant")
    parser.add_argument("--work", type=Path, default=ROOT / "build" / "mutants", help="folder")
    parser.add_argument("--quick", action="store_true", help="own tests and fingerprints alone")
    parser.add_argument("--trust", action="store_true", help="skip the run without a mutant")
    parser.add_argument("--list", action="store_true", help="name the mutants and run nothing")
    given = parser.parse_args()
    given.rooms = given.rooms.split(",")
    unknown = [room for room in given.rooms if room not in ROOMS]
    if unknown:
        parser.error(f"unknown room '{unknown[0]}': expected some of {', '.join(ROOMS)}")
    return given


def check_green(tree: Path, room: str, given: argparse.Namespace) -> None:
    """A room's tests must pass before a failure can mean anything; this also compiles kernels."""
    outcome, by = run_tests(tree, room, given)
    if outcome != "survived":
        sys.exit(f"room '{room}': tests fail without a mutant: {outcome} {by}")


def copy_tree(tree: Path) -> None:
    """Bring the copy up to date. Files that are the same keep their times, and so their kernels."""
    for name in KEPT:
        for source in [ROOT / name, *(ROOT / name).rglob("*")]:
            target = tree / source.relative_to(ROOT)
            if source.is_dir() or "__pycache__" in source.parts:
                continue
            if target.exists() and filecmp.cmp(source, target, shallow=False):
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
        for target in (tree / name).rglob("*.*"):
            known = "__pycache__" in target.parts or (ROOT / target.relative_to(tree)).exists()
            if target.is_file() and not known:
                target.unlink()


def choose(package: Path, room: str, given: argparse.Namespace) -> list[Mutant]:
    """The room's mutants, or a sample of them."""
    files = [str(path.relative_to(package)) for path in sorted((package / room).rglob("*.py"))]
    # Those that ask language models have their tests with the provider's.
    files = [file for file in files if "destinations/llm/" not in file and given.files in file]
    every = [mutant for file in files for mutant in mutants_of(package, file)]
    if given.sample is None:
        return every
    return random.Random(f"{room} {given.seed}").sample(every, min(given.sample, len(every)))


def try_mutant(
    tree: Path, room: str, file: str, text: str, given: argparse.Namespace
) -> dict[str, object]:
    """Run the room's tests with a file's text replaced."""
    path = tree / PACKAGE / file
    right = path.read_text(encoding="utf-8")
    began = time.monotonic()
    try:
        path.write_text(text, encoding="utf-8")
        outcome, by = run_tests(tree, room, given)
    finally:
        path.write_text(right, encoding="utf-8")
    return {"outcome": outcome, "by": by, "seconds": round(time.monotonic() - began, 1)}


def run_tests(tree: Path, room: str, given: argparse.Namespace) -> tuple[str, str]:
    """What a room's tests say: the outcome, and the first test that failed."""
    names = [name for name in ROOMS[room] if not given.quick or name in (room, MISSIONS[0])]
    tests = [f"tests/{name}" for name in names]
    running = subprocess.Popen(
        [sys.executable, "-m", "pytest", "-qx", "--tb=no", "-n0", "-pno:cacheprovider", *tests],
        cwd=tree,
        env={**os.environ, "PYTHONPATH": str(tree / "src")},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )
    try:
        said = running.communicate(timeout=given.timeout)[0].decode(errors="replace")
    except subprocess.TimeoutExpired:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(running.pid, signal.SIGKILL)
        running.wait()
        return "timeout", ""
    failed = [line for line in said.splitlines() if line.startswith(("FAILED", "ERROR"))]
    by = failed[0][:200] if failed else f"exit code {running.returncode}"
    return ("survived", "") if running.returncode == 0 else ("killed", by)


def read(results: Path) -> list[dict[str, str]]:
    if not results.exists():
        return []
    return [json.loads(line) for line in results.read_text(encoding="utf-8").splitlines()]


def report(rows: list[dict[str, str]]) -> None:
    """Print what survived, and the share of it in each room."""
    survivors = [row["mutant"] for row in rows if row["outcome"] == "survived"]
    print("\nSurvivors:", *(survivors or ["none"]), sep="\n  ")
    print(f"\n{'room':14}{'tried':>7}{'killed':>8}{'timeout':>9}{'survived':>10}{'rate':>7}")
    for room in [*ROOMS, "all"]:
        count = Counter(row["outcome"] for row in rows if room in (row["room"], "all"))
        tried = count.total()
        if tried:
            print(
                f"{room:14}{tried:7}{count['killed']:8}{count['timeout']:9}"
                f"{count['survived']:10}{count['survived'] / tried:7.0%}"
            )


if __name__ == "__main__":
    main()
