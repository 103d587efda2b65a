"""Cassettes: content-addressed, appended by anybody, merged by putting one behind the other."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from swarmscout.core.errors import ModelError
from swarmscout.core.language_model import Message, Reply, Request
from swarmscout.llm.cassette import Cassette, Tape
from swarmscout.llm.connect import connect
from swarmscout.llm.settings import LlmSettings


class Counting:
    """Answers with a number that goes up."""

    def __init__(self, start: int = 0) -> None:
        self.calls = 0
        self.start = start
        self.failing = False

    def complete(self, request: Request) -> Reply:
        self.calls += 1
        if self.failing:
            return Reply(failure="timeout")
        return Reply(f"answer {self.start + self.calls}", tokens_in=7, seconds=0.25, cost_usd=0.1)


def ask(text: str, attempt: int = 1) -> Request:
    return Request((Message("system", "s"), Message("user", text)), {"a": 1}, attempt)


def cassette(path: Path, mode: str, model: Counting | None, name: str = "m") -> Cassette:
    return Cassette(Tape(path), mode, model, name, {"temperature": 0.0})


def test_recorded_and_replayed_replies_are_equal(tmp_path: Path) -> None:
    file = tmp_path / "deep" / "c.jsonl"
    model = Counting()
    recording = cassette(file, "record", model)
    told = [recording.complete(ask(text)) for text in ("ä\nb", "c", "ä\nb")]
    assert told[0] == told[2]
    assert model.calls == 2
    replaying = cassette(file, "replay", None)
    assert [replaying.complete(ask(text)) for text in ("ä\nb", "c", "ä\nb")] == told
    assert len(file.read_text().splitlines()) == 2
    for line in file.read_text().splitlines():
        assert set(json.loads(line)) == {
            "key", "model", "params", "attempt", "schema", "messages", "reply",
        }  # fmt: skip


def test_what_a_reply_depends_on(tmp_path: Path) -> None:
    file = tmp_path / "c.jsonl"
    model = Counting()
    cassette(file, "record", model).complete(ask("a"))
    others = [
        (cassette(file, "record", model), ask("a", attempt=2)),
        (cassette(file, "record", model), ask("b")),
        (cassette(file, "record", model), Request(ask("a").messages, {"a": 2})),
        (cassette(file, "record", model), Request(ask("a").messages, {"a": 1}, max_tokens=9)),
        (cassette(file, "record", model, "other"), ask("a")),
        (Cassette(Tape(file), "record", model, "m", {"temperature": 1.0}), ask("a")),
    ]
    for k, (one, request) in enumerate(others):
        one.complete(request)
        assert model.calls == 2 + k
    same = Request(ask("a").messages, {"a": 1}, budget_s=3.0)
    assert cassette(file, "replay", None).complete(same).text == "answer 1"


def test_modes(tmp_path: Path) -> None:
    file = tmp_path / "c.jsonl"
    cassette(file, "auto", Counting()).complete(ask("a"))
    model = Counting(10)
    again = cassette(file, "auto", model)
    assert again.complete(ask("a")).text == "answer 1"
    assert model.calls == 0
    anew = cassette(file, "refresh", model)
    assert [anew.complete(ask("a")).text for _ in range(2)] == ["answer 11", "answer 11"]
    assert cassette(file, "replay", None).complete(ask("a")).text == "answer 11"


def test_failures_are_replayed_and_asked_again_when_somebody_can_be_asked(tmp_path: Path) -> None:
    file = tmp_path / "c.jsonl"
    model = Counting()
    model.failing = True
    assert cassette(file, "record", model).complete(ask("a")).failure == "timeout"
    assert cassette(file, "replay", None).complete(ask("a")).failure == "timeout"
    model.failing = False
    assert cassette(file, "auto", model).complete(ask("a")).text == "answer 2"
    assert cassette(file, "replay", None).complete(ask("a")).text == "answer 2"


def test_two_that_write_and_cassettes_that_are_merged(tmp_path: Path) -> None:
    file = tmp_path / "c.jsonl"
    one, two = (cassette(file, "record", Counting(start)) for start in (0, 10))
    assert one.complete(ask("a")).text == "answer 1"
    assert two.complete(ask("a")).text == "answer 1", "the other was quicker"
    assert two.complete(ask("b")).text == "answer 12"
    assert one.complete(ask("b")).text == "answer 12"
    other = tmp_path / "d.jsonl"
    cassette(other, "record", Counting(20)).complete(ask("d"))
    file.write_bytes(file.read_bytes() + other.read_bytes())
    replaying = cassette(file, "replay", None)
    assert [replaying.complete(ask(t)).text[7:] for t in "abd"] == ["1", "12", "21"]


def test_several_processes_append_without_tearing_lines(tmp_path: Path) -> None:
    program = """
