"""Nothing is lost: studies that are interrupted, killed, changed, or whose missions fail."""

import contextlib
import errno
import gc
import json
import multiprocessing
import os
import signal
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pytest
from in_this_process import InThisProcess
from small_studies import GATED, PATIENCE_S, SMALL, until

from swarmscout.core.errors import StudyError
from swarmscout.recording.run import Run
from swarmscout.studies.engines import LocalEngine
from swarmscout.studies.scheduler import run_study
from swarmscout.studies.study import Study

FAILING = """
import os
from pathlib import Path
from swarmscout.destinations.selector import Choice

class Rule:
    '''Fails while a file "broken" stands beside it, and kills its process while "deadly" does.'''

    def choose(self, view, memory):
        here = Path(__file__).parent
        if (here / "deadly").exists():
            os._exit(1)
        if (here / "broken").exists():
            raise ValueError("no idea")
        return Choice(tuple(view.frontiers[0].tolist()))
"""


class Counted:
    def __init__(self):
        self.outcomes = {}

    def __call__(self, mission, outcome):
        assert mission.name not in self.outcomes
        self.outcomes[mission.name] = outcome


def bits(study):
    """All that a study's runs hold, but times."""
    return {
        f"{name}/{file.name}": file.read_bytes()
        for name in study.folder.finished()
        for file in study.folder.run(name).iterdir()
        if not file.name.startswith("timing")
    }


def test_a_study_is_run_once(make_study, engine):
    study, counted = make_study(), Counted()
    assert run_study(study, engine, listener=counted) == 4
    assert set(counted.outcomes) == study.folder.finished() == {m.name for m in study.missions}
    for mission in study.missions:
        run = Run.open(study.folder.run(mission.name))
        assert run.finished
        assert run.level == "curves"
        assert run.scenario == study.scenario(mission)
        assert counted.outcomes[mission.name].explored_m2 == run.coverage["explored_m2"][-1]
    before = bits(study)
    assert run_study(make_study(), engine) == 0
    assert bits(study) == before


def test_a_changed_file_adds_what_is_new(make_study, engine):
    run_study(make_study(), engine)
    more = make_study(SMALL.replace('"nearest"]', '"nearest", "random"]'), trials=3)
    counted = Counted()
    assert run_study(more, engine, listener=counted) == 9 - 4
    assert {more.scenario(m).destinations for m in more.missions if m.name in counted.outcomes} == {
        "quantile", "nearest", "random",
    }  # fmt: skip
    assert more.frame()["status"].to_list() == ["finished"] * 9
    # Back to the smaller file: what is beyond it stays, and is not counted.
    fewer = make_study()
    assert run_study(fewer, engine) == 0
    assert fewer.frame().height == 4
    assert len(fewer.folder.finished()) == 9


def failing_study(make_study, tmp_path):
    (tmp_path / "my.py").write_text(FAILING, encoding="utf-8")
    return make_study(SMALL.replace('"nearest"', '"my.py:Rule"'))


def test_failures_are_listed_and_can_be_tried_again(make_study, tmp_path, engine):
    study = failing_study(make_study, tmp_path)
    (tmp_path / "broken").touch()
    assert run_study(study, engine) == 4
    assert len(study.failures()) == 2
    assert all("ValueError: no idea" in failure.error for failure in study.failures())
    assert sorted(study.frame()["status"]) == ["failed", "failed", "finished", "finished"]

    assert run_study(study, engine) == 0  # They would fail again.
    (tmp_path / "broken").unlink()
    assert run_study(study, engine, retry=True) == 2
    assert study.failures() == []
    assert study.folder.failed() == {}


def test_a_mission_that_kills_its_worker_is_found(make_study, tmp_path):
    study = failing_study(make_study, tmp_path)
    (tmp_path / "deadly").touch()
    counted = Counted()
    assert run_study(study, LocalEngine(2), listener=counted) == 4
    failed = study.failures()
    assert len(failed) == 2
    assert all("worker process died" in failure.error for failure in failed)
    assert all("Rule" in failure.mission for failure in failed)
    assert len(study.folder.finished()) == 2


LATE = """
import os
import threading
import time
from pathlib import Path
from swarmscout.destinations.selector import Choice

missions = Path(__file__).parent / "out" / "missions"

def others():
    return {path.name for path in missions.glob(".*-quantile-*")}

def kill(before):
    while not others() - before:
        time.sleep(0.001)
    os._exit(1)

class Rule:
    '''Kills its process when a mission of another rule begins in it.'''

    def choose(self, view, memory):
        if not [t for t in threading.enumerate() if t.name == "killer"]:
            args = (others(),)
            threading.Thread(target=kill, args=args, daemon=True, name="killer").start()
        return Choice(tuple(view.frontiers[0].tolist()))
"""


