"""Selectors that are wrong on purpose, each in one way, and what the check says of it."""

from __future__ import annotations

import random
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from swarmscout.destinations.selector import Choice


def first(view: Any) -> tuple[int, int]:
    row, col = view.frontiers[0].tolist()
    return row, col


class NoChoose:
    pass


class OneArgument:
    def choose(self, view: Any) -> Choice:
        return Choice(first(view))


class ReturnsNone:
    def choose(self, view: Any, memory: Any) -> Any:
        return None


class ReturnsTuple:
    def choose(self, view: Any, memory: Any) -> Any:
        return first(view)


class ReturnsFloats:
    def choose(self, view: Any, memory: Any) -> Choice:
        row, col = view.frontiers[0]
        return Choice((float(row), float(col)))  # type: ignore[arg-type]


class ReturnsMetres:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(tuple(view.frontiers_m[0]))


class ReturnsNoCell:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(None)  # type: ignore[arg-type]


class ReturnsIndex:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(0)  # type: ignore[arg-type]


class SwapsRowAndColumn:
    def choose(self, view: Any, memory: Any) -> Choice:
        row, col = view.frontiers[len(view.frontiers) // 3].tolist()
        return Choice((col, row))


class ChoosesOwnPlace:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(view.frame.cell_of(*view.position_m))


class WritesFrontiers:
    def choose(self, view: Any, memory: Any) -> Choice:
        view.frontiers[0] = 0
        return Choice(first(view))


class SortsFrontiers:
    def choose(self, view: Any, memory: Any) -> Choice:
        view.frontiers_m.sort(axis=0)
        return Choice(first(view))


class WritesField:
    def choose(self, view: Any, memory: Any) -> Choice:
        view.step = 3
        return Choice(first(view))


class UnlocksAndWrites:
    def choose(self, view: Any, memory: Any) -> Choice:
        cell = first(view)
        view.frontiers_m.flags.writeable = True
        view.frontiers_m[:] += 1.0
        view.frontiers_m.flags.writeable = False
        return Choice(cell)


class UnlocksLabels:
    def choose(self, view: Any, memory: Any) -> Choice:
        view.labels.flags.writeable = True
        view.labels[:] = 2
        return Choice(first(view))


class ForcesField:
    def choose(self, view: Any, memory: Any) -> Choice:
        object.__setattr__(view, "charge", 1.0)
        return Choice(first(view))


class CountsInItself:
    def __init__(self) -> None:
        self.calls = 0

    def choose(self, view: Any, memory: Any) -> Choice:
        self.calls += 1
        return Choice(first(view))


class CountsInItsClass:
    calls = 0

    def choose(self, view: Any, memory: Any) -> Choice:
        type(self).calls += 1
        return Choice(first(view))


@dataclass(frozen=True)
class FillsItsList:
    visited: list[Any] = field(default_factory=list)

    def choose(self, view: Any, memory: Any) -> Choice:
        self.visited.append(first(view))
        return Choice(first(view))


class OwnGenerator:
    def __init__(self) -> None:
        self.rng = np.random.default_rng(0)

    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(tuple(self.rng.choice(view.frontiers)))


class ChangesMemory:
    def choose(self, view: Any, memory: Any) -> Choice:
        memory = [] if memory is None else memory
        memory.append(first(view))
        return Choice(first(view), memory=memory)


class DrawsFromRandom:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(tuple(random.choice(view.frontiers.tolist())))


class DrawsFromNumpy:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(tuple(view.frontiers[np.random.randint(len(view.frontiers))]))  # noqa: NPY002


class DependsOnGlobalState:
    def choose(self, view: Any, memory: Any) -> Choice:
        index = random.getstate()[1][1] % len(view.frontiers)
        return Choice(tuple(view.frontiers[index]))


class FreshGenerator:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(tuple(np.random.default_rng().choice(view.frontiers)))


class LooksAtTheClock:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(first(view), reason=f"hour {time.time() // 3600}")


class ReadsSeed:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(first(view), reason=f"seed {view._seed}")


class ReadsMap:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(first(view), details={"sum": int(view._map.evidence.sum())})


class ReadsVars:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(first(view), reason=str(len(vars(view))))


class NumberAsReason:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(first(view), reason=3.0)  # type: ignore[arg-type]


class ViewAsDetails:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(first(view), details={"frame": view.frame})


class SetAsDetails:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(first(view), details={"seen": {1, 2}})


class ListAsDetails:
    def choose(self, view: Any, memory: Any) -> Choice:
        return Choice(first(view), details=[1])  # type: ignore[arg-type]


class NeedsTwoFrontiers:
    def choose(self, view: Any, memory: Any) -> Choice:
        second = np.argsort(view.distances_m, kind="stable")[1]
        return Choice(tuple(view.frontiers[second]))


class NeedsARoute:
    def choose(self, view: Any, memory: Any) -> Choice:
        costs = view.route_costs()
        reachable = np.flatnonzero(np.isfinite(costs))
        return Choice(tuple(view.frontiers[reachable[np.argmin(costs[reachable])]]))


class NeedsOthers:
    def choose(self, view: Any, memory: Any) -> Choice:
        places = view.others.positions_m
        nearest = np.hypot(*(places - np.array(view.position_m)).T).min()
        return Choice(first(view), reason=f"{nearest}")


class NeedsDestinations:
    def choose(self, view: Any, memory: Any) -> Choice:
        cells = [view.frame.cell_of(x, y) for x, y in view.others.destinations_m]
        return Choice(first(view), reason=f"{cells}")


class NeedsMembers:
    def choose(self, view: Any, memory: Any) -> Choice:
        others = view.members[view.members != view.robot]
        return Choice(first(view), reason=f"{others[0]}")


class NeedsFewFrontiers:
    def choose(self, view: Any, memory: Any) -> Choice:
        table = np.zeros(400)
        for k in range(len(view.frontiers)):
            table[k] = k
        return Choice(first(view))


class LooksBesideTheMap:
    def choose(self, view: Any, memory: Any) -> Choice:
        for row, col in view.frontiers.tolist():
            _ = [view.labels[row + d, col + d] for d in (-1, 0, 1)]
        return Choice(first(view))


ASKED: dict[Any, int] = {}


class RemembersElsewhere:
    """Keeps its memory where no single question shows it."""

    def choose(self, view: Any, memory: Any) -> Choice:
        key = view.step, view.robot, view.position_m
        ASKED[key] = ASKED.get(key, 0) + 1
        return Choice(tuple(view.frontiers[(ASKED[key] - 1) // 4 % len(view.frontiers)]))


MISTAKES: list[tuple[type, str]] = [
    (NoChoose, "has no method choose"),
    (OneArgument, "does not take two arguments"),
    (ReturnsNone, "returned None, not a Choice"),
    (ReturnsTuple, "returned tuple, not a Choice"),
    (ReturnsFloats, "whole numbers, not float"),
    (ReturnsMetres, "whole numbers, not float64"),
    (ReturnsNoCell, "chose None, which is not a cell"),
    (ReturnsIndex, "chose 0, which is not a cell"),
    (SwapsRowAndColumn, "not among view.frontiers"),
    (ChoosesOwnPlace, "not among view.frontiers"),
    (WritesFrontiers, "tries to change its view"),
    (SortsFrontiers, "tries to change its view"),
    (WritesField, "tries to change its view"),
    (UnlocksAndWrites, "changed its view"),
    (UnlocksLabels, "changed its view"),
    (ForcesField, "changed its view"),
    (CountsInItself, "changed itself (attribute 'calls')"),
    (CountsInItsClass, "changed itself (attribute 'CountsInItsClass.calls')"),
    (FillsItsList, "changed itself (attribute 'visited')"),
    (OwnGenerator, "changed itself (attribute 'rng')"),
    (ChangesMemory, "changed the memory"),
    (DrawsFromRandom, "draws from the global generator of random"),
    (DrawsFromNumpy, "draws from the global generator of numpy.random"),
    (DependsOnGlobalState, "depends on global randomness"),
    (FreshGenerator, "is not deterministic"),
    (LooksAtTheClock, "depends on the clock"),
    (ReadsSeed, "reads '_seed' of its view, which is private"),
    (ReadsMap, "reads '_map' of its view, which is private"),
    (ReadsVars, "reads '__dict__' of its view, which is private"),
    (NumberAsReason, "gave float as its reason, not text"),
    (ViewAsDetails, "details that cannot be kept as JSON (GridFrame"),
    (SetAsDetails, "details that cannot be kept as JSON (set"),
    (ListAsDetails, "gave list as its details, not a mapping"),
    (NeedsTwoFrontiers, "IndexError: index 1 is out of bounds"),
    (NeedsARoute, "(with frontiers to which no route leads)"),
    (NeedsOthers, "(with no other teams)"),
    (NeedsDestinations, "NaN"),
    (NeedsMembers, "(with a team of one)"),
    (NeedsFewFrontiers, "(with hundreds of frontiers)"),
    (LooksBesideTheMap, "(with frontiers and the leader at the map's edge)"),
    (RemembersElsewhere, "went differently when it was run again"),
]
