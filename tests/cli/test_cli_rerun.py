"""``explore RUN`` runs what was recorded or says why not; ``verify`` says what is damaged."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from swarmscout import Scenario, explore, record_mission
from swarmscout.core.language_model import Reply, Request
from swarmscout.destinations.nearest import Nearest
from swarmscout.mission.mission import RULES_VERSION
from swarmscout.recording.json_files import read_json, write_json

Command = Callable[..., tuple[int, str, str]]
SMALL = {"world": "lava-tube-small", "robots": 3, "steps": 5, "destinations": "nearest"}
AGAIN = ("--no-picture", "--out", "again")


class Parrot:
    def complete(self, request: Request) -> Reply:
        return Reply(text="1", model="parrot")


@pytest.mark.parametrize("what", ["run", "run/scenario.toml"])
def test_links_from_python_are_refused(what: str, command: Command, here: Path) -> None:
    record_mission(Scenario(**SMALL), out="run", links=lambda _: np.eye(3) > 0)  # type: ignore[arg-type]
    code, out, err = command("explore", what, *AGAIN)
    assert (code, out) == (2, "")
    assert "cannot be run again: its links were a Python function" in err
    assert not (here / "again").exists()


def test_a_model_from_python_is_refused_unless_another_is_named(command: Command) -> None:
    keys = {**SMALL, "destinations": "llm-shortlist", "llm": {"provider": "openai"}}
    record_mission(Scenario(**keys), out="run", model=Parrot())  # type: ignore[arg-type]
    code, _, err = command("explore", "run", *AGAIN)
    assert code == 2
    assert "its language model was a Python object" in err
    _, _, err = command("explore", "run", "--llm", "http://127.0.0.1:9/v1", *AGAIN)
    assert "was a Python object" not in err


def test_a_selector_from_python_is_refused(command: Command, here: Path) -> None:
    keys = {key: value for key, value in SMALL.items() if key != "destinations"}
    explore(**keys, destinations=Nearest(), out="run")  # type: ignore[arg-type]
    code, _, err = command("explore", "run", *AGAIN)
    assert code == 2
    assert "selector 'object:Nearest' was an object in memory" in err
    assert not (here / "again").exists()


def test_another_rules_version_is_said(command: Command, here: Path) -> None:
    record_mission(Scenario(**SMALL), out="run")  # type: ignore[arg-type]
    assert command("explore", "run", *AGAIN)[::2] == (0, "")
    for name in ("run.json", "summary.json"):  # As an editor changes it, without new checksums.
        file = here / "run" / name
        text = file.read_text()
        file.write_text(text.replace(f'"rules_version": {RULES_VERSION}', '"rules_version": 99'))
        assert file.read_text() != text
    shutil.rmtree("again")
    code, _, err = command("explore", "run", *AGAIN)
    assert code == 0
    assert err == (
        "note: run 'run' was recorded under rules version 99, and this swarmscout has "
        f"{RULES_VERSION}: the "
        "mission will not be the same\n"
    )


def test_an_edited_scenario_and_another_world_are_refused(command: Command, here: Path) -> None:
    record_mission(Scenario(**SMALL), out="run")  # type: ignore[arg-type]
    shutil.copytree("run", "other")
    facts = read_json(here / "other" / "run.json") or {}
    facts["world"]["source"]["digest"] = "0" * 64
    write_json(here / "other" / "run.json", facts)
    code, _, err = command("explore", "other", *AGAIN)
    assert code == 2
    assert "generates another 'lava-tube-small'" in err
    assert command("explore", "other", "--world", "lava-tube-small", *AGAIN)[0] == 0
    text = (here / "run" / "scenario.toml").read_text()
    (here / "run" / "scenario.toml").write_text(text.replace("robots = 3", "robots = 4"))
    code, _, err = command("explore", "run", *AGAIN)
    assert code == 2
    assert "scenario.toml' is damaged" in err


def test_verify(command: Command, here: Path) -> None:
    record_mission(Scenario(**SMALL), out="run")  # type: ignore[arg-type]
    code, out, err = command("verify", "run")
    assert (code, err) == (0, "")
    assert out.startswith("run: ")
    assert out.endswith("checks, no damage\n")
    (here / "run" / "events.parquet").write_bytes(b"PAR1")
    code, out, err = command("verify", "run", "nothing")
    assert (code, out) == (2, "")
    assert err.count("\n") == 2
    assert "events.parquet' is damaged" in err
    assert "'nothing' does not exist" in err
    assert command("verify")[0] == 2


def test_a_run_of_curves_shows_what_there_is(command: Command, here: Path) -> None:
    record_mission(Scenario(**SMALL), out="run", record="curves")  # type: ignore[arg-type]
    code, out, err = command("figures", "run")
    assert (code, err) == (0, "")
    assert "figure: run/figures/explored-area.png" in out
    assert "not drawn, for the run's level is 'curves': sensor-fan, team-map" in out
    code, _, err = command("figures", "run", "--only", "team-map")
    assert code == 2
    assert "run 'run': table 'steps' was not recorded" in err
