"""Law 8: the quantile selector is the paper's baseline.

"A quantile value is then sampled from a normal distribution with a robot-specific biased mean and a
standard deviation of 0.02, clipped to the range [0, 1]. For each robot, this mean is uniformly
sampled from the range [0.10, 0.25] at the start of each simulation. The frontier cell at the
corresponding distance quantile is selected as the target."
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from swarmscout.core.enums import FREE, UNKNOWN
from swarmscout.destinations.quantile import Quantile
from swarmscout.destinations.view import LeaderView
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.testing import leader_view, situations, small_world

PROFILE = settings(max_examples=40, deadline=None, derandomize=True, database=None)


def slow_choice(view: LeaderView, bias: float | None, rule: Quantile) -> tuple[Any, float, float]:
    """The definition, with sorting and loops, and the same draws."""
    if bias is None:
        bias = view.character.uniform(rule.bias_min, rule.bias_max)
    sampled = view.rng.normal(bias, rule.sigma)
    quantile = 0.0 if sampled < 0.0 else 1.0 if sampled > 1.0 else sampled
    listed = []
    for row, col in view.frontiers.tolist():
        x_m, y_m = view.frame.centre_of(row, col)
        dx, dy = x_m - view.position_m[0], y_m - view.position_m[1]
        listed.append((math.sqrt(dx * dx + dy * dy), row, col))
    _, row, col = sorted(listed)[round(quantile * (len(listed) - 1))]
    return (row, col), quantile, bias


def at(view: LeaderView, *, seed: int = 0, robot: int = 0, step: int = 1) -> LeaderView:
    """The same view for another mission, robot or step."""
    return dataclasses.replace(view, _seed=seed, robot=robot, step=step)


@PROFILE
@given(
    seed=st.integers(0, 10**6),
    share=st.floats(0.05, 0.9),
    low=st.floats(0.0, 1.0),
    high=st.floats(0.0, 1.0),
    sigma=st.sampled_from([0.0, 0.02, 0.4]),
)
def test_the_choice_is_the_definitions(
    seed: int, share: float, low: float, high: float, sigma: float
) -> None:
    rng = np.random.default_rng(seed)
    labels = np.where(rng.random((14, 17)) < share, FREE, UNKNOWN).astype(np.uint8)
    labels[7, 8] = FREE
    labels[7, 9] = UNKNOWN
    view = leader_view(labels, (7, 8), step=int(rng.integers(1, 300)), seed=seed)
    rule = Quantile(min(low, high), max(low, high), sigma)
    memory = None
    for step in range(3):
        here = at(view, seed=seed, step=step + 1)
        choice = rule.choose(here, memory)
        cell, quantile, bias = slow_choice(at(view, seed=seed, step=step + 1), memory, rule)
        assert choice.cell == cell
        assert choice.memory == bias
        assert choice.details["quantile"] == quantile
        memory = choice.memory


@pytest.mark.parametrize("number", range(10))
def test_the_choice_is_the_definitions_in_rare_situations(number: int) -> None:
    situation = list(situations(number))[number]
    cell, _, _ = slow_choice(at(situation.view), None, Quantile())
    assert Quantile().choose(at(situation.view), None).cell == cell


@pytest.fixture(scope="module")
def view() -> LeaderView:
    labels = np.full((40, 40), UNKNOWN, dtype=np.uint8)
    y, x = np.mgrid[0:40, 0:40]
    labels[np.hypot(y - 20, x - 19) < 12] = FREE
    return leader_view(labels, (18, 22))


def test_biases_are_uniform_over_seeds_and_over_robots(view: LeaderView) -> None:
    rule = Quantile()
    by_seed = [rule.choose(at(view, seed=s), None).memory for s in range(600)]
    by_robot = [rule.choose(at(view, robot=r), None).memory for r in range(600)]
    for biases in (by_seed, by_robot):
        assert 0.10 <= min(biases) < 0.11
        assert 0.24 < max(biases) <= 0.25
        assert stats.kstest(biases, stats.uniform(0.10, 0.15).cdf).pvalue > 0.01
    assert len(set(by_seed)) == 600
    assert abs(np.corrcoef(by_seed[:-1], by_seed[1:])[0, 1]) < 0.1


def test_quantiles_scatter_by_sigma_round_the_bias(view: LeaderView) -> None:
    rule = Quantile()
    choices = [rule.choose(at(view, step=s), 0.2) for s in range(1000)]
    scatter = [choice.details["quantile"] - 0.2 for choice in choices]
    assert stats.kstest(scatter, stats.norm(0.0, 0.02).cdf).pvalue > 0.01
    assert np.std(scatter) == pytest.approx(0.02, rel=0.08)
    n = len(view.frontiers)
    for choice in choices:
        assert choice.details["rank"] == round(choice.details["quantile"] * (n - 1))
    by_rank = np.sort(view.distances_m)
    for choice in choices[:50]:
        row, col = choice.cell
        index = int(np.flatnonzero((view.frontiers == (row, col)).all(axis=1))[0])
        assert view.distances_m[index] == by_rank[choice.details["rank"]]


def test_quantiles_are_clipped(view: LeaderView) -> None:
    low = Quantile(0.0, 0.0, 0.5)
    quantiles = [low.choose(at(view, step=s), None).details["quantile"] for s in range(400)]
    assert min(quantiles) == 0.0
    assert max(quantiles) == 1.0
    assert np.mean(np.array(quantiles) == 0.0) == pytest.approx(0.5, abs=0.08)
    # P(N(0, 0.5) > 1) = 0.023.
    assert 0.0 < np.mean(np.array(quantiles) == 1.0) < 0.06
    nearest, farthest = Quantile(0.0, 0.0, 0.0), Quantile(1.0, 1.0, 0.0)
    ends = [rule.choose(at(view), None).details["rank"] for rule in (nearest, farthest)]
    assert ends == [0, len(view.frontiers) - 1]


def test_ranks_round_to_the_nearest_and_ties_go_by_cell() -> None:
    labels = np.full((9, 9), UNKNOWN, dtype=np.uint8)
    labels[3:6, 3:6] = FREE
    view = leader_view(labels, (4, 4))
    # Eight frontiers: four at 0.5 m, four at 0.707 m, each group by row and column.
    expected = [(3, 4), (4, 3), (4, 5), (5, 4), (3, 3), (3, 5), (5, 3), (5, 5)]
    for rank, cell in enumerate(expected):
        for nudge in (-0.49, 0.0, 0.49):
            q = min(1.0, max(0.0, (rank + nudge) / 7.0))
            assert Quantile(q, q, 0.0).choose(at(view), None).cell == cell


def test_in_a_mission_a_robot_keeps_its_bias_and_others_have_others() -> None:
    decisions: list[Any] = []

    class Keep:
        def begin(self, mission: Any) -> None: ...
        def record(self, record: Any) -> None:
            decisions.extend(record.decisions)

        def end(self, summary: Any) -> None: ...

    Mission(Scenario(robots=10, steps=200, seed=3), world=small_world(3), recorder=Keep()).run()
    biases: dict[int, set[float]] = {}
    for decision in decisions:
        biases.setdefault(decision.leader, set()).add(decision.details["bias"])
    assert len(decisions) > 15
    assert len(biases) > 2
    assert all(len(values) == 1 for values in biases.values())
    assert len(set.union(*biases.values())) == len(biases)


@pytest.mark.parametrize(
    ("parameters", "says"),
    [
        ((-0.1, 0.2, 0.02), "bias_min = -0.1: should be greater than or equal to 0"),
        ((0.3, 0.2, 0.02), "bias_min = 0.3 is above bias_max = 0.2"),
        ((0.1, 1.2, 0.02), "bias_max = 1.2: should be less than or equal to 1"),
        ((0, 1, -1), "sigma = -1: should be greater than or equal to 0"),
    ],
)
def test_impossible_parameters_are_refused(parameters: tuple[float, ...], says: str) -> None:
    with pytest.raises(ValueError, match=f"^{says}$"):
        Quantile(*parameters)
