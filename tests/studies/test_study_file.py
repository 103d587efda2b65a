"""A study's file: what it says, and what is said when it is wrong."""

import os
import re

import pytest
from in_this_process import InThisProcess
from small_studies import SMALL

from swarmscout.core.errors import StudyError
from swarmscout.studies.scheduler import run_study
from swarmscout.studies.study import Study

RULE = """
from swarmscout.destinations.selector import Choice

class First:
    def choose(self, view, memory):
        return Choice(tuple(view.frontiers[0].tolist()))
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("trials", "trails", r"unknown key 'trails': did you mean 'trials'\?"),
        ("{trials}", "0", "key 'trials' = 0: should be greater than or equal to 1"),
        ('question = "Which explores more?"', "", "key 'question' is missing"),
        ('name = "small"', 'name = "a/b"', "key 'name' = 'a/b'"),
        ("[compare]", "[[compare]]", "key 'compare'"),
        ('axis = "destinations"', 'axis = "robots"', "compare.axis 'robots' is not an axis"),
        ('baseline = "quantile"', 'baseline = "x"', "compare.baseline 'x' is not a value of axis"),
        ('["quantile", "nearest"]', '["quantile"]', "has one value: there is nothing to compare"),
        ('["quantile", "nearest"]', "[]", "axis 'destinations' has no values"),
        ('["quantile", "nearest"]', '["quantile", "quantile"]', "has the value quantile twice"),
        ('["quantile", "nearest"]', '["quantile", "nearset"]', "did you mean 'nearest'"),
        ('["quantile", "nearest"]', '["quantile", {a = 1}]', "mixes tables and plain values"),
        ("robots = 4", "robots = -4", "'robots' = -4"),
        ("robots = 4", "robot = 4", r"unknown key 'robot': did you mean 'robots'\?"),
        ("robots = 4", "seed = 4", "sets 'seed': say trials and first_seed instead"),
        ("[axes]", "[axes]\nseed = [1, 2]", "'seed' sets 'seed'"),
        ("[axes]", "[axes]\nrobotz = [1, 2]", r"not a scenario key: did you mean 'robots'\?"),
        ("[axes]", "[axes]\nrobots = [1, -2]", "robots = -2.*'robots' = -2"),
        ("[axes]", '[axes]\nworld = ["lava-tub"]', "did you mean 'lava-tube'"),
        ("[axes]", "[axes]\nx = [{robots = 1}]", "every table needs a label"),
        ("[axes]", '[axes]\nx = [{label = "a"}]', "no scenario key is set"),
        ("[axes]", '[axes]\nx = [{label = "a", destinations = "nearest"}]', "both set"),
        ("trials", 'metric = "explored"\ntrials', "metric 'explored' is unknown"),
        ("trials", 'base = "papers"\ntrials', "unknown scenario 'papers'"),
        ("[axes]", "[axes", "is not valid TOML"),
        (
            "trials = {trials}",
            "trials = 9_000_000_000_000_000_000",
            "less than or equal to 1000000",
        ),
        ("trials = {trials}", "trials = 1" + "0" * 5000, "is not valid TOML: Exceeds the limit"),
        ("robots = 4", "robots = " + "[" * 100_000, "brackets are nested too deeply"),
        ("[axes]", '[axes]\nx = [{label = "\\u001b[2J", robots = 2}]', "control character"),
        (
            "trials = {trials}",
            "trials = 1_000_000",
            "2,000,000 missions: at most 1,000,000 are possible",
        ),
    ],
)
def test_what_is_wrong_is_said_in_one_line(make_study, old, new, message):
    assert old in SMALL
    with pytest.raises(StudyError, match=message) as error:
        make_study(SMALL.replace(old, new, 1)).missions  # noqa: B018
    assert "\n" not in str(error.value)


def test_a_study_that_cannot_be_run_leaves_no_folder(make_study, tmp_path):
    with pytest.raises(StudyError):
        run_study(make_study(SMALL.replace('"nearest"', '"nearset"')), InThisProcess())
    assert not (tmp_path / "out").exists()


def test_more_trials_than_there_can_be_are_refused(write_study):
    with pytest.raises(StudyError, match="key 'trials' = 9000000000000000000"):
        Study.load(write_study(), trials=9 * 10**18)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no FIFOs here")
@pytest.mark.parametrize("line", ['base = "fifo"', 'world = "fifo"'])
def test_a_fifo_is_not_waited_for(tmp_path, monkeypatch, make_study, line):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("fifo")
    with pytest.raises(StudyError, match="fifo' is not a regular file"):
        Study.load("fifo")
    text = SMALL.replace('world = "lava-tube-small"', line if "world" in line else "")
    study = make_study(text if "world" in line else line + text)
    with pytest.raises(StudyError, match="fifo' is not a regular file"):
        study.missions  # noqa: B018


def test_missing_files_are_named(tmp_path):
    with pytest.raises(StudyError, match=r"no\.toml' does not exist"):
        Study.load(tmp_path / "no.toml")
    with pytest.raises(StudyError, match="is not a study's folder"):
        Study.load(tmp_path)


def test_every_combination_has_every_seed(make_study):
    study = make_study(SMALL + 'world = ["lava-maze", "lava-tube"]\nrobots = [3, 5]\n', trials=3)
    missions = study.missions
    assert len(missions) == len({m.name for m in missions}) == 2 * 2 * 2 * 3
    found = {(s.destinations, s.world, s.robots, s.seed) for s in map(study.scenario, missions)}
    assert len(found) == 24
    assert [m.world for m in missions] == ["lava-maze"] * 12 + ["lava-tube"] * 12
    assert [axis.name for axis in study.settings] == ["robots"]


def test_tables_set_several_keys_at_once(make_study):
    text = """
        name = "joint"
        question = "?"
        trials = 1
        compare = { axis = "method", baseline = "near" }

        [scenario.teams]
        desired_size = 3

        [axes]
        method = [
            { label = "near", destinations = "nearest" },
            { label = "far", destinations = "potential", teams.d_join_m = 1, steps = 10 },
        ]
        """
    study = make_study(text)
    near, far = map(study.scenario, study.missions)
    assert (near.destinations, near.teams.d_join_m, near.teams.desired_size) == ("nearest", 2, 3)
    assert (far.destinations, far.teams.d_join_m, far.teams.desired_size) == ("potential", 1, 3)
    assert (near.steps, far.steps) == (300, 10)


def test_parameters_of_rules_are_axes_too(make_study):
    text = """
        name = "parameters"
        question = "?"
        trials = 2
        compare = { axis = "policy.per", baseline = 2 }

        [scenario]
        destinations = "multi-criteria"
        selector.ahead = 0.5
        teams.policy = "by-crowd"

        [axes]
        policy.per = [2, 3]
        selector.apart = [1.0, 2.0]
        """
    study = make_study(text)
    found = [(s.policy, s.selector) for s in map(study.scenario, study.missions)]
    expected = [
        ({"per": per}, {"ahead": 0.5, "apart": apart})
        for per in (2, 3)
        for apart in (1.0, 2.0)
        for _ in range(2)
    ]
    assert sorted(map(str, found)) == sorted(map(str, expected))
    with pytest.raises(StudyError, match=r"policy\.pre = 2.*'pre'.*per"):
        make_study(text.replace("policy.per", "policy.pre")).missions  # noqa: B018


def test_names_say_what_is_run_and_by_which_rules(make_study, monkeypatch):
    first = [m.name for m in make_study().missions]
    assert re.fullmatch(r"lava-tube-small-quantile-n4-s0-[0-9a-f]{12}", first[0])
    more = [m.name for m in make_study(trials=3).missions]
    assert [name for name in more if name in first] == first
    others = [m.name for m in make_study(SMALL.replace("steps = 20", "steps = 21")).missions]
    assert not set(first) & set(others)
    monkeypatch.setattr("swarmscout.studies.plan.RULES_VERSION", 999)
    assert not set(first) & {m.name for m in make_study().missions}


def test_files_are_known_by_what_they_hold(make_study, tmp_path):
    text = SMALL.replace('"nearest"', '"rules/my.py:First"')
    (tmp_path / "rules").mkdir()
    rule = tmp_path / "rules" / "my.py"
    rule.write_text(RULE, encoding="utf-8")
    study = make_study(text)
    names = {m.name for m in study.missions}
    assert study.compared.labels == ["quantile", "First"]

    with study.claimed():  # The kept file means the same where it lies.
        pass
    assert {m.name for m in Study.load(tmp_path / "out").missions} == names
    rule.write_text(RULE + "\n# Another rule.\n", encoding="utf-8")
    assert len(names & {m.name for m in make_study(text).missions}) == 2  # Those of the baseline.
