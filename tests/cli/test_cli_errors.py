"""Each mistake of a user is reported in one line, and no data is lost."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from swarmscout import Run
from swarmscout.cli.app import main

SHORT = ("--robots", "3", "--steps", "20", "--destinations", "nearest", "--no-picture")

MISTAKES = [
    (["explode"], 'Unknown command "explode". Did you mean "explore"?'),
    (["explore", "--robot", "3"], "Did you mean --robots?"),
    (["explore", "--robots", "many"], 'convert "many" into int'),
    (["explore", "--robots"], "--robots"),
    (["explore", "--robots", "0"], "key 'robots' = 0: should be greater than or equal to 1"),
    (["explore", "--steps", "-5"], "'steps' = -5"),
    (["explore", "--seed", "-1"], "'seed' = -1"),
    (["explore", "--record", "ful"], 'Did you mean "full"?'),
    (["explore", "--world", "lava-tub"], "lava-tub"),
    (["explore", "--world", "missing.yaml"], "missing.yaml"),
    (["explore", "--world", "broken.yaml"], "broken.yaml"),
    (["explore", "--world", "broken.png"], "broken.png"),
    (["explore", "--destinations", "nearst"], "did you mean 'nearest'?"),
    (["explore", "--destinations", "missing.py:Rule"], "missing.py"),
    (["explore", "--destinations", "broken.py:Rule"], "broken.py"),
    (["explore", "--destinations", "empty.py:Rule"], "Rule"),
    (["explore", "--set", "robots"], "--set 'robots': write KEY=VALUE"),
    (["explore", "--set", "=3"], "write KEY=VALUE"),
    (["explore", "--set", "teams.desired=3"], "did you mean 'desired_size'?"),
    (["explore", "--set", "teams.desired_size=big"], "'teams.desired_size' = 'big'"),
    (["explore", "--set", "robots.few=3"], "'robots' is not a section"),
    (["explore", "--set", "sensor.range_m=nan"], "sensor.range_m"),
    (["explore", "--set", "map.p_free=0.9"], "p_free"),
    (["explore", "--set", "map.p_free=0.4999"], "p_free = 0.4999 says next to nothing"),
    (["explore", "--set", "map.p_occupied=0.5001"], "p_occupied = 0.5001 says next to nothing"),
    (["explore", "--seed", "1.5"], 'unable to convert "1.5" into int: expected a whole number'),
    (["explore", "--robots", "1e3"], "--robots"),
    (["explore", "--steps", "2.5"], "--steps"),
    (["explore", "--start", "spred"], 'Did you mean "spread"?'),
    (
        ["explore", "--robots", "3", "--set", "robots=4"],
        "error: --set robots=4 and --robots are both given: leave one of them out",
    ),
    (["explore", "--set", "robots=3", "--set", "robots=4"], "are both given"),
    (["explore", "--set", "robots=0"], "error: --set: key 'robots' = 0"),
    (["explore", "--robots", "0", "--set", "start=spread"], "error: --robots: key 'robots' = 0"),
    (["explore", "--set", "body.forward_m=1e-300"], "body.forward_m"),
    (["explore", "--set", "renewal.overdue_factor=1e308"], "renewal.overdue_factor"),
    (["explore", "--set", "battery.capacity_steps=1000000000000000000000"], "capacity_steps"),
    (
        ["explore", "paper", "--set", "selector.sigma=wide"],
        "selector 'quantile': sigma = 'wide': should be a valid number",
    ),
    (["explore", "paper", "--set", "selector.sigma=nan"], "sigma = nan: should be a finite number"),
    (
        ["explore", "--destinations", "potential", "--set", "selector.range_m=-3"],
        "selector 'potential': range_m = -3: should be greater than or equal to 0",
    ),
    (
        ["explore", "--destinations", "leaves.py:Rule"],
        "the code called sys.exit(0) (leaves.py, line 2)",
    ),
    (
        ["explore", "--destinations", "divides.py:Rule"],
        "cannot be made: ZeroDivisionError: division by zero (divides.py, line 3)",
    ),
    (["explore", "--destinations", "broken.py:Rule"], "(broken.py, line 1)"),
    (["explore", "nested.toml"], "'nested.toml' is not valid TOML: too many nested brackets"),
    (["explore", "--set", f"robots={'[' * 3000}"], "robots"),
    (["explore", "papr"], "did you mean 'paper'?"),
    (["explore", "missing.toml"], "'missing.toml' does not exist"),
    (["explore", "broken.toml"], "'broken.toml' is not valid TOML"),
    (["explore", "binary.toml"], "'binary.toml' cannot be read: it is not UTF-8 text"),
    (["explore", "full"], "scenario.toml"),
    (["explore", "--out", "full"], "folder 'full' is not empty"),
    (["explore", "--out", "file"], "'file' is a file"),
    (["explore", "--out", "file/below"], "cannot make the run folder 'file/below'"),
    (["explore", "--out", "$NO_SUCH_VARIABLE/x"], "variable $NO_SUCH_VARIABLE is not set"),
    (["explore", "--out", "~no-such-user/x"], "'~no-such-user' has no home folder"),
    (["explore", "--set", "world=$NO_SUCH_VARIABLE/x"], "variable $NO_SUCH_VARIABLE is not set"),
    (["worlds", "import", "no.npy", "--start", "-10,2", "--station", "-1,0"], "'no.npy' does not"),
    (["explore", "--page", "--record", "curves"], "--page needs steps and maps"),
    (["list", "keys", "temas"], "no scenario key contains 'temas': did you mean 'teams'?"),
    (["check", "nearst"], "unknown plug-in 'nearst': did you mean 'nearest'?"),
    (["check", "missing.py:Rule"], "file 'missing.py' does not exist"),
    (["check", "divides.py:Rule", "--kind", "selektor"], "did you mean 'selector'?"),
    (["list", "colours"], 'Unknown command "colours"'),
    (["doctor", "everything"], "everything"),
]


@pytest.mark.parametrize(
    ("words", "message"), MISTAKES, ids=[" ".join(words) for words, _ in MISTAKES]
)
def test_a_mistake_is_one_line(
    words: list[str], message: str, command: Callable[..., tuple[int, str, str]], here: Path
) -> None:
    (here / "full").mkdir()
    (here / "full" / "note.txt").write_text("mine")
    (here / "file").write_text("mine")
    (here / "broken.toml").write_text("robots = [")
    (here / "binary.toml").write_bytes(b"\xff\xfe\x00")
    (here / "broken.yaml").write_text("image: [")
    (here / "broken.png").write_text("no picture")
    (here / "broken.py").write_text("def (")
    (here / "empty.py").write_text("")
    (here / "leaves.py").write_text("import sys\nsys.exit(0)\n")
    (here / "divides.py").write_text(
        "class Rule:\n    def __init__(self):\n        1 / 0\n    def choose(self, v, m): ...\n"
    )
    (here / "nested.toml").write_text(f"robots = {'[' * 5000}{']' * 5000}")
    before = sorted(here.rglob("*"))
    code, _, err = command(*words)
    assert code == 2
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert message in err
    assert "Traceback" not in err
    left = [path for path in sorted(here.rglob("*")) if path not in before]
    assert left in ([], [here / "runs"]), "a mistake left something behind"
    assert (here / "full" / "note.txt").read_text() == "mine"


def test_a_selector_that_fails_keeps_the_run(
    command: Callable[..., tuple[int, str, str]], here: Path
) -> None:
    (here / "mine.py").write_text(
        "class Rule:\n"
        "    def choose(self, view, memory):\n"
        "        raise ZeroDivisionError('no luck')\n"
    )
    code, _, err = command("explore", *SHORT[:4], "--destinations", "mine.py:Rule", "--out", "x")
    assert (code, err.count("\n")) == (2, 1)
    assert "no luck" in err
    run = Run.open(here / "x")
    assert not run.finished
    assert f"steps 0 to {run.last_step} are kept in x" in err
    assert "ZeroDivisionError: no luck (mine.py, line 3)" in err


def test_a_selector_cannot_leave_silently(
    command: Callable[..., tuple[int, str, str]], here: Path
) -> None:
    (here / "mine.py").write_text(
        "import sys\nclass Rule:\n    def choose(self, view, memory):\n        sys.exit(0)\n"
    )
    code, _, err = command("explore", *SHORT[:4], "--destinations", "mine.py:Rule", "--out", "x")
    assert (code, err.count("\n")) == (2, 1)
    assert "the code called sys.exit(0) (mine.py, line 4)" in err


def test_kernels_that_must_not_be_compiled(start: Callable[..., Any], here: Path) -> None:
    child = start("list", "selectors", env={**os.environ, "NUMBA_DISABLE_JIT": "1"})
    out, err = child.communicate()
    assert (child.returncode, out) == (2, "")
    assert err == "error: NUMBA_DISABLE_JIT is set: missions run compiled only, unset it\n"


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX shell")
def test_closed_streams(here: Path) -> None:
    program = f"{sys.executable} -m swarmscout"
    for words, code in (
        ("list policies >&-", 0),
        ("list policies >&- 2>&-", 0),
        ("list colours 2>&-", 2),
        ("list policies >/dev/full", 2),
    ):
        ended = subprocess.run(f"{program} {words}", shell=True, capture_output=True, text=True)
        assert ended.returncode == code, words
        assert "defect" not in ended.stderr


def test_debugging_shows_the_traceback(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SWARMSCOUT_DEBUG", "1")
    with pytest.raises(Exception, match="no-such-world"):
        main(["explore", "--world", "no-such-world"])


def test_a_defect_is_one_line_too(
    command: Callable[..., tuple[int, str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise TypeError("a\ndefect")

    monkeypatch.setattr("swarmscout.mission.scenario_files.load_scenario", fail)
    code, _, err = command("explore")
    assert code == 1
    assert err.startswith("error: defect in swarmscout: TypeError: a defect (SWARMSCOUT_DEBUG")
    assert err.count("\n") == 1


def test_no_place_for_compiled_kernels(
    command: Callable[..., tuple[int, str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("cannot cache function 'move': no locator available for file 'x'")

    monkeypatch.setattr("swarmscout.mission.scenario_files.load_scenario", fail)
    assert command("explore")[::2] == (
        2,
        "error: no folder for compiled kernels is writable: set NUMBA_CACHE_DIR to one\n",
    )


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="POSIX limits")
def test_a_full_disk_is_one_line(start: Callable[..., Any], here: Path) -> None:
    def limit() -> None:  # No file may grow beyond this: as good as a full disk.
        resource.setrlimit(resource.RLIMIT_FSIZE, (12_000, 12_000))

    child = start("explore", "--robots", "15", "--out", "x", preexec_fn=limit)
    out, err = child.communicate()
    assert child.returncode == 2, out
    assert err.startswith("error: cannot write 'x/parts/000000.zip': File too large")
    assert err.count("\n") == 1
    assert not Run.open(here / "x").finished