def test_a_mission_is_not_blamed_for_what_another_did(make_study, tmp_path):
    (tmp_path / "my.py").write_text(LATE, encoding="utf-8")
    study = make_study(SMALL.replace('"nearest"', '"my.py:Rule"'))
    assert run_study(study, LocalEngine(1)) == 4
    assert study.failures() == []
    assert len(study.folder.finished()) == 4


def test_a_killed_worker_loses_nothing(make_study, tmp_path):
    study = make_study(trials=6)
    killed = []

    def kill_one(mission, outcome):
        assert outcome.error is None
        if not killed:
            victim = multiprocessing.active_children()[0]
            killed.append(victim.pid)
            os.kill(victim.pid, signal.SIGKILL)

    run_study(study, LocalEngine(2), listener=kill_one)
    assert killed
    assert study.frame()["status"].to_list() == ["finished"] * 12
    undisturbed = make_study(trials=6, out="undisturbed")
    run_study(undisturbed, InThisProcess())
    assert bits(study) == bits(undisturbed)


def state_of(process):
    """State and parent of a process."""
    return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[:2]


def workers_of(parent):
    """Living processes whose parent is a process: a number each."""
    found = []
    for entry in os.listdir("/proc"):
        with contextlib.suppress(OSError, ValueError):
            state, ppid = (
                Path(f"/proc/{int(entry)}/stat").read_text().rpartition(")")[2].split()[:2]
            )
            if int(ppid) == parent and state != "Z":
                found.append(int(entry))
    return found


def finished(missions):
    return [name for name in os.listdir(missions) if not name.startswith(".")]


def is_alive(process):
    with contextlib.suppress(OSError):
        return state_of(process)[0] != "Z"
    return False


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="processes are found through /proc")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_killed_study_goes_on_where_it_was(make_study, write_study, tmp_path, number):
    (tmp_path / "my.py").write_text(GATED, encoding="utf-8")
    (tmp_path / "limit").write_text("5", encoding="utf-8")
    text = SMALL.replace('"nearest"', '"my.py:Rule"')
    write_study(text, trials=20)
    command = [
        sys.executable, "-m", "swarmscout", "study", "study.toml",
        "--out", "out", "--jobs", "2", "--no-report",
    ]  # fmt: skip
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL)
    missions = tmp_path / "out" / "missions"
    until(lambda: missions.is_dir() and len(finished(missions)) >= 5)
    workers = workers_of(process.pid)
    assert len(workers) >= 2
    process.send_signal(number)
    assert process.wait(timeout=PATIENCE_S) == (-9 if number == signal.SIGKILL else 143)
    until(lambda: not any(map(is_alive, workers)))

    study = make_study(text, trials=20)
    before = study.folder.finished()
    assert 5 <= len(before) < 40
    for name in before:
        assert Run.open(study.folder.run(name)).finished
    (tmp_path / "limit").write_text("1000", encoding="utf-8")
    left = {m.name for m in study.missions} - before
    counted = Counted()
    run_study(study, InThisProcess(), listener=counted)
    assert set(counted.outcomes) == left
    assert study.frame()["status"].to_list() == ["finished"] * 40
    assert not [entry for entry in os.listdir(missions) if entry.startswith(".")]


def test_half_written_runs_do_not_count(make_study, engine):
    study = make_study()
    with study.claimed():
        pass
    name = study.missions[0].name
    half = study.folder.missions / f".{name}-abc" / "run"
    half.mkdir(parents=True)
    (half / "run.json").write_text("{}", encoding="utf-8")
    assert study.folder.finished() == set()
    assert run_study(study, engine) == 4
    assert not half.exists()


def everything(folder):
    """Every file of a folder with its contents and its time stamp."""
    return {
        str(path): (path.stat().st_mtime_ns, path.read_bytes() if path.is_file() else b"")
        for path in folder.rglob("*")
    }


def test_a_refused_start_changes_nothing_of_the_running_study(make_study, engine, tmp_path):
    pytest.importorskip("fcntl")
    study = make_study()
    with study.claimed():
        (study.folder.missions / ".under-way").mkdir()
        before = everything(tmp_path / "out")
        with pytest.raises(StudyError, match="another process is running"):
            run_study(make_study(trials=7), engine)
        assert everything(tmp_path / "out") == before


