"""The same studies on a real Dask cluster: a scheduler and two workers, each a process."""

import os
import re
import signal
import subprocess
import sys

import pytest
from in_this_process import InThisProcess
from small_studies import GATED, PATIENCE_S, SMALL, until

from swarmscout.recording.run import Run
from swarmscout.studies.scheduler import run_study

pytest.importorskip("distributed", reason="no dask.distributed here: pip install distributed")

TRIALS = 8
RULE = SMALL.replace('"nearest"', '"my.py:Rule"')


class Cluster:
    def __init__(self, folder):
        self.folder = folder
        self.processes = []
        log = self.start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        self.scheduler = self.processes[0]
        self.address = until(lambda: re.search(r"tcp://127\.0\.0\.1:\d+", log.read_text()))[0]
        self.workers = [self.worker(), self.worker()]

    def start(self, kind, *words):
        log = self.folder / f"{kind}-{len(self.processes)}.log"
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *words]
        with open(log, "w") as file:
            self.processes.append(
                subprocess.Popen(command, cwd=self.folder, stdout=file, stderr=file)
            )
        return log

    def worker(self):
        self.start(
            "worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard",
            "--host", "127.0.0.1", "--death-timeout", f"{PATIENCE_S:.0f}",
        )  # fmt: skip
        return self.processes[-1]

    def stop(self):
        for process in self.processes:
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    found = Cluster(tmp_path_factory.mktemp("cluster"))
    yield found
    found.stop()


def study_process(folder, cluster):
    command = [
        sys.executable, "-m", "swarmscout", "study", "study.toml", "--out", "out", "--no-report",
        "--engine", "dask", "--scheduler", cluster.address,
    ]  # fmt: skip
    return subprocess.Popen(
        command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


@pytest.fixture
def gated_study(tmp_path, make_study):
    """A study of a rule that waits for a number of finished missions, and what sets that number."""
    (tmp_path / "my.py").write_text(GATED, encoding="utf-8")

    def go_on_to(limit):
        (tmp_path / "limit.new").write_text(str(limit), encoding="utf-8")
        os.replace(tmp_path / "limit.new", tmp_path / "limit")

    return make_study(RULE, trials=TRIALS), go_on_to


@pytest.mark.slow
def test_a_cluster_loses_nothing(tmp_path, make_study, cluster, gated_study):
    study, go_on_to = gated_study
    go_on_to(3)
    client = study_process(tmp_path, cluster)
    until(lambda: len(study.folder.finished()) >= 3)
    os.kill(cluster.workers[0].pid, signal.SIGKILL)
    go_on_to(8)
    until(lambda: len(study.folder.finished()) >= 8)
    client.kill()
    client.communicate()
    before = study.folder.finished()
    assert 8 <= len(before) < 2 * TRIALS
    go_on_to(1000)

    stamps = {name: study.folder.run(name).stat().st_mtime_ns for name in before}
    out, err = study_process(tmp_path, cluster).communicate(timeout=PATIENCE_S)
    assert study.failures() == [], err
    assert study.frame()["status"].to_list() == ["finished"] * 2 * TRIALS, out + err
    assert {name: study.folder.run(name).stat().st_mtime_ns for name in before} == stamps

    local = make_study(RULE, trials=2, out="local")
    run_study(local, InThisProcess())
    for mission in local.missions:
        there, here = (s.folder.run(mission.name) for s in (study, local))
        assert Run.open(there).finished
        assert (there / "data.zip").read_bytes() == (here / "data.zip").read_bytes()


@pytest.mark.slow
def test_a_lost_scheduler_is_one_line(tmp_path, cluster, gated_study):
    """The last test that the cluster serves."""
    study, go_on_to = gated_study
    go_on_to(2)
    client = study_process(tmp_path, cluster)
    until(lambda: len(study.folder.finished()) >= 2)
    cluster.scheduler.kill()
    _, err = client.communicate(timeout=PATIENCE_S)
    assert client.returncode == 2
    last = err.strip().splitlines()[-1]
    assert "the engine of the study is lost" in last
    assert "the same command goes on" in last
    assert "Traceback" not in err


def test_an_address_without_a_scheduler_is_one_line(tmp_path, make_study):
    make_study()
    command = [
        sys.executable, "-m", "swarmscout", "study", "study.toml", "--engine", "dask",
        "--scheduler", "tcp://127.0.0.1:9",
    ]  # fmt: skip
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.returncode == 2
    assert "no Dask scheduler answers at 'tcp://127.0.0.1:9'" in done.stderr
    assert "Traceback" not in done.stderr
