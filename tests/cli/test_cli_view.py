"""``swarmscout view``."""

from __future__ import annotations

import signal
import sys
import urllib.request

import pytest

import swarmscout as ss


def test_export_writes_one_file(command, here):
    assert (
        command("explore", "--robots", "3", "--steps", "12", "--no-picture", "--out", "r")[0] == 0
    )
    code, out, err = command("view", "r", "r", "--export", "two.html")
    assert (code, err) == (0, "")
    assert out.startswith("page: two.html (")
    assert (here / "two.html").read_bytes().count(b'application/x-mission">') == 2


def test_mistakes_are_one_line(command, here):
    command("explore", "--robots", "3", "--steps", "5", "--no-picture", "--out", "r")
    for words, told in (
        (("view", "nowhere"), "run folder 'nowhere' does not exist"),
        (("view", "r", "--export", "r.pdf"), "ends in .html"),
        (("view", "r", "--export", "no/such/folder.html"), "cannot write 'no/such/folder.html'"),
        (("view", "r", "--port", "99999"), "port 99999 is impossible"),
    ):
        code, out, err = command(*words)
        assert (code, out) == (2, "")
        assert told in err
        assert err.count("\n") == 1


def test_it_serves_until_it_is_interrupted(start, command, here):
    command("explore", "--robots", "3", "--steps", "5", "--no-picture", "--out", "r")
    with start("view", "r", "--port", "0", "--no-browser") as process:
        line = process.stdout.readline()
        url = line.removeprefix("page: ").split()[0]
        with urllib.request.urlopen(f"{url}run/0/data") as answer:
            assert answer.read()[:2] == b"\x1f\x8b"
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=20) == 0
        assert process.stderr.read() == ""


def test_explore_shows_a_mission_while_it_runs(start):
    words = ("--robots", "3", "--steps", "40", "--pace", "30", "--no-picture", "--out", "r")
    with start("explore", *words, "--view", "--port", "0", "--no-browser") as process:
        url = process.stdout.readline().removeprefix("page: ").split()[0]
        told = b""
        with urllib.request.urlopen(f"{url}run/0/data") as answer:
            assert answer.read()[:2] == b"\x1f\x8b"
        with urllib.request.urlopen(f"{url}run/0/live?from=5") as answer:
            for line in answer:
                told += line
        assert told.count(b"event: steps") >= 2
        assert b"event: end" in told
        for line in process.stdout:
            if line.startswith("page: "):
                break
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=20) == 0


def test_a_mission_that_cannot_begin_leaves_no_page_and_no_folder(command, here):
    told = command("explore", "--world", "nowhere.yaml", "--view", "--no-browser", "--out", "r")
    assert told[0] == 2
    assert "nowhere.yaml" in told[2]
    assert not (here / "r").exists()
    told = command("explore", "--view", "--pace", "0", "--no-browser", "--out", "r")
    assert told[0] == 2
    assert "--pace 0" in told[2]


def test_explore_writes_a_rerun_recording_too(command, here, monkeypatch):
    chunk = pytest.importorskip("rerun.chunk")
    words = ("--robots", "3", "--steps", "8", "--no-picture", "--world", "lava-tube-small")
    code, out, err = command("explore", *words, "--out", "r", "--record-rrd", "m.rrd")
    assert (code, err) == (0, "")
    assert "recording: m.rrd" in out
    entities = {str(piece.entity_path) for piece in chunk.RrdReader(here / "m.rrd").stream()}
    assert {"/cave/robots", "/map/grid", "/curves/explored_m2", "/decisions"} <= entities
    for more, told in (
        (("--record-rrd", "m.rr"), "ends in .rrd"),
        (("--record-rrd", "no/m.rrd"), "folder 'no' does not exist"),
        (("--record-rrd", "n.rrd", "--record", "curves"), "leave out --record curves"),
    ):
        code, out, err = command("explore", *words, "--out", "s", *more)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert told in err
        assert not (here / "s").exists()
    monkeypatch.setitem(sys.modules, "rerun", None)
    code, out, err = command("explore", *words, "--out", "s", "--record-rrd", "n.rrd")
    assert (code, out) == (2, "")
    assert "[rerun]'" in err
    assert not (here / "s").exists()


def test_what_a_rule_wrote_cannot_control_the_terminal(command, here):
    (here / "my.py").write_text(
        "from swarmscout.destinations.selector import Choice\n"
        "class Loud:\n"
        "    def choose(self, view, memory):\n"
        "        return Choice(tuple(view.frontiers[0]), reason='\\x1b[2Jgone\\u202e\\n\\x07!')\n",
        encoding="utf-8",
    )
    ss.explore(robots=2, steps=5, destinations="my.py:Loud", out="loud")
    step = str(ss.Run.open("loud").decisions["step"][0])
    for words in ((), ("--step", step)):
        code, out, err = command("explain", "loud", *words)
        assert (code, err) == (0, "")
        assert "gone" in out
        assert not set(out) & set("\x1b\u202e\x07")