def test_a_refused_folder_is_left_as_it_was(make_study, engine, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.tex").touch()
    before = everything(tmp_path)
    with pytest.raises(StudyError, match="not a study's folder"):
        run_study(make_study(), engine)
    assert set(everything(tmp_path)) - set(before) == {str(tmp_path / "study.toml")}


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP])
def test_file_systems_without_locks_are_named_and_used(make_study, engine, monkeypatch, number):
    fcntl = pytest.importorskip("fcntl")

    def refuse(*_):
        raise OSError(number, os.strerror(number))

    study = make_study(trials=1)
    with study.claimed():
        pass
    under_way = study.folder.missions / ".under-way"
    under_way.mkdir()
    monkeypatch.setattr(fcntl, "flock", refuse)
    # Another process may be at work there: what it has begun is left alone.
    with pytest.warns(UserWarning, match="file system without locks"):
        assert run_study(study, engine) == 2
    assert under_way.exists()


def test_a_folder_without_a_run_is_not_a_finished_mission(make_study, engine):
    study = make_study(trials=1)
    name = study.missions[0].name
    with study.claimed():
        study.folder.run(name).mkdir()
        (study.folder.run(name) / "coverage.parquet").touch()
    assert study.folder.finished() == set()
    assert run_study(study, engine) == 2
    assert Run.open(study.folder.run(name)).finished


def test_a_script_needs_no_main_guard(write_study, tmp_path):
    write_study()
    (tmp_path / "script.py").write_text(
        """
import sys
import swarmscout as ss
from swarmscout.studies.engines import LocalEngine
from swarmscout.studies.scheduler import run_study

number = int(sys.argv.pop(1))
study = ss.Study.load("study.toml", out="out")
print("missions:", run_study(study, LocalEngine(2)) + number)
""",
        encoding="utf-8",
    )
    command = [sys.executable, "script.py", "10"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("missions: 14\n", "")
    assert Study.load(tmp_path / "out").todo() == []


def test_folders_of_others_are_left_alone(make_study, tmp_path, engine):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.tex").touch()
    with pytest.raises(StudyError, match="is not empty and not a study's folder"):
        run_study(make_study(), engine)
    run_study(make_study(out="mine", trials=1), engine)
    with pytest.raises(StudyError, match="holds the study 'small': give another folder"):
        run_study(make_study(SMALL.replace('"small"', '"large"'), out="mine"), engine)
    (tmp_path / "file").touch()
    with pytest.raises(StudyError, match="is a file"):
        run_study(make_study(out="file"), engine)


def test_damaged_results_are_named(make_study, engine):
    study = make_study(trials=1)
    run_study(study, engine)
    name = study.missions[0].name
    (study.folder.run(name) / "summary.json").write_text("{", encoding="utf-8")
    with pytest.raises(StudyError, match=r"summary\.json' is missing or damaged: remove"):
        study.frame()


def test_a_lost_engine_is_one_line(make_study):
    class Lost(InThisProcess):
        @contextlib.contextmanager
        def open(self):
            with super().open() as pool:
                pool.shutdown()
                yield pool

    with pytest.raises(StudyError, match="the engine of the study is lost"):
        run_study(make_study(), Lost())


def test_summaries_alone_give_curves_too(make_study, engine):
    whole = make_study(SMALL.replace("steps = 20", "steps = 120"), trials=1)
    brief = make_study(
        'record = "summary"\n' + SMALL.replace("steps = 20", "steps = 120"), trials=1, out="brief"
    )
    run_study(whole, engine)
    run_study(brief, engine)
    a, b = whole.frame(), brief.frame()
    assert a["explored_m2"].to_list() == b["explored_m2"].to_list()
    assert a["auc_m2"].to_list() == pytest.approx(b["auc_m2"].to_list(), rel=0.2)


def test_runs_say_what_made_them(make_study, engine):
    study = make_study(trials=1)
    run_study(study, engine)
    kept = Study.load(study.folder.path)
    assert [m.name for m in kept.missions] == [m.name for m in study.missions]
    facts = json.loads((study.folder.run(study.missions[0].name) / "run.json").read_text())
    assert facts["rules_version"] == study.versions["rules_version"]


def test_a_worker_does_not_look_at_what_it_has_loaded_again(make_study):
    study = make_study()
    run_study(study, InThisProcess())
    try:
        assert gc.get_freeze_count() > 10_000
    finally:
        gc.unfreeze()


def test_a_broken_pool_is_known_as_one():
    # What the scheduler relies on: a dead worker breaks every future that is not done.
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        future = pool.submit(os._exit, 1)
        with pytest.raises(Exception, match="terminated abruptly"):
            future.result()
