"""Rankings and designs: error rates by simulation, and numbers worked out by hand."""

import math

import numpy as np
import polars as pl
import pytest
from scipy import stats
from small_studies import SMALL

from swarmscout.studies.design import Design, design_of
from swarmscout.studies.intervals import gap_to_best, sign_flip_p, smallest_p
from swarmscout.studies.ranking import rank_combinations

SWEEP = SMALL.replace("robots = 4\n", "").replace('"nearest"]', '"nearest", "random"]') + (
    "robots = [2, 3]\n"
)


def ranked(make_study, area, text=SWEEP, trials=6):
    study = make_study(text, trials=trials)
    frame = study.frame()
    areas = [float(area(row)) for row in frame.iter_rows(named=True)]
    frame = frame.with_columns(pl.lit("finished").alias("status"), pl.Series("explored_m2", areas))
    return study, frame, rank_combinations(study, frame)


def test_the_best_stands_first_and_gaps_are_paired(make_study):
    gains = {("nearest", 3): 20, ("random", 3): 10}

    def area(row):
        base = 100 + 50 * row["seed"]  # Seeds differ far more than combinations.
        return base + gains.get((row["destinations"], row["robots"]), 0) + 0.1 * (row["seed"] % 2)

    _, _, ranking = ranked(make_study, area)
    assert ranking.axes == ("destinations", "robots")
    assert [rank.labels for rank in ranking.ranks][:2] == [("nearest", 3), ("random", 3)]
    assert math.isnan(ranking.ranks[0].p)
    second = ranking.ranks[1]
    assert second.gap.value == pytest.approx(10)
    assert second.missions == 6


def test_close_combinations_may_both_be_the_best(make_study):
    noise = np.random.default_rng(1).normal(0, 3, 100)

    def area(row):
        best = row["destinations"] != "quantile" and row["robots"] == 3
        return (
            100 * best + noise[row["seed"] * 6 + row["robots"] * 3 + len(row["destinations"]) % 3]
        )

    _, _, ranking = ranked(make_study, area)
    assert {rank.labels for rank in ranking.candidates} == {("nearest", 3), ("random", 3)}
    assert ranking.is_tested


def test_less_is_better_where_less_is_better(make_study):
    text = SWEEP.replace("trials", 'metric = "overlap_ratio"\ntrials', 1)
    study = make_study(text, trials=3)
    frame = study.frame()
    values = [0.1 * row["seed"] + len(row["destinations"]) for row in frame.iter_rows(named=True)]
    frame = frame.with_columns(
        pl.lit("finished").alias("status"), pl.Series("overlap_ratio", values)
    )
    ranking = rank_combinations(study, frame)
    assert ranking.ranks[0].labels[0] == "random"  # The shortest name.
    assert all(rank.gap.value > -1e-9 for rank in ranking.ranks[1:])


@pytest.mark.parametrize("metric", ["joins", "distance_m"])
def test_without_a_better_direction_there_is_no_ranking(make_study, metric):
    text = SWEEP.replace("trials", f'metric = "{metric}"\ntrials', 1)
    assert ranked(make_study, lambda row: 1.0, text)[2] is None


def test_the_gap_is_students_paired_test_with_bonferroni():
    gaps = [3.0, 1.0, 2.0, 4.0, 2.5]
    estimate, p = gap_to_best(gaps, 4)
    reference = stats.ttest_1samp(gaps, 0.0, alternative="greater")
    assert p == pytest.approx(4 * reference.pvalue)
    half = stats.t.isf(0.05 / 4, 4) * stats.sem(gaps)
    assert (estimate.low, estimate.high) == pytest.approx((2.5 - half, 2.5 + half))
    for scale in (0.2, 0.5, 1.0, 2.0):  # The interval and the test agree.
        shifted = np.array(gaps) - 2.5 + scale
        estimate, p = gap_to_best(shifted, 4)
        assert (p < 0.05) == (estimate.low > 0.0)


def test_the_true_best_is_rarely_excluded():
    """Where all alternatives are equal, excluding any chosen one of them is an error."""
    rng = np.random.default_rng(3)
    repeats, wrong = 400, 0
    for _ in range(repeats):
        values = rng.normal(100, 10, (8, 6)) + rng.normal(0, 50, 8)[:, None]
        best = int(values.mean(axis=0).argmax())
        if best != 0:
            wrong += gap_to_best(values[:, best] - values[:, 0], 5)[1] < 0.05
    assert wrong / repeats <= 0.05


@pytest.mark.parametrize("units", [2, 5, 8, 13, 30])
def test_the_smallest_p_is_that_of_differences_of_one_sign(units):
    assert sign_flip_p(np.linspace(1, 2, units)) == pytest.approx(smallest_p(units), rel=0.01)


@pytest.mark.parametrize(
    ("worlds", "trials", "comparisons", "can_show", "needed"),
    [(1, 5, 1, False, 6), (1, 6, 1, True, 6), (8, 2, 12, False, 9), (9, 1, 12, True, 9),
     (1, 100, 250, False, None), (1, 1, 1, False, 6)],
)  # fmt: skip
def test_designs_that_show_nothing_are_known(worlds, trials, comparisons, can_show, needed):
    design = Design(worlds, trials, comparisons)
    assert design.can_show == can_show
    assert design.units_needed == needed
    assert can_show or design.is_weak
    assert ("cannot show any difference" in design.describe()) == (not can_show)


def test_the_detectable_difference_has_the_power_it_promises():
    design = Design(worlds=10, trials=1, comparisons=2)
    rng = np.random.default_rng(2)
    draws = rng.normal(design.detectable, design.scatter, (4000, 10))
    p = stats.ttest_1samp(draws, 0.0, axis=1).pvalue
    assert 0.75 < float((p < 0.05 / 2).mean()) < 0.85


def test_a_studys_design_counts_worlds_and_comparisons(make_study):
    design = design_of(make_study(SWEEP + "world_seed = [0, 1, 2]\n", trials=4))
    assert (design.worlds, design.trials, design.comparisons) == (3, 4, 4)
    assert (design.units, design.unit) == (3, "worlds")
    compared = SMALL.replace('"destinations"\nbaseline = "quantile"', '"world_seed"\nbaseline = 0')
    design = design_of(make_study(compared + "world_seed = [0, 1, 2]\n", trials=4))
    assert (design.worlds, design.unit, design.comparisons) == (1, "seeds", 4)
