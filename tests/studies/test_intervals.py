"""The statistics hold what they promise: coverage by simulation, and laws beside references."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from swarmscout.studies.intervals import (
    Estimate,
    by_unit,
    holm,
    interquartile_mean,
    mean_interval,
    share_interval,
    sign_flip_p,
)
from swarmscout.studies.survival import times_to


def coverage(draw, estimate, truth, repeats=300):
    rng = np.random.default_rng(5)
    return float(np.mean([truth in estimate(draw(rng)) for _ in range(repeats)]))


# With 300 repeats a coverage of 95 % is seen as 91.5 to 98 % nearly always.
@pytest.mark.parametrize("n", [3, 5, 10, 19])
def test_few_values_are_covered_by_student(n):
    assert 0.915 <= coverage(lambda rng: rng.normal(100, 15, n), mean_interval, 100) <= 0.985


@pytest.mark.parametrize(("n", "shape"), [(20, "normal"), (20, "skewed"), (30, "skewed")])
def test_many_values_are_covered_by_the_bootstrap(n, shape):
    def draw(rng):
        return rng.normal(100, 15, n) if shape == "normal" else 50 * rng.gamma(4.0, 0.5, n)

    assert mean_interval(draw(np.random.default_rng(1))).method == "BCa"
    assert 0.90 <= coverage(draw, mean_interval, 100) <= 0.985


def test_a_percentile_bootstrap_of_five_would_not_do():
    """Why Student's t stands below 20: the test that this file's bounds can fail."""

    def percentile(x):
        rng = np.random.default_rng(0)
        found = stats.bootstrap((x,), np.mean, method="percentile", rng=rng, n_resamples=999)
        return Estimate(0.0, *found.confidence_interval)

    assert coverage(lambda rng: rng.normal(100, 15, 5), percentile, 100) < 0.90


@pytest.mark.parametrize("worlds", [4, 24])
def test_worlds_are_the_outer_level(worlds):
    """Seeds of one world share its luck: counting them as independent covers far too little."""

    def draw(rng):
        return (rng.normal(100, 15, worlds)[:, None] + rng.normal(0, 10, (worlds, 20))).ravel()

    names = np.repeat(np.arange(worlds), 20).tolist()

    def nested(x):
        return mean_interval([unit.mean() for unit in by_unit(x, names)])

    def flat(x):
        half = 1.96 * stats.sem(x)
        return Estimate(x.mean(), x.mean() - half, x.mean() + half)

    assert 0.90 <= coverage(draw, nested, 100) <= 0.985
    assert coverage(draw, flat, 100) < 0.80


@pytest.mark.parametrize("n", [6, 12, 20])
def test_interquartile_means_are_covered(n):
    assert 0.90 <= coverage(lambda rng: rng.normal(100, 15, n), interquartile_mean, 100) <= 0.99


def test_interquartile_means_ignore_the_ends():
    assert interquartile_mean([0, 1, 2, 3, 4, 5, 6, 7000]).value == pytest.approx(3.5)
    assert interquartile_mean(np.arange(40.0)).value == pytest.approx(19.5)


def test_shares_at_the_ends_have_intervals():
    everything = share_interval(20, 20)
    assert everything.value == 1.0
    assert 0.8 < everything.low < 0.9
    assert share_interval(0, 20).high == pytest.approx(1 - everything.low)
    reference = stats.binomtest(7, 20).proportion_ci(method="wilson")
    assert (share_interval(7, 20).low, share_interval(7, 20).high) == pytest.approx(
        tuple(reference)
    )


def test_p_is_right_under_no_difference_and_small_under_a_large_one():
    rng = np.random.default_rng(0)
    found = [sign_flip_p(rng.normal(0, 1, 8)) for _ in range(300)]
    assert 0.02 <= np.mean(np.array(found) < 0.05) <= 0.08
    assert sign_flip_p(rng.normal(3, 1, 30)) < 0.001
    assert sign_flip_p([1.0, 2.0, 3.0, 1.5, 2.5]) == pytest.approx(2 / 2**5)  # Exact for few.
    assert math.isnan(sign_flip_p([1.0]))
    assert sign_flip_p([0.0, 0.0]) == 1.0


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12))
def test_holm_by_its_definition(p_values):
    adjusted = holm(p_values)
    order = sorted(range(len(p_values)), key=lambda i: p_values[i])
    m = len(p_values)
    for rank, i in enumerate(order):
        direct = max(min(1.0, (m - j) * p_values[order[j]]) for j in range(rank + 1))
        assert adjusted[i] == pytest.approx(direct)
        assert adjusted[i] >= p_values[i]


def test_holm_leaves_out_what_has_no_p():
    assert holm([0.01, math.nan, 0.04]) == pytest.approx([0.02, math.nan, 0.04], nan_ok=True)


@given(
    st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=30),
    st.floats(0.5, 2.0),
    st.floats(-100, 100),
)
def test_intervals_hold_their_mean_and_follow_units(values, scale, shift):
    found = mean_interval(values)
    assert found.value == pytest.approx(np.mean(values), abs=1e-6)
    if found.method:
        assert found.low <= found.value + 1e-6
        assert found.high >= found.value - 1e-6
        if found.method == "t":
            moved = mean_interval(scale * np.array(values) + shift)
            assert moved.low == pytest.approx(scale * found.low + shift, rel=1e-6, abs=1e-3)


def test_nothing_is_made_of_nothing():
    assert math.isnan(mean_interval([]).value)
    one = mean_interval([3.0])
    assert (one.value, one.units, one.method) == (3.0, 1, "")
    assert mean_interval([2.0, 2.0, 2.0]).low == 2.0


def test_times_that_were_not_reached_are_censored():
    steps = np.array([100, 120, 140, np.nan, np.nan, np.nan, np.nan])
    found = times_to(steps, np.full(7, 300.0))
    assert (found.reached, found.n, found.median) == (3, 7, None)
    assert found.restricted.value == pytest.approx((360 + 4 * 300) / 7)
    found = times_to(np.array([100, 120, 140, 160, np.nan]), np.full(5, 300.0))
    assert found.median == 140
    assert found.median_low is not None
    assert found.median_low <= 140
    none = times_to(np.full(3, np.nan), np.full(3, 300.0))
    assert (none.reached, none.median, none.restricted.value) == (0, None, 300.0)


def test_medians_agree_with_plain_ones_where_nothing_is_censored():
    steps = np.random.default_rng(0).integers(50, 300, 101).astype(float)
    assert times_to(steps, np.full(101, 300.0)).median == np.median(steps)
