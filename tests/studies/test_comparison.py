"""Comparisons pair what belongs together, and give numbers that were worked out by hand."""

import polars as pl
import pytest
from scipy import stats
from small_studies import SMALL

from swarmscout.studies.comparison import arms_of, compare, compare_arms, metric_of
from swarmscout.studies.sensing_limit import sensing_limit_m2

TWO_WORLDS = SMALL.replace('world = "lava-tube-small"\n', "") + (
    'world = ["lava-tube-small", "lava-maze"]\nrobots = [3, 4]\n'
).replace("robots = 4\n", "")


@pytest.fixture
def with_values(make_study):
    """A study and a table of it in which missions have the areas that a function gives."""

    def make(text, trials, area):
        study = make_study(text, trials=trials)
        frame = study.frame().with_columns(
            pl.lit("finished").alias("status"),
            pl.struct(pl.all())
            .map_elements(lambda row: float(area(row)), return_dtype=pl.Float64)
            .alias("explored_m2"),
        )
        return study, frame

    return make


def gain(row):
    """10 m² better in the tube and 30 m² in the maze, on a base that differs from seed to seed."""
    base = 100 + 7 * row["seed"] + (50 if row["world"] == "lava-maze" else 0)
    return base + (row["destinations"] == "nearest") * (30 if row["world"] == "lava-maze" else 10)


def test_pairs_agree_in_world_seed_and_setting(with_values):
    text = TWO_WORLDS.replace("robots = 4\n", "")
    study, frame = with_values(text, 4, gain)
    found = compare(study, frame)
    assert [(p.setting, p.label) for p in found] == [((3,), "nearest"), ((4,), "nearest")]
    for p in found:
        assert (p.n, p.lacking, p.unit, p.difference.units) == (8, 0, "worlds", 2)
        assert sorted(p.differences) == [10] * 4 + [30] * 4
        assert p.difference.value == 20
        half = stats.t.ppf(0.975, 1) * stats.sem([10, 30])  # Two worlds are two values.
        assert (p.difference.low, p.difference.high) == pytest.approx((20 - half, 20 + half))
        assert p.improvement.value == 1.0
        assert p.too_few
        tube = sum(1 + 10 / (100 + 7 * s) for s in range(4)) / 4
        maze = sum(1 + 30 / (150 + 7 * s) for s in range(4)) / 4
        assert p.ratio.value == pytest.approx((tube + maze) / 2)


def test_each_world_alone_rests_on_its_seeds(with_values):
    study, frame = with_values(TWO_WORLDS.replace("robots = 4\n", ""), 4, gain)
    _, alone = compare_arms(study, frame)[0]
    assert [(p.world[0], p.difference.value, p.unit) for p in alone] == [
        ("lava-tube-small", 10, "seeds"),
        ("lava-maze", 30, "seeds"),
    ]


def test_missions_without_a_partner_are_left_out_and_counted(with_values):
    study, frame = with_values(SMALL, 5, lambda row: 100 + row["seed"])
    lost = (pl.col("seed") == 2) & (pl.col("destinations") == "quantile")
    frame = frame.with_columns(
        pl.when(lost).then(None).otherwise(pl.col("explored_m2")).alias("explored_m2")
    )
    (p,) = compare(study, frame)
    assert (p.n, p.lacking) == (4, 1)
    assert p.difference.value == 0.0
    assert p.improvement.value == 0.5


def test_less_is_better_where_less_is_better(with_values):
    text = SMALL.replace("trials", 'metric = "overlap_ratio"\ntrials', 1)
    study, frame = with_values(text, 3, lambda row: 1.0)
    frame = frame.with_columns(
        pl.when(pl.col("destinations") == "nearest").then(0.2).otherwise(0.5).alias("overlap_ratio")
    )
    (p,) = compare(study, frame)
    assert p.improvement.value == 1.0
    assert p.difference.value == pytest.approx(-0.3)


def test_worlds_can_be_what_is_compared(with_values):
    text = SMALL.replace('"destinations"', '"world"').replace('"quantile"\n', '"lava-maze"\n')
    text = text.replace('world = "lava-tube-small"\n', "") + 'world = ["lava-maze", "lava-tube"]\n'
    study, frame = with_values(text, 3, gain)
    found = compare(study, frame)
    assert [(p.setting, p.label, p.n, p.unit) for p in found] == [
        (("quantile",), "lava-tube", 3, "seeds"),
        (("nearest",), "lava-tube", 3, "seeds"),
    ]


def test_times_not_reached_count_with_the_missions_length(with_values):
    study, frame = with_values(SMALL, 2, lambda row: 1.0)
    frame = frame.with_columns(pl.Series("time_to_50", [5, None, 7, None], dtype=pl.Int64))
    assert metric_of(study, frame, "time_to_50").tolist() == [5, 20, 7, 20]


def test_arms_stand_in_the_files_order(with_values):
    study, frame = with_values(TWO_WORLDS.replace("robots = 4\n", ""), 2, gain)
    found = [(arm.setting, arm.label) for arm in arms_of(study, frame, "explored_m2")]
    assert found == [((3,), "quantile"), ((3,), "nearest"), ((4,), "quantile"), ((4,), "nearest")]


def test_the_sensing_limit_grows_with_robots_steps_and_range(make_study):
    scenario = make_study().scenario(make_study().missions[0])
    one = sensing_limit_m2(scenario.model_copy(update={"robots": 1, "steps": 300}))
    assert 122 <= one <= 150  # What was measured by hand, by direction.
    assert sensing_limit_m2(scenario.model_copy(update={"robots": 7, "steps": 300})) == 7 * one
    longer = scenario.model_copy(update={"robots": 1, "steps": 600})
    assert 1.8 * one < sensing_limit_m2(longer) < 2 * one


def test_the_order_of_rows_does_not_matter(with_values):
    study, frame = with_values(TWO_WORLDS, 4, lambda row: gain(row) + row["seed"] ** 2)
    shuffled = frame.sample(fraction=1.0, shuffle=True, seed=3)
    for one, other in zip(compare(study, frame), compare(study, shuffled), strict=True):
        assert sorted(one.differences) == sorted(other.differences)
        assert one.difference.value == pytest.approx(other.difference.value)
        assert one.p_holm == pytest.approx(other.p_holm)
