"""The meaning of an answer in the leader's view: a frontier, or why it is not one."""

from __future__ import annotations

from swarmscout.core.enums import FREE, OCCUPIED
from swarmscout.destinations.llm.parse import Answer, InvalidAnswer
from swarmscout.destinations.llm.prompt_data import Encoded
from swarmscout.destinations.view import LeaderView

__all__ = ["cell_of_answer"]

Cell = tuple[int, int]


def cell_of_answer(answer: Answer, encoded: Encoded, view: LeaderView) -> Cell:
    """The frontier ``(row, col)`` that an answer means.

    Args:
        answer: as read.
        encoded: the view as the model saw it.
        view: what the leader knows.

    Raises:
        InvalidAnswer: it does not mean a frontier; the error says why.
    """
    if answer.point is None:
        for candidate in encoded.candidates:
            if candidate.id.casefold() == answer.id.casefold():
                return candidate.cell
        raise InvalidAnswer("unknown id", f"there is no candidate {answer.id}")
    x, y = answer.point
    cell = (y, x)
    if _is_choosable(cell, encoded, view):
        return cell
    raise _why_not(cell, encoded, view)


def _is_choosable(cell: Cell, encoded: Encoded, view: LeaderView) -> bool:
    if encoded.closed:
        return any(candidate.cell == cell for candidate in encoded.candidates)
    return bool((view.frontiers == cell).all(axis=1).any())


def _why_not(cell: Cell, encoded: Encoded, view: LeaderView) -> InvalidAnswer:
    y, x = cell
    frame = view.frame
    if (view.frontiers == cell).all(axis=1).any():
        return InvalidAnswer("no candidate", f"({x},{y}) is not among the candidates")
    if _is_choosable((x, y), encoded, view):
        return InvalidAnswer("swapped axes", f"({x},{y}) is not a frontier; mind the order x,y")
    if not frame.contains(y, x):
        return InvalidAnswer("outside the map", f"({x},{y}) lies outside the map")
    if cell == frame.cell_of(*view.position_m) or cell == frame.cell_of(*view.pose[:2]):
        return InvalidAnswer("own position", f"({x},{y}) is your own position, not a frontier")
    if cell == view.previous:
        return InvalidAnswer("stale frontier", f"({x},{y}) was your last destination")
    for x_m, y_m in view.others.positions_m.tolist():
        if frame.cell_of(x_m, y_m) == cell:
            return InvalidAnswer(
                "another team's position", f"({x},{y}) is another team's position, not a frontier"
            )
    label = view.labels[y, x]
    if label == OCCUPIED:
        return InvalidAnswer("obstacle", f"({x},{y}) is an obstacle")
    if label == FREE:
        return InvalidAnswer("no frontier", f"({x},{y}) is explored free ground, not a frontier")
    return InvalidAnswer("unexplored cell", f"({x},{y}) is not explored yet, not a frontier")
