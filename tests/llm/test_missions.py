"""Whole missions over real HTTP: faults, concurrency, records, replays, and no key anywhere."""

from __future__ import annotations

import hashlib
import io
import json
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any
from zlib import crc32

import polars as pl
import pytest
from provider import KEY, Provider, completion, frontiers_of, serving

from swarmscout import Run, Scenario
from swarmscout.api import record_mission
from swarmscout.cli.app import main
from swarmscout.core.errors import ModelError
from swarmscout.core.language_model import Reply
from swarmscout.mission.mission import Mission
from swarmscout.testing import small_world
from swarmscout.testing.fingerprints import fingerprint

pytest.importorskip("openai")


@pytest.fixture(autouse=True)
def environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """No provider but the one that a test names, and a key that must not leak."""
    for name in ("OPENAI_BASE_URL", "AZURE_OPENAI_ENDPOINT", "AZURE_OPENAI_API_KEY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    monkeypatch.setattr("swarmscout.llm.retry.BACKOFF_S", 0.01)


def scenario(url: str, destinations: str = "llm", **keys: Any) -> Scenario:
    llm = {"base_url": url, "model": "test-model", "tries": 2, "call_s": 5.0, **keys.pop("llm", {})}
    base = {"robots": 6, "steps": 60, "destinations": destinations, "llm": llm}
    return Scenario.model_validate({**base, **keys})


def fly(given: Scenario, out: Path | None = None, **more: Any) -> Run:
    return record_mission(given, out=out, world=small_world(4), **more)


def state(given: Scenario, steps: int | None = None) -> Any:
    mission = Mission(given, world=small_world(4))
    while not mission.done and mission.step_number != steps:
        mission.step()
    mission.close()
    told = (mission.bodies.pose, mission.bodies.charge, mission.minds.own, mission.minds.avoided)
    return [fingerprint(x) for x in (*told, mission.swarm.evidence)]


def test_a_mission_asks_and_obeys() -> None:
    with serving("good:-1") as server:
        run = fly(scenario(server.url))
    attempts = run.attempts
    assert attempts.height == len(server.seen) > 5
    assert set(attempts["verdict"]) == {"valid"}
    chosen = run.decisions.filter(pl.col("step") > 20)
    asked = chosen.join(attempts, on=["step", "leader"], suffix="_asked")
    assert asked.height == chosen.height
    assert (asked["cell"] == asked["cell_asked"]).all()
    assert set(chosen["reason"]) == {"open"}
    assert run.summary is not None
    told = run.summary["llm"]
    assert told["by_model"] == told["asked"] == told["calls"] == attempts.height
    assert told["decisions"] == run.decisions.height
    assert (told["tokens_in"], told["tokens_out"]) == (100 * told["calls"], 10 * told["calls"])
    assert told["cost_usd"] is None
    assert attempts["step"].min() > 20


def test_leaders_ask_at_the_same_time_and_speed_changes_nothing() -> None:
    """Answers that come in another order make the same mission."""

    def slow_for_some(number: int, body: dict[str, Any]) -> str:
        return "slow:0.1" if number % 2 else "slow:0.02"

    given = {"robots": 25, "start": "spread", "teams": {"d_join_m": 0.0}, "steps": 40}
    found = []
    with serving("slow:0.05") as server:
        found.append(state(scenario(server.url, **given)))
        assert server.most_at_once > 3
        seen = len(server.seen)
    with serving(slow_for_some) as server:
        found.append(state(scenario(server.url, **given)))
        assert len(server.seen) == seen
    with serving("good") as server:
        found.append(state(scenario(server.url, llm={"concurrency": 1}, **given)))
        assert server.most_at_once == 1
    assert found[0] == found[1] == found[2]


FAULTS = {
    "raw:nonsense": "failed: malformed reply",
    "text:I think the left one is best.": "no answer",
    'text:{"choice": "0,0", "reason": "x"}': "unexplored cell",
    "refusal": "refusal",
    "text:": "empty",
    "cut": "cut off",
    "status:400": "failed: bad request",
    "status:401": "failed: unauthorized",
    "status:429": "failed: rate limit",
    "status:429 0": "failed: rate limit",
    "status:500": "failed: server error",
    "hang": "failed: timeout",
    "drip": "failed: timeout",
    "drop": "failed: no connection",
}


@pytest.mark.parametrize("fault", FAULTS)
def test_with_a_provider_that_always_fails_the_mission_is_the_baselines(fault: str) -> None:
    expected = state(scenario("http://127.0.0.1:9", "quantile"))
    call_s = 0.1 if fault in ("hang", "drip") else 5.0
    quick = {"call_s": call_s, "breaker_failures": 3}
    with serving(fault) as server:
        given = scenario(server.url, llm=quick)
        assert state(given) == expected
        run = fly(given)
    assert run.summary is not None
    told = run.summary["llm"]
    assert told["by_model"] == 0
    assert sum(told["fallbacks"].values()) == told["asked"] > 5
    assert set(run.attempts["verdict"]) == {FAULTS[fault]}
    assert bool(told["trouble"]) == FAULTS[fault].startswith("failed")


def test_the_warm_up_is_the_baselines_bit_for_bit() -> None:
    with serving("good") as server:
        given = scenario(server.url)
        baseline = scenario(server.url, "quantile")
        assert state(given, 20) == state(baseline, 20)
        assert server.seen == []
        assert state(given, 50) != state(baseline, 50)


def test_a_provider_that_comes_and_goes() -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        return ("good", "status:503", "text:hm", "drop", "good")[number % 5]

    with serving(plan) as server:
        run = fly(scenario(server.url, steps=100))
    assert run.summary is not None
    told = run.summary["llm"]
    assert 0 < told["by_model"] <= told["asked"]
    assert told["invalid"].keys() == {"no answer"}
    assert told["requests"] == len(server.seen) > told["calls"]


def test_an_invalid_answer_is_followed_by_what_was_wrong_with_it() -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        return "good" if len(body["messages"]) > 2 else "text:12"

    with serving(plan) as server:
        run = fly(scenario(server.url, steps=30))
    assert set(run.attempts.filter(pl.col("attempt") == 1)["verdict"]) == {"bare number"}
    assert set(run.attempts.filter(pl.col("attempt") == 2)["verdict"]) == {"valid"}
    second = next(body for body in server.seen if len(body["messages"]) > 2)
    assert "it is a number, not a coordinate" in second["messages"][3]["content"]
    assert second["messages"][2] == {"role": "assistant", "content": "12"}


def hashes(folder: Path) -> dict[str, str]:
    return {
        str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in sorted(folder.rglob("*"))
        if file.is_file() and file.name not in ("timing.zip", "scenario.toml", "run.json")
    }


def test_what_was_recorded_is_replayed_to_the_bit(tmp_path: Path) -> None:
    """Without a server, a key or any setting, and with another number of workers."""

    def plan(number: int, body: dict[str, Any]) -> str:
        kinds = ("good:3", "text:hm", "status:500", "good", "drop", "cut", "good:1")
        return kinds[crc32(str(body).encode()) % 7]

    file = str(tmp_path / "c.jsonl")
    with serving(plan) as server:
        fly(scenario(server.url, llm={"cassette": file, "mode": "record"}), tmp_path / "recorded")
        seen = len(server.seen)
    assert seen > 5
    recorded = hashes(tmp_path / "recorded")
    assert any(name.startswith("texts/") for name in recorded)
    assert "attempts.parquet" in recorded
    for name, workers in (("one", 1), ("eight", 8)):
        llm = {"cassette": file, "mode": "replay", "concurrency": workers, "tries": 2}
        given = scenario("", llm={**llm, "model": "", "call_s": 5.0})
        fly(given, tmp_path / name)
        assert hashes(tmp_path / name) == recorded
    with pytest.raises(
        ModelError, match=r"has no answer to request .* differs in .* \(step 2\d, r"
    ):
        fly(scenario("", steps=30, seed=5, llm={"cassette": file, "mode": "replay"}))


def test_a_run_keeps_every_prompt_and_answer_once(tmp_path: Path) -> None:
    with serving("good") as server:
        run = fly(scenario(server.url), tmp_path / "x")
    attempts = Run.open(tmp_path / "x").attempts
    names = {*attempts["prompt"], *attempts["answer"]}
    assert {p.stem for p in (tmp_path / "x" / "texts").iterdir()} == names
    for row in attempts.to_dicts():
        assert "Your position: (" in run.text(row["prompt"])
        assert json.loads(run.text(row["answer"]))["reason"] == "open"
    sent = [body["messages"][1]["content"] for body in server.seen]
    assert all(any(text in run.text(name) for name in attempts["prompt"]) for text in sent)


def test_a_killed_run_keeps_what_was_asked(tmp_path: Path) -> None:
    def stop(mission: Mission) -> None:
        if mission.step_number == 55:
            raise KeyboardInterrupt

    with serving("good") as server, pytest.raises(KeyboardInterrupt):
        fly(scenario(server.url), tmp_path / "x", on_step=stop)
    run = Run.open(tmp_path / "x")
    assert not run.finished
    assert run.attempts.height == len(server.seen)


def test_runs_without_a_model_have_no_such_table(tmp_path: Path) -> None:
    run = fly(scenario("", "nearest", steps=20), tmp_path / "x")
    assert not (tmp_path / "x" / "attempts.parquet").exists()
    assert run.attempts.height == 0
    assert run.summary is not None
    assert "llm" not in run.summary


def test_somebody_elses_model() -> None:
    class First:
        def complete(self, request: Any) -> Reply:
            ids = request.schema["properties"]["choice"]["enum"]
            return Reply(json.dumps({"choice": ids[0], "reason": "first"}))

    run = fly(scenario(""), model=First())
    assert run.summary is not None
    assert run.summary["llm"]["model"] == "First"
    assert run.summary["llm"]["by_model"] > 5


Command = Callable[..., tuple[int, str, str]]


@pytest.fixture
def command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Command:
    monkeypatch.chdir(tmp_path)

    def run(*words: str) -> tuple[int, str, str]:
        capfd.readouterr()
        code = main(words)
        told = capfd.readouterr()
        return code, told.out, told.err

    return run


def options(server: Provider, *more: str) -> tuple[str, ...]:
    base = ("explore", "--destinations", "llm", "--robots", "5", "--steps", "40", "--no-picture")
    where = ("--llm", server.url, "--llm-model", "test-model", "--set", "llm.tries=1")
    return (*base, *where, *more)


def test_the_command_and_explaining_a_decision(command: Command) -> None:
    with serving(lambda n, body: "text:hm" if n == 0 else "good") as server:
        code, out, err = command(*options(server, "--out", "x"))
    assert (code, err) == (0, "")
    line = next(line for line in out.splitlines() if line.startswith("language model"))
    assert "test-model: " in line
    assert "1 invalid answers (no answer 1)" in line
    row = Run.open("x").attempts.to_dicts()[0]
    words = ("explain", "x", "--step", str(row["step"]), "--team", str(row["team"]))
    code, out, err = command(*words)
    assert (code, err) == (0, "")
    for said in (
        "attempt 1  test-model, encoding cells, prompt paper-1",
        "Your position: (",
        "    hm\n",
        "verdict   no answer\n",
        "verdict   valid\n",
        "chosen    (",
        "reason    open",
    ):
        assert said in out
    assert "Your position" not in command(*words, "--no-prompts")[1]
    assert len(command("explain", "x")[1].splitlines()) == Run.open("x").decisions.height
    code, _, err = command("explain", "x", "--step", str(row["step"]), "--team", "777")
    assert code == 2
    assert f"in step {row['step']} decided team" in err
    code, _, err = command("explain", "x", "--step", "4000")
    assert (code, "the nearest is in step" in err) == (2, True)
    assert command("explain", "nowhere")[0] == 2


def test_who_does_not_answer_is_named_at_the_end(command: Command) -> None:
    with serving("status:401") as server:
        code, out, err = command(*options(server))
    assert code == 3, "the mission ran, and its model made no decision"
    assert err.startswith("warning: the model made no decision: unauthorized: the server refuses")
    assert err.count("\n") == 1
    assert "left to the rule (paused" in out or "left to the rule (unauthorized" in out


def test_answers_that_cannot_be_used_are_named_at_the_end(command: Command) -> None:
    with serving("text:hm") as server:
        code, _, err = command(*options(server, "--set", "selector.retries=0"))
    assert code == 3
    assert err.startswith("warning: the model made no decision: invalid answers (no answer); the r")


def test_no_control_character_reaches_the_terminal(command: Command) -> None:
    """Neither from answers nor from a server's name or errors; halves of characters neither."""
    nasty = "\x1b]0;owned\x07\x1b[2J\ud83d\u202e\x9b31m"

    def plan(number: int, body: dict[str, Any]) -> str:
        if number % 3 == 1:
            return "answer:400 " + json.dumps({"error": {"message": f"bad {nasty}"}})
        said = {"candidates": [], "choice": frontiers_of(body)[0], "reason": f"open {nasty}"}
        return "raw:" + json.dumps(completion(json.dumps(said), model=f"m{nasty}"))

    with serving(plan) as server:
        code, out, err = command(*options(server, "--out", "x", "--llm-cassette", "c.jsonl"))
    said = out + err + command("explain", "x")[1]
    step = str(Run.open("x").attempts["step"][0])
    said += command("explain", "x", "--step", step)[1]
    assert code == 0
    assert "open" in said
    assert not [sign for sign in said if (ord(sign) < 32 and sign not in "\n\t\r") or
                0x7F <= ord(sign) < 0xA0 or sign == "\u202e"]  # fmt: skip
    replayed = (*options(server, "--out", "y", "--llm-cassette", "c.jsonl"), "--llm-mode", "replay")
    assert command(*replayed)[0] == 0
    assert hashes(Path("x")) == hashes(Path("y"))


def test_a_model_that_thinks_is_heard_and_said(command: Command) -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        thinks = f"raw:{json.dumps(completion('', finish_reason='length'))}"
        return "good" if body["max_tokens"] > 2000 else thinks

    with serving(plan) as server:
        code, _, err = command(*options(server))
    assert code == 0
    assert err.startswith("note: the model thinks before it answers: the limit of its answers was")


def test_a_cost_limit_holds_without_counts(command: Command) -> None:
    def plan(number: int, body: dict[str, Any]) -> str:
        said = json.dumps({"choice": frontiers_of(body)[0], "reason": "open"})
        return f"raw:{json.dumps({**completion(said, model='gpt-4o'), 'usage': None})}"

    with serving(plan) as server:
        where = ("--set", "llm.model=gpt-4o", "--set", "llm.max_cost_usd=0.0001")
        words = [
            word for word in options(server, *where) if word not in ("test-model", "--llm-model")
        ]
        code, _, err = command(*words)
    assert code == 0
    assert "its budget of $0.0001 is used up" in err
    assert 0 < len(server.seen) < 6


def test_nothing_configured_says_what_to_set(
    command: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("OPENAI_API_KEY")
    code, _, err = command("explore", "--destinations", "llm")
    assert code == 2
    assert err.startswith("error: no language model is configured: set OPENAI_API_KEY; or AZURE_OP")
    assert "--llm embedded" in err
    assert err.count("\n") == 1
    assert list((tmp_path / "runs").iterdir()) == []
    code, _, err = command("explore", "--destinations", "llm", "--llm", "opnai")
    assert (code, "did you mean 'openai'?" in err) == (2, True)


@pytest.mark.parametrize(
    "fault", ["good", "status:401", "status:500", "status:429", "raw:nonsense", "hang", "drop"]
)
def test_the_key_is_in_no_byte_that_is_written_or_said(
    fault: str, command: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The server quotes the key in its errors, and the SDK logs as much as it can."""
    monkeypatch.setenv("OPENAI_LOG", "debug")
    log = io.StringIO()
    handler = logging.StreamHandler(log)
    root = logging.getLogger()
    level = root.level
    root.addHandler(handler)
    root.setLevel(logging.DEBUG)
    try:
        with serving(fault) as server:
            said = command(
                *options(server, "--out", "x", "--llm-cassette", "c.jsonl"),
                "--set", "llm.call_s=0.2", "--set", "llm.breaker_failures=2",
            )  # fmt: skip
            assert server.headers[0]["authorization"] == f"Bearer {KEY}", "it was sent"
    finally:
        root.removeHandler(handler)
        root.setLevel(level)
    assert said[0] == (0 if fault == "good" else 3)
    shown = "".join(map(str, said)) + log.getvalue()
    shown += "".join(map(str, command("explain", "x")))
    shown += repr(Run.open("x")) + repr(Run.open("x").attempts.to_dicts())
    for part in (KEY, KEY[3:], "0123456789abcdef"):
        assert part not in shown
        for file in tmp_path.rglob("*"):
            if file.is_file():
                assert part.encode() not in file.read_bytes(), file
                if file.suffix == ".parquet":
                    assert part not in repr(pl.read_parquet(file).to_dicts()), file
