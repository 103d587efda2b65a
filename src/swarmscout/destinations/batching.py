"""Which rules choose in batches, and making a batch for each map."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarmscout.comms.knowledge import Knowledge
from swarmscout.destinations.batch import Batch, BatchSelector, Outcome
from swarmscout.destinations.candidates import Candidates
from swarmscout.destinations.leader_views import ViewSettings
from swarmscout.destinations.selector import Selector
from swarmscout.minds.minds import Minds

__all__ = ["Batching"]


class Batching:
    """Lets a rule choose for all leaders of a map in one call.

    Args:
        views: what choices depend on besides a robot's knowledge.
        rules: RENEWAL[1].
        needs_views: whether the task, or what counts as a team's position, needs views.
    """

    def __init__(self, views: ViewSettings, rules: NDArray[np.void], *, needs_views: bool) -> None:
        self._settings = views
        self._place_cells = int(rules["place_cells"][0])
        self._needs_views = needs_views
        self._able: dict[type, bool] = {}
        self._kept: dict[Hashable, Any] = {}

    def rule(self, selector: Selector) -> BatchSelector | None:
        """The selector, if it can choose in batches."""
        if self._needs_views:
            return None
        # Whether its class has the methods is looked up once, which takes as long as a choice.
        able = self._able.get(type(selector))
        if able is None:
            able = self._able[type(selector)] = isinstance(selector, BatchSelector)
        rule: Any = selector
        return rule if able and rule.chooses_in_batches() else None

    def outcomes(
        self,
        rule: BatchSelector,
        leaders: list[int],
        memories: Sequence[Any],
        minds: Minds,
        knowledge: Knowledge,
        candidates: Candidates,
        step: int,
    ) -> dict[int, Outcome]:
        """What the rule chooses, by leader; leaders whose map has no candidate are left out.

        Args:
            rule: the rule. leaders: who chooses. memories: of all robots.
            minds: what robots believe. knowledge: what they have heard.
            candidates: of the task, of this step. step: the current step.
        """
        rows: dict[int, list[int]] = {}
        for robot, row in zip(leaders, knowledge.ear[leaders].tolist(), strict=True):
            rows.setdefault(row, []).append(robot)
        found: dict[int, Outcome] = {}
        for row, robots in rows.items():
            if len(candidates.of_map(row).flat):
                batch = self._batch(row, robots, minds, knowledge, candidates, step)
                remembered = [memories[robot] for robot in robots]
                found.update(zip(robots, rule.choose_batch(batch, remembered), strict=True))
        return found

    def _batch(
        self,
        row: int,
        robots: list[int],
        minds: Minds,
        knowledge: Knowledge,
        candidates: Candidates,
        step: int,
    ) -> Batch:
        heard, notices = knowledge.heard[row], knowledge.notices
        noticed = ((notices["step"] == step) & (heard["step"] == step)).nonzero()[0]
        teams = notices["team"][noticed]
        order = np.argsort(teams, kind="stable")
        routed, mask = candidates.masks(row, robots)
        return Batch(
            step=step,
            seed=self._settings.seed,
            leaders=np.array(robots),
            minds=minds,
            heard=heard,
            teams=np.stack((teams[order], noticed[order])),
            frontiers=candidates.of_map(row),
            routed=routed,
            mask=mask,
            ticks=self._settings.ticks,
            silence_steps=self._settings.silence_steps,
            place_cells=self._place_cells,
            kept=self._kept,
        )
