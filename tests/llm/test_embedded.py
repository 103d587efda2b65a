"""The model that needs no network, over its real HTTP server: ``make test-llm`` installs it.

pytest -m local_llm
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from swarmscout import Run, Scenario
from swarmscout.api import record_mission
from swarmscout.cli.app import main
from swarmscout.core.errors import ModelError
from swarmscout.core.language_model import Message, Request
from swarmscout.llm.failures import TryFailed
from swarmscout.llm.installed import find_model, install_model, model_file
from swarmscout.testing import small_world

needs_model = pytest.mark.skipif(
    find_model("smollm2") is None, reason="swarmscout models install smollm2"
)


def alive(pid: int) -> bool:
    stat = Path(f"/proc/{pid}/stat")
    return stat.exists() and stat.read_text().rsplit(")", 1)[1].split()[0] != "Z"


def test_what_is_missing_is_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"model file 'no\.gguf' does not exist"):
        model_file("no.gguf")
    with pytest.raises(ModelError, match="unknown model 'smolm2': did you mean 'smollm2'"):
        install_model("smolm2")
    monkeypatch.setattr("swarmscout.llm.installed.find_spec", lambda name: None)
    with pytest.raises(ModelError, match="swarmscout models install smollm2"):
        model_file()


@pytest.mark.local_llm
@needs_model
class TestWithTheModel:
    """With xllamacpp and SmolLM2-135M-Instruct; a minute or two."""

    @pytest.fixture(autouse=True)
    def _installed(self) -> None:
        pytest.importorskip("xllamacpp")
        pytest.importorskip("openai")

    def scenario(self, destinations: str = "llm-shortlist", **more: Any) -> Scenario:
        keys = {"robots": 5, "steps": 80, "destinations": destinations, **more}
        return Scenario.model_validate(
            {**keys, "llm": {"provider": "embedded", **more.get("llm", {})}}
        )

    def embedded(self, **more: Any) -> Any:
        from swarmscout.llm.embedded import Embedded

        return Embedded("", "m", **more)

    def test_a_whole_mission_twice_and_its_replay(self, tmp_path: Path) -> None:
        """Constrained answers are valid, and the same questions have the same answers."""
        cassette = str(tmp_path / "c.jsonl")
        runs = [
            record_mission(self.scenario(llm=llm), out=tmp_path / name, world=small_world(4))
            for name, llm in (
                ("one", {"cassette": cassette}),
                ("two", {}),
                ("three", {"cassette": cassette, "mode": "replay"}),
            )
        ]
        for run in runs:
            assert run.summary is not None
            told = run.summary["llm"]
            assert told["by_model"] == told["asked"] > 1
            assert (told["invalid"], told["cost_usd"], told["trouble"]) == ({}, 0.0, "")
        one, two, three = (run.attempts for run in runs)
        assert one.equals(three)
        assert one.drop("latency_s").equals(two.drop("latency_s"))
        assert runs[0].steps.equals(runs[1].steps)
        assert runs[0].decisions.equals(runs[2].decisions)
        # No blanks after the closing brace: a token is three or four characters of an answer.
        for row in one.iter_rows(named=True):
            assert row["tokens_out"] < 0.6 * len(runs[0].text(row["answer"])) + 6

    def test_prompts_of_the_papers_selector_are_made_to_fit(self) -> None:
        llm = {"max_calls": 2, "call_s": 120.0, "decision_s": 240.0}
        run = record_mission(
            self.scenario("llm", llm=llm, selector={"retries": 0}), world=small_world(4)
        )
        assert run.summary is not None
        assert run.summary["llm"]["calls"] == 2
        assert run.attempts["dropped"].max() > 0
        assert not set(run.attempts["verdict"]) - {"valid", "cut off"}

    def test_servers_share_the_work_and_agree(self) -> None:
        request = Request((Message("user", "Name a colour."),), max_tokens=20)
        answers = []
        for servers in (1, 2):
            model = self.embedded(servers=servers)
            answers += [model.send(request, 60.0).text for _ in range(2)]
            model.close()
        assert len(set(answers)) == 1

    def test_it_ends_with_the_mission(self) -> None:
        model = self.embedded()
        pids = [server._process.pid for server in model._servers]
        model.close()
        assert not any(map(alive, pids))

    def test_it_ends_when_its_owner_is_killed(self, tmp_path: Path) -> None:
        program = (
            "import time\nfrom swarmscout.llm.embedded import Embedded\n"
            "model = Embedded('', 'm')\nprint(model._servers[0]._process.pid, flush=True)\n"
            "time.sleep(60)\n"
        )
        owner = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
        assert owner.stdout is not None
        pid = int(owner.stdout.readline())
        owner.kill()
        owner.wait()
        owner.stdout.close()
        deadline = time.monotonic() + 20.0
        while alive(pid) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert not alive(pid)

    def test_a_server_that_dies_is_a_failure_and_not_the_end(self) -> None:
        model = self.embedded()
        request = Request((Message("user", "Name a colour."),), max_tokens=5)
        model.send(request, 60.0)
        os.kill(model._servers[0]._process.pid, signal.SIGKILL)
        with pytest.raises(TryFailed, match="no connection"):
            model.send(request, 10.0)
        model.close()

    def test_a_damaged_model_is_named(self, tmp_path: Path) -> None:
        from swarmscout.llm.embedded import Embedded

        file = tmp_path / "broken.gguf"
        file.write_bytes(b"GGUF" + bytes(100))
        model = Embedded(str(file), "m")
        with pytest.raises(TryFailed, match="the embedded model did not start"):
            model.send(Request((Message("user", "x"),)), 30.0)
        model.close()

    def test_the_doctor_asks_it(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["doctor", "--llm", "embedded"]) in (0, 2)
        out = capsys.readouterr().out
        assert "provider    embedded" in out
        assert "tokens      " in out

    def test_the_command(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
    ) -> None:
        monkeypatch.chdir(tmp_path)
        words = ["explore", "--destinations", "llm-shortlist", "--llm", "embedded", "--robots", "4"]
        assert main([*words, "--steps", "35", "--out", "x", "--no-picture"]) == 0
        told = capfd.readouterr()
        assert told.err == ""
        assert "language model  smollm2-135m-instruct: " in told.out
        assert "it explores no better than chance" in told.out
        attempt = Run.open("x").attempts.to_dicts()[0]
        assert f"step  {attempt['step']}  robot" in told.out
        assert main(["explain", "x", "--step", str(attempt["step"])]) == 0
        assert "Candidates (way m, turn °" in capfd.readouterr().out
