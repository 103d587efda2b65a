"""Values of options: paths, numbers below zero, short names; output for other programs."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from swarmscout import Run, Scenario
from swarmscout.cli.app import main
from swarmscout.cli.values import with_values_joined
from swarmscout.core.errors import SwarmscoutError
from swarmscout.core.paths import expanded

Command = Callable[..., tuple[int, str, str]]
SHORT = ("-n", "2", "--steps", "5", "--no-picture")


@pytest.fixture
def home(here: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A home folder, with a room as an array in it."""
    folder = here / "home"
    folder.mkdir()
    monkeypatch.setenv("HOME", str(folder))
    monkeypatch.setenv("MAPS", str(folder))
    room = np.zeros((60, 60), dtype=bool)
    room[2:-2, 2:-2] = True
    np.save(folder / "room.npy", room)
    return folder


@pytest.mark.parametrize("out", ["~/run", "$HOME/run", "${HOME}/run"])
def test_a_home_folder_in_an_option(command: Command, home: Path, out: str) -> None:
    assert command("explore", *SHORT, f"--out={out}")[0] == 0
    assert Run.open(home / "run").finished
    assert Run.open("~/run").finished
    assert sorted(path.name for path in home.parent.iterdir()) == ["home"]


@pytest.mark.parametrize("world", ["~/room.npy", "$MAPS/room.npy", "${MAPS}/room.npy"])
def test_a_home_folder_in_a_scenario(command: Command, home: Path, world: str) -> None:
    assert command("explore", *SHORT, "--set", f"world={world}", "-o", "a")[0] == 0
    assert command("explore", *SHORT, "--world", world, "-o", "b")[0] == 0
    Path("mine.toml").write_text(f'world = "{world}"\n', encoding="utf-8")
    assert command("explore", "mine.toml", *SHORT, "-o", "c")[0] == 0
    assert command("worlds", "show", world, "--out", "~/room.png")[0] == 0
    assert (home / "room.png").exists()


def test_a_dollar_or_tilde_within_a_name_stays(home: Path) -> None:
    assert expanded("maps/cost$of~all.yaml") == Path("maps/cost$of~all.yaml")
    with pytest.raises(SwarmscoutError, match="NOT_SET"):
        expanded("$NOT_SET/a.yaml")


@pytest.mark.parametrize(
    ("words", "joined"),
    [
        (["--start", "-10,2"], ["--start=-10,2"]),
        (["--start", "-.5,-2,-1"], ["--start=-.5,-2,-1"]),
        (["--station", "-1,0", "--station", "2,3"], ["--station=-1,0", "--station", "2,3"]),
        (["doctor", "--llm"], ["doctor", "--llm=auto"]),
        (["--llm", "--llm-model", "m"], ["--llm=auto", "--llm-model", "m"]),
        (["--llm", "embedded"], ["--llm", "embedded"]),
        (["-n", "-5"], ["-n=-5"]),
        (["--set", "body.radius_m=-1", "-q"], ["--set", "body.radius_m=-1", "-q"]),
        (["--browser", "--no-picture"], ["--browser", "--no-picture"]),
    ],
)
def test_values_below_zero_belong_to_their_option(words: list[str], joined: list[str]) -> None:
    assert with_values_joined(words) == joined


def test_places_below_zero(command: Command, home: Path) -> None:
    yaml = home / "map.yaml"
    from PIL import Image

    Image.fromarray(np.full((60, 60), 254, dtype=np.uint8)).save(home / "map.png")
    yaml.write_text(
        "image: map.png\nresolution: 0.1\norigin: [-3.0, -3.0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
        encoding="utf-8",
    )
    code, out, err = command(
        "worlds", "import", str(yaml), "--start", "-1.5,-.5", "--station", "-2,-1", "--out", "w"
    )
    assert (code, err) == (0, "")
    assert "start: -1.50,-0.50 m" in out


def test_quiet_says_nothing(command: Command, here: Path) -> None:
    assert command("explore", *SHORT, "-q", "-s", "3", "-d", "nearest", "-o", "x") == (0, "", "")
    scenario = Run.open("x").scenario
    assert (scenario.robots, scenario.seed, scenario.destinations) == (2, 3, "nearest")


def test_json_is_the_run_and_its_summary(command: Command, here: Path) -> None:
    code, out, _ = command("explore", *SHORT, "--json", "-o", "x")
    told = json.loads(out)
    assert (code, told["run"]) == (0, "x")
    kept = json.loads((here / "x" / "summary.json").read_text("utf-8"))
    assert told["summary"].items() <= kept.items()
    assert set(kept) - set(told["summary"]) == {"files", "checksum"}


@pytest.mark.parametrize("what", ["selectors", "policies", "worlds", "keys"])
def test_lists_as_json(command: Command, what: str) -> None:
    code, out, _ = command("list", what, "--json")
    assert code == 0
    assert len(json.loads(out)) > 1


def test_keys_with_their_ranges(command: Command) -> None:
    code, out, _ = command("list", "keys", "robots")
    assert code == 0
    assert out.startswith("robots = 15  (from 1 to 100,000)\n    ")
    keys = json.loads(command("list", "keys", "--json")[1])
    for name in ("teams.desired_size", "llm.temperature", "map.cell_m"):
        assert next(key for key in keys if key["key"] == name)["range"], name
    assert {key["key"].split(".")[0] for key in keys} == set(Scenario.model_fields)


def test_the_schema_describes_every_section(command: Command) -> None:
    schema = json.loads(command("schema")[1])
    assert set(schema["properties"]) == set(Scenario.model_fields)
    assert schema["properties"]["robots"]["maximum"] == 100_000


@pytest.mark.parametrize(("name", "kind"), [("nearest", "selector"), ("by-mode", "policy")])
def test_a_sound_plug_in_passes_its_check(command: Command, name: str, kind: str) -> None:
    code, out, err = command("check", name)
    assert (code, err) == (0, "")
    assert out.startswith(f"{kind} '{name}' is sound")


def test_an_unsound_plug_in_fails_its_check(command: Command, here: Path) -> None:
    (here / "mine.py").write_text(
        "class Rule:\n    def choose(self, view, memory):\n        return None\n"
        "class Nothing: ...\n",
        encoding="utf-8",
    )
    code, _, err = command("check", "mine.py:Rule")
    assert (code, err.count("\n")) == (2, 1)
    assert "mine.py:Rule" in err
    code, _, err = command("check", "mine.py:Nothing")
    assert (code, err.count("\n")) == (2, 1)
    assert "choose(view, memory)" in err
    assert "desired(view)" in err


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_can_be_installed(command: Command, home: Path, shell: str) -> None:
    code, out, err = command("--install-completion", shell)
    assert (code, err) == (0, "")
    file = Path(out.split(": ", 1)[1].split(";")[0])
    assert file.is_relative_to(home)
    assert "swarmscout" in file.read_text("utf-8")
    assert os.stat(file).st_size > 1000


def test_without_words_the_help_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    assert "explore" in capsys.readouterr().out
