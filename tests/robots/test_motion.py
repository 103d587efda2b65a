"""Motion: no robot is ever inside a wall or another robot, and nothing else stops it.

The oracle samples all straight ways of a step densely, at the same instants for all robots.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from swarmscout.core.enums import (
    FORWARD,
    LEFT,
    NO_CONTACT,
    RIGHT,
    ROBOT_CONTACT,
    STOP,
    WALL_CONTACT,
)
from swarmscout.robots.bodies import TICKS, Bodies, heading_table, place_bodies, to_ticks
from swarmscout.robots.motion import Motion
from swarmscout.worlds.world import World

TABLE = heading_table()
TURN = to_ticks(40.0)
# Discs may touch: the kernel lets them come nearer than that by a billionth of a metre.
SLACK = 2e-9

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass
class Arena:
    """A world and robots in it, moved by the kernel."""

    world: World
    bodies: Bodies
    radius_m: float
    forward_m: float
    edge_m: float | None = None
    steps: int = 0

    def __post_init__(self) -> None:
        robots = len(self.bodies.heading)
        self.motion = Motion(
            self.world, robots, self.radius_m, self.forward_m, TURN, TABLE, edge_m=self.edge_m
        )

    def step(self, action: Integers) -> None:
        self.steps += 1
        self.motion.carry_out(action, self.bodies, self.steps)


def offset_of(bodies: Bodies, i: int) -> Array:
    """Where robot i touched a wall, seen from its centre."""
    return np.array([bodies.touch["dx_m"][i], bodies.touch["dy_m"][i]])


def wall_corners(world: World) -> Array:
    """Lower left corners of the wall cells that border on a free cell; outside is wall."""
    free = np.pad(world.free != 0, 1)
    rows, cols = np.nonzero(~free & binary_dilation(free, np.ones((3, 3))))
    return (np.column_stack([cols, rows]) - 1) * world.resolution_m + np.array(world.origin_m)


def wall_distance(corners: Array, edge: float, points: Array) -> Array:
    """Distance from each point to the nearest of the squares."""
    low = corners[None] - points[:, None]
    gap = np.maximum(np.maximum(low, -low - edge), 0.0)
    return np.sqrt((gap**2).sum(axis=2).min(axis=1))


def along(start: Array, end: Array, instants: int) -> Array:
    """Points [instants, ..., 2] on straight ways."""
    t = np.linspace(0.0, 1.0, instants).reshape(-1, *[1] * start.ndim)
    return start + t * (end - start)


def random_arena(
    rng: np.random.Generator, *, robots: int, walls: float, resolution_m: float | None = None,
    radius_m: float | None = None, forward_m: float | None = None, size_m: float = 3.0,
) -> Arena:  # fmt: skip
    """Robots at random, clear of walls and of each other, in a random raster."""
    resolution = resolution_m or float(rng.choice([0.05, 0.1, 0.3, 0.7]))
    radius = radius_m or float(rng.choice([0.05, 0.15, 0.3]))
    forward = forward_m or float(rng.choice([0.1, 0.2, 0.6]))
    cells = int(size_m / resolution)
    while True:
        free = (rng.random((cells, cells + 1)) >= min(0.3, walls * resolution**2)).astype(np.uint8)
        world = World("test", free, resolution, tuple(rng.uniform(-3.0, 3.0, 2).tolist()))
        corners = wall_corners(world)
        left, right, bottom, top = world.extent
        points = rng.uniform((left, bottom), (right, top), (200, 2))
        cells_of = world.frame.cells_of(points)
        points = points[
            (wall_distance(corners, resolution, points) > radius)
            & (free[cells_of[:, 0], cells_of[:, 1]] == 1)
        ]
        placed: list[Array] = []
        for point in points:
            if all(np.hypot(*(point - other)) > 2.0 * radius for other in placed):
                placed.append(point)
        if placed:
            break
    position = np.array(placed[:robots])
    heading = rng.integers(0, TICKS, len(position))
    return Arena(world, place_bodies(position, heading, np.ones(len(position))), radius, forward)


def random_actions(rng: np.random.Generator, robots: int) -> Integers:
    """Mostly forward, so that robots come to touch things."""
    return rng.choice([STOP, FORWARD, LEFT, RIGHT], robots, p=[0.05, 0.75, 0.1, 0.1])


arenas = st.tuples(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.5, 2.0]))


@settings(max_examples=40)
@given(arenas)
def test_no_robot_is_ever_inside_a_wall_or_another_robot(drawn: tuple[int, float]) -> None:
    rng = np.random.default_rng(drawn[0])
    arena = random_arena(rng, robots=12, walls=drawn[1])
    bodies, edge = arena.bodies, arena.world.resolution_m
    corners = wall_corners(arena.world)
    for _ in range(25):
        before = bodies.position.copy()
        arena.step(random_actions(rng, len(before)))
        moved = np.any(bodies.position != before, axis=1)
        ways = along(before, bodies.position, 50)
        if moved.any():
            points = ways[:, moved].reshape(-1, 2)
            assert wall_distance(corners, edge, points).min() >= arena.radius_m - SLACK
        for i, j in combinations(range(len(before)), 2):
            gap = np.hypot(*(ways[:, i] - ways[:, j]).T).min()
            assert gap >= 2.0 * arena.radius_m - SLACK


@settings(max_examples=40)
@given(arenas)
def test_a_forward_move_fails_exactly_where_something_is_in_the_way(
    drawn: tuple[int, float],
) -> None:
    rng = np.random.default_rng(drawn[0])
    arena = random_arena(rng, robots=10, walls=drawn[1])
    bodies, radius, forward = arena.bodies, arena.radius_m, arena.forward_m
    corners = wall_corners(arena.world)
    robots = len(bodies.position)
    instants = 101
    # A disc comes at most half of this nearer between two instants than at them.
    spacing = forward / (instants - 1)
    for _ in range(10):
        before, heading = bodies.position.copy(), bodies.heading.copy()
        bodies.can["drive"] = rng.random(robots) < 0.85
        action = random_actions(rng, robots)
        arena.step(action)
        moved = np.any(bodies.position != before, axis=1)
        turn = np.select([action == LEFT, action == RIGHT], [TURN, -TURN], 0)
        assert np.array_equal(bodies.heading, (heading + turn * bodies.can["drive"]) % TICKS)
        # Who comes first rotates; each sees earlier ones as they really moved, later ones standing.
        order = [(k + arena.steps) % robots for k in range(robots)]
        for rank, i in enumerate(order):
            if action[i] != FORWARD or not bodies.can["drive"][i]:
                assert not moved[i]
                assert bodies.contact[i] == NO_CONTACT
                assert bodies.touch["robot"][i] == -1
                continue
            angle = 2.0 * np.pi * heading[i] / TICKS
            goal = before[i] + forward * np.array([np.cos(angle), np.sin(angle)])
            way = along(before[i], goal, instants)
            wall = wall_distance(corners, arena.world.resolution_m, way).min()
            gaps = np.full(robots, np.inf)
            for j in order:
                if j != i:
                    earlier = j in order[:rank]
                    other = along(before[j], bodies.position[j] if earlier else before[j], instants)
                    gaps[j] = np.hypot(*(way - other).T).min()
            if bodies.contact[i] == NO_CONTACT:
                assert np.allclose(bodies.position[i], goal, rtol=0.0, atol=1e-12)
                assert wall >= radius - SLACK
                assert gaps.min() >= 2.0 * radius - SLACK
                assert bodies.touch["robot"][i] == -1
            elif bodies.contact[i] == WALL_CONTACT:
                assert not moved[i]
                assert wall < radius + spacing
                assert bodies.touch["robot"][i] == -1
            else:
                assert not moved[i]
                assert bodies.contact[i] == ROBOT_CONTACT
                assert wall >= radius - SLACK
                # Two discs may both move, so the gap can change twice as fast.
                assert gaps[bodies.touch["robot"][i]] < 2.0 * radius + 2.0 * spacing


@settings(max_examples=100)
@given(arenas)
def test_a_wall_contact_says_where_the_wall_is(drawn: tuple[int, float]) -> None:
    rng = np.random.default_rng(drawn[0])
    arena = random_arena(rng, robots=8, walls=drawn[1])
    bodies, frame = arena.bodies, arena.world.frame
    for _ in range(10):
        arena.step(np.full(len(bodies.heading), FORWARD))
        for i in np.flatnonzero(bodies.contact == WALL_CONTACT):
            offset = offset_of(bodies, i)
            row, col = frame.cell_of(*(bodies.position[i] + offset))
            assert not frame.contains(row, col) or arena.world.free[row, col] == 0
            assert np.hypot(*offset) <= arena.radius_m + arena.forward_m + frame.cell_m
            # It is the wall ahead, not one behind the robot's back.
            ahead = offset @ TABLE[bodies.heading[i]]
            assert ahead >= -arena.radius_m - 1e-9


def test_robots_far_from_everything_always_move() -> None:
    rng = np.random.default_rng(5)
    world = World("plain", np.ones((300, 300), dtype=np.uint8), 0.1)
    grid = np.stack(np.meshgrid(np.arange(5), np.arange(5)), axis=-1).reshape(-1, 2)
    arena = Arena(
        world, place_bodies(3.0 + 6.0 * grid, rng.integers(0, TICKS, 25), np.ones(25)), 0.15, 0.2
    )
    for _ in range(12):  # At most 2.4 m each.
        before = arena.bodies.position.copy()
        action = random_actions(rng, 25)
        arena.step(action)
        made = np.hypot(*(arena.bodies.position - before).T)
        assert np.allclose(made, np.where(action == FORWARD, 0.2, 0.0), rtol=0.0, atol=1e-12)
        assert (arena.bodies.contact == NO_CONTACT).all()


@settings(max_examples=40)
@given(arenas)
def test_how_others_are_looked_up_changes_nothing(drawn: tuple[int, float]) -> None:
    def run(edge_m: float | None) -> list[NDArray[np.generic]]:
        rng = np.random.default_rng(drawn[0])
        arena = random_arena(rng, robots=15, walls=drawn[1], radius_m=0.15, forward_m=0.2)
        arena.edge_m = edge_m
        arena.__post_init__()
        seen: list[NDArray[np.generic]] = []
        for _ in range(20):
            arena.step(random_actions(rng, len(arena.bodies.heading)))
            bodies = arena.bodies
            seen += [bodies.position.copy(), bodies.heading.copy(), bodies.contact.copy()]
            seen += [bodies.touch["robot"].copy()]
        return seen

    usual = run(None)
    for edge_m in (0.71, 1.7, 100.0):
        for a, b in zip(usual, run(edge_m), strict=True):
            assert np.array_equal(a, b)


@given(st.integers(0, TICKS - 1), st.sampled_from([LEFT, RIGHT]))
def test_nine_turns_make_a_circle(start: int, way: int) -> None:
    world = World("plain", np.ones((10, 10), dtype=np.uint8), 0.1)
    bodies = place_bodies(np.array([[0.5, 0.5]]), np.array([start]), np.ones(1))
    arena = Arena(world, bodies, 0.15, 0.2)
    sign = 1 if way == LEFT else -1
    for turns in range(1, 10):
        arena.step(np.array([way]))
        assert bodies.heading[0] == (start + sign * turns * 400) % 3600
        assert bodies.position.tolist() == [[0.5, 0.5]]
    assert bodies.heading[0] == start


def test_headings_point_where_they_say() -> None:
    angles = np.arange(TICKS) * 2.0 * np.pi / TICKS
    assert np.allclose(TABLE, np.column_stack([np.cos(angles), np.sin(angles)]), atol=1e-14)
    exact = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]
    assert TABLE[[0, 900, 1800, 2700]].tolist() == exact
    bodies = place_bodies(np.zeros((2, 2)), np.array([-900, 4500]), np.ones(2))
    assert bodies.heading.tolist() == [2700, 900]
    assert bodies.pose[:, 2] == pytest.approx([1.5 * np.pi, 0.5 * np.pi])


def test_a_robot_that_touches_a_wall_can_leave_it() -> None:
    world = World("room", np.ones((20, 20), dtype=np.uint8), 0.1)
    # 0.15 + 8 × 0.2 = 1.75, so the robot stands exactly at the wall before it turns round.
    arena = Arena(world, place_bodies(np.array([[0.25, 1.0]]), np.zeros(1), np.ones(1)), 0.15, 0.2)
    for _ in range(9):
        arena.step(np.array([FORWARD]))
    assert arena.bodies.contact[0] == WALL_CONTACT
    assert arena.bodies.position[0, 0] == pytest.approx(1.85)
    arena.bodies.heading[0] = 1800
    arena.step(np.array([FORWARD]))
    assert arena.bodies.contact[0] == NO_CONTACT
    assert arena.bodies.position[0, 0] == pytest.approx(1.65)


def test_two_robots_that_drive_through_each_other_do_not() -> None:
    """Both would end clear of the other: what counts is the way, not its end."""
    world = World("plain", np.ones((20, 40), dtype=np.uint8), 0.1)
    start = np.array([[1.0, 1.0], [1.25, 1.0]])
    arena = Arena(world, place_bodies(start, np.array([0, 1800]), np.ones(2)), 0.1, 0.6)
    arena.step(np.array([FORWARD, FORWARD]))
    assert arena.bodies.contact.tolist() == [ROBOT_CONTACT, ROBOT_CONTACT]
    assert np.array_equal(arena.bodies.position, start)
    assert arena.bodies.touch["robot"].tolist() == [1, 0]


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.floats(0.05, 0.95))
def test_small_robots_do_not_jump_over_thin_walls(seed: int, across: float) -> None:
    """A long move starts and ends clear of a wall, and of its corners, yet crosses it."""
    rng = np.random.default_rng(seed)
    free = np.ones((9, 9), dtype=np.uint8)
    free[4, 4] = 0
    world = World("pillar", free, 0.3)
    target = 1.2 + 0.3 * np.array([across, rng.uniform(0.05, 0.95)])
    heading = int(rng.integers(TICKS))
    start = target - rng.uniform(0.25, 0.55) * TABLE[heading]
    arena = Arena(world, place_bodies(start[None], np.array([heading]), np.ones(1)), 0.02, 0.6)
    arena.step(np.array([FORWARD]))
    assert arena.bodies.contact[0] == WALL_CONTACT
    assert np.array_equal(arena.bodies.position[0], start)
    touched = start + offset_of(arena.bodies, 0)
    assert world.frame.cell_of(*touched) == (4, 4)


def test_dead_robots_never_move_and_stay_in_the_way() -> None:
    world = World("plain", np.ones((20, 40), dtype=np.uint8), 0.1)
    start = np.array([[1.0, 1.0], [1.35, 1.0]])
    arena = Arena(world, place_bodies(start, np.array([0, 0]), np.ones(2)), 0.15, 0.2)
    arena.bodies.can["drive"][1] = False
    for action in (FORWARD, LEFT, RIGHT, STOP):
        arena.step(np.array([FORWARD, action]))
        assert np.array_equal(arena.bodies.position, start)
        assert arena.bodies.heading.tolist() == [0, 0]
        assert arena.bodies.contact.tolist() == [ROBOT_CONTACT, NO_CONTACT]
        assert arena.bodies.touch["robot"].tolist() == [1, -1]