import sys
from pathlib import Path
from swarmscout.core.language_model import Message, Reply, Request
from swarmscout.llm.cassette import Cassette, Tape
class Long:
    def complete(self, request):
        return Reply("x" * 5000 + sys.argv[2])
c = Cassette(Tape(Path(sys.argv[1])), "record", Long(), "m", {})
for k in range(40):
    c.complete(Request((Message("user", f"{k % 30} {'y' * 20000}"),)))
"""
    file = tmp_path / "c.jsonl"
    children = [
        subprocess.Popen([sys.executable, "-c", program, str(file), str(k)]) for k in range(3)
    ]
    assert [child.wait() for child in children] == [0, 0, 0]
    lines = file.read_bytes().splitlines()
    keys = [json.loads(line)["key"] for line in lines]
    assert len(keys) == len(set(keys)) == 30


def test_who_was_killed_in_the_middle_of_a_line(tmp_path: Path) -> None:
    file = tmp_path / "c.jsonl"
    cassette(file, "record", Counting()).complete(ask("a"))
    file.write_bytes(file.read_bytes() + b'{"key": "half')
    again = cassette(file, "auto", Counting(5))
    assert again.complete(ask("a")).text == "answer 1"
    again.complete(ask("b"))
    assert len(file.read_bytes().splitlines()) == 2, "what was torn is gone"
    replaying = cassette(file, "replay", None)
    assert [replaying.complete(ask(t)).text for t in "ab"] == ["answer 1", "answer 6"]


def test_every_place_where_a_line_can_be_torn(tmp_path: Path) -> None:
    """Alone at the end, before a line of this version, and in merged cassettes."""
    file = tmp_path / "c.jsonl"
    cassette(file, "record", Counting()).complete(ask("ä"))
    line = file.read_bytes()
    for cut in range(1, len(line) - 1):
        file.write_bytes(line + line[:cut])
        assert len(Tape(file).entries) == 1
        cassette(file, "record", Counting()).complete(ask("b"))
        assert len(Tape(file).entries) == 2
        assert len(file.read_bytes().splitlines()) == 2
        file.write_bytes(line[:cut] + line)
        assert len(Tape(file).entries) == 1


def test_a_whole_line_without_its_end_counts(tmp_path: Path) -> None:
    file, other = tmp_path / "c.jsonl", tmp_path / "d.jsonl"
    cassette(file, "record", Counting()).complete(ask("a"))
    cassette(other, "record", Counting(10)).complete(ask("b"))
    bare = file.read_bytes().rstrip(b"\n")
    file.write_bytes(bare)
    assert cassette(file, "replay", None).complete(ask("a")).text == "answer 1"
    file.write_bytes(b"\xef\xbb\xbf" + bare + other.read_bytes().replace(b"\n", b"\r\n"))
    replaying = cassette(file, "replay", None)
    assert [replaying.complete(ask(t)).text for t in "ab"] == ["answer 1", "answer 11"]
    file.write_bytes(bare)
    cassette(file, "record", Counting(20)).complete(ask("c"))
    assert len(file.read_bytes().splitlines()) == 2
    assert len(Tape(file).entries) == 2


def test_a_file_of_something_else_is_left_alone(tmp_path: Path) -> None:
    file = tmp_path / "notes.txt"
    for text in (b"my notes", b"my notes\n", b"[1]"):
        file.write_bytes(text)
        with pytest.raises(ModelError, match="line 1: this is not an entry"):
            Tape(file)
        assert file.read_bytes() == text


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"text": 5}, "the reply's text is not a text"),
        ({"tokens_in": "many"}, "the reply's tokens_in is not a count"),
        ({"failure": "boredom"}, "the reply's failure is none of"),
        ({"finish": ""}, "the reply's finish is none of"),
        ({"seconds": -1}, "seconds = -1 is impossible"),
        ({"seconds": float("nan")}, "seconds = nan is impossible"),
        ({"cost_usd": "free"}, "the reply's cost_usd is not a number"),
    ],
)
def test_values_are_checked(tmp_path: Path, change: dict[str, object], says: str) -> None:
    file = tmp_path / "c.jsonl"
    cassette(file, "record", Counting()).complete(ask("a"))
    data = json.loads(file.read_text())
    data["reply"] |= change
    file.write_text(json.dumps(data) + "\n")
    with pytest.raises(ModelError, match="line 1: ") as caught:
        Tape(file)
    assert says in str(caught.value)


def test_what_cannot_be_kept_or_shown_is_replaced_on_reading(tmp_path: Path) -> None:
    file = tmp_path / "c.jsonl"
    cassette(file, "record", Counting()).complete(ask("a"))
    data = json.loads(file.read_text())
    data["reply"] |= {"text": "a\ud83d\x1b[2Jb", "tokens_in": 4294967295, "model": "m\x07"}
    file.write_text(json.dumps(data, ensure_ascii=True) + "\n")
    reply = cassette(file, "replay", None).complete(ask("a"))
    assert (reply.text, reply.tokens_in, reply.model) == ("a\ufffd\ufffd[2Jb", None, "m\ufffd")


def test_a_surrogate_poisons_nothing(tmp_path: Path) -> None:
    class Half:
        def complete(self, request: Request) -> Reply:
            return Reply("far \ud83d")

    file = tmp_path / "c.jsonl"
    recorded = Cassette(Tape(file), "record", Half(), "m", {}).complete(ask("a"))
    assert recorded.text == "far \ufffd"
    assert Cassette(Tape(file), "replay", None, "m", {}).complete(ask("a")) == recorded


@pytest.mark.parametrize(
    "line", ["nonsense", "[]", "{}", '{"key": "a", "reply": {"x": 1}}', "<<<<"]
)
def test_a_damaged_line_is_named(tmp_path: Path, line: str) -> None:
    file = tmp_path / "c.jsonl"
    cassette(file, "record", Counting()).complete(ask("a"))
    file.write_text(file.read_text() + line + "\n")
    with pytest.raises(ModelError, match="line 2"):
        Tape(file)


@pytest.mark.parametrize(
    ("request_", "name", "says"),
    [
        (
            ask("the cave\nis dark"),
            "m",
            "the user message, line 2: recorded 'is wide', asked 'is da",
        ),
        (ask("the cave\nis wide", 2), "m", "attempt: recorded 1, asked 2"),
        (ask("the cave\nis wide"), "n", "model: recorded 'm', asked 'n'"),
        (Request(ask("the cave\nis wide").messages, {"b": 1}), "m", "the schema of the answer"),
        (Request((Message("user", "x"),), {"a": 1}), "m", "the number of messages"),
    ],
)
def test_a_miss_says_what_differs(tmp_path: Path, request_: Request, name: str, says: str) -> None:
    file = tmp_path / "c.jsonl"
    recording = cassette(file, "record", Counting())
    recording.complete(ask("something else"))
    recording.complete(ask("the cave\nis wide"))
    with pytest.raises(ModelError) as caught:
        cassette(file, "replay", None, name).complete(request_)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "--llm-mode auto" in str(caught.value)


def test_mistakes_with_cassettes(tmp_path: Path) -> None:
    file = tmp_path / "c.jsonl"

    def connected(environ: dict[str, str] | None = None, **keys: str) -> None:
        connect(LlmSettings(**keys), environ=environ or {}).close()

    with pytest.raises(ModelError, match=r"c\.jsonl' does not exist: nothing can be replayed"):
        connected(cassette=str(file), mode="replay")
    with pytest.raises(ModelError, match="mode 'record' needs a cassette"):
        connected(mode="record")
    with pytest.raises(ModelError, match="no language model is configured"):
        connected(cassette=str(file), mode="auto")
    file.write_text("")
    with pytest.raises(ModelError, match="is empty"):
        connected(cassette=str(file), mode="replay")
    with pytest.raises(ModelError, match="Is a directory"):
        connected(cassette=str(tmp_path), mode="replay")
    cassette(file, "record", Counting()).complete(ask("a"))
    connected(cassette=str(file), mode="replay")
    connected(cassette=str(file), mode="auto")
    with pytest.raises(ModelError, match="no language model is configured"):
        connected(cassette=str(file), mode="record")
    cassette(file, "record", Counting(), "other").complete(ask("a"))
    with pytest.raises(ModelError, match="holds answers of m, other: choose with --llm-model"):
        connected(cassette=str(file), mode="replay")
    connected(cassette=str(file), mode="replay", model="m")
