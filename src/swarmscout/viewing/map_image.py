"""The occupancy map as data for pictures: labels, frontiers, colours of cells, and a window."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.enums import FREE, OCCUPIED, UNKNOWN
from swarmscout.mapping.log_odds import log_odds_of
from swarmscout.mission.scenario import Scenario
from swarmscout.recording.run import Run
from swarmscout.viewing.palette import LIGHT, Palette

__all__ = ["Window", "cell_codes", "frontier_cells", "labels_at", "labels_of", "map_image",
           "window_round"]  # fmt: skip

Window = tuple[float, float, float, float]
"""``(left, right, bottom, top)`` in metres."""

FRONTIER = 3
"""The code of a frontier cell in :func:`cell_codes`; free cells have ``FREE``."""


def labels_of(log_odds: NDArray[np.integer], scenario: Scenario) -> NDArray[np.uint8]:
    """uint8 labels (codes ``LABELS``) of log-odds in 1/1000 nat, by the scenario's thresholds."""
    labels = np.full(log_odds.shape, UNKNOWN, dtype=np.uint8)
    labels[log_odds < log_odds_of(scenario.map.free_below)] = FREE
    labels[log_odds > log_odds_of(scenario.map.occupied_above)] = OCCUPIED
    return labels


def labels_at(run: Run, step: int | None = None, robot: int | None = None) -> NDArray[np.uint8]:
    """uint8[rows, cols] labels (codes ``LABELS``) of a map after a step.

    Args:
        run: a run.
        step: None for the last.
        robot: the robot whose map it is; None for the swarm's.

    Raises:
        RunError: the step or robot does not exist, or the map was not recorded.
    """
    return labels_of(run.map_at(step, robot=robot), run.scenario)


def frontier_cells(labels: NDArray[np.uint8], neighbours: int = 8) -> NDArray[np.bool_]:
    """bool[rows, cols]: free cells beside an unknown one, see ``mapping.occupancy``.

    Source: paper, "Task description"; Yamauchi (1998).
    """
    rows, columns = labels.shape
    around = np.full((rows + 2, columns + 2), OCCUPIED, dtype=np.uint8)
    around[1:-1, 1:-1] = labels

    def shifted(down: int, across: int) -> NDArray[np.uint8]:
        return around[1 + down : 1 + down + rows, 1 + across : 1 + across + columns]

    open_to = np.zeros((rows, columns), dtype=np.bool_)
    for down, across in ((0, 1), (1, 0), (0, -1), (-1, 0)):
        open_to |= shifted(down, across) == UNKNOWN
    if neighbours == 8:
        for down, across in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            hidden = (shifted(down, 0) == OCCUPIED) & (shifted(0, across) == OCCUPIED)
            open_to |= (shifted(down, across) == UNKNOWN) & ~hidden
    open_to &= labels == FREE
    return open_to


def cell_codes(labels: NDArray[np.uint8], neighbours: int = 8) -> NDArray[np.uint8]:
    """uint8[rows, cols]: labels, with :data:`FRONTIER` for frontier cells."""
    codes = labels.copy()
    codes[frontier_cells(labels, neighbours)] = FRONTIER
    return codes


def map_image(
    labels: NDArray[np.uint8], neighbours: int = 8, palette: Palette = LIGHT
) -> NDArray[np.uint8]:
    """uint8[rows, cols, 3]: the map in a palette's colours; row 0 is the lowest.

    Args:
        labels: uint8[rows, cols] (codes ``LABELS``).
        neighbours: 4 or 8, which cells count as beside a frontier.
        palette: the colours.
    """
    return palette.cells[cell_codes(labels, neighbours)]


def window_round(points_m: NDArray[np.float64], margin_m: float) -> Window:
    """The window round points ``(x, y)`` [n, 2], with a margin."""
    (left, bottom), (right, top) = points_m.min(axis=0) - margin_m, points_m.max(axis=0) + margin_m
    return float(left), float(right), float(bottom), float(top)
