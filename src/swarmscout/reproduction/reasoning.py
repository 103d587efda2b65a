"""Fig. 5: one decision in full: candidates, their properties and the choice, beside the map."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from swarmscout.destinations.asking import AskingSelector, Talk
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.destinations.view import LeaderView
from swarmscout.mission.build import make_rule
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario_files import load_scenario
from swarmscout.reproduction.options import Options, said_of
from swarmscout.studies.report_elements import Block, Code, Picture, Table, Text
from swarmscout.viewing.drawing import show_image
from swarmscout.viewing.map_image import map_image, window_round
from swarmscout.viewing.palette import LIGHT
from swarmscout.viewing.player.page_text import page_text

__all__ = ["reasoning"]


@dataclass
class _Recorded:
    """A selector that keeps its decisions: the view as it was, and the choice."""

    rule: Selector
    kept: list[tuple[LeaderView, Choice, dict[str, Any]]] = field(default_factory=list)

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """The rule's choice."""
        return self._kept(view, self.rule.choose(view, memory))

    def _kept(self, view: LeaderView, choice: Choice) -> Choice:
        # Views look into the mission's arrays: what the figure needs is copied now.
        facts = {
            "labels": view.labels.copy(),
            "distances": view.distances_m.copy(),
            "frontier": view.frontier_neighbours.copy(),
            "obstacle": view.obstacle_neighbours.copy(),
            "positions": view.others.positions_m.copy(),
            "destinations": view.others.destinations_m.copy(),
            "chosen": int(np.flatnonzero((view.frontiers == choice.cell).all(axis=1))[0]),
        }
        scores = getattr(self.rule, "scores", None)
        if scores is not None:
            facts["score"] = scores(view)
        self.kept.append((view, choice, facts))
        return choice


@dataclass
class _RecordedAsking(_Recorded):
    """The same of a selector that asks a language model."""

    rule: AskingSelector
    prompt_tokens: int = 0

    def converse(self, view: LeaderView, memory: Any) -> Talk:
        """The rule's conversation."""
        choice = yield from self.rule.converse(view, memory)
        return self._kept(view, choice)


def reasoning(options: Options) -> list[Block]:
    """One decision of a mission with much to weigh: not the nearest cell, other teams around."""
    robots, steps = (8, 40) if options.quick else (15, 120)
    scenario = load_scenario(
        "paper",
        {"robots": robots, "steps": steps, "seed": 0, **options.keys},
    )
    rule = make_rule(scenario, None)
    recorded = _RecordedAsking(rule) if isinstance(rule, AskingSelector) else _Recorded(rule)
    mission = Mission(scenario, selector=recorded)
    try:
        mission.run()
    finally:
        mission.close()
    # Decisions of the second half: there is a map to reason about.
    late = [kept for kept in recorded.kept if kept[0].step > steps // 2] or recorded.kept
    view, choice, facts = max(late, key=_interest)
    shown = _candidates(facts)
    figure = Figure(figsize=(6.4, 5.6), layout="constrained")
    _draw(figure, view, facts, shown)
    title = textwrap.fill(f"A decision {said_of(options)}", 76)
    figure.suptitle(title, fontsize="small", parse_math=False)
    return [
        Text(
            "**The paper:** the language model lists candidates, weighs nearness, other teams' "
            "targets, frontier and obstacle neighbours, and takes a cell that need not be the "
            f"nearest. **Here:** robot {view.robot}, leader of {len(view.members)}, at step "
            f"{view.step} of a mission {said_of(options)}: {len(view.frontiers)} frontier cells, "
            f"{len(facts['positions'])} other teams. It needs a destination because: "
            f"{view.cause}."
        ),
        Picture(
            "reasoning", figure,
            "The leader's map at the decision: the leader's team (red), other teams (blue) and "
            "their targets (blue rings), numbered candidates, and the choice (purple).",
        ),
        _table(facts, shown),
        Text("The reason that the selector gave:"),
        Code(page_text(choice.reason).replace("```", "'''")),
    ]  # fmt: skip


def _interest(kept: tuple[LeaderView, Choice, dict[str, Any]]) -> float:
    view, _, facts = kept
    rank = int((facts["distances"] < facts["distances"][facts["chosen"]]).sum())
    heading = int(np.isfinite(facts["destinations"][:, 0]).sum())
    return min(rank, 8) + 2.0 * min(heading, 4) + min(len(view.members), 5)


def _candidates(facts: dict[str, Any]) -> list[int]:
    """The chosen cell, then the nearest, and those with most frontier and fewest obstacles."""
    orders = [
        [facts["chosen"]],
        np.argsort(facts["distances"], kind="stable")[:3].tolist(),
        np.argsort(1e-3 * facts["distances"] - facts["frontier"], kind="stable")[:2].tolist(),
        np.argsort(facts["obstacle"] + 1e-3 * facts["distances"], kind="stable")[:2].tolist(),
    ]
    if "score" in facts:
        orders.append(np.argsort(-facts["score"], kind="stable")[:3].tolist())
    return list(dict.fromkeys(index for order in orders for index in order))[:8]


def _to_others(facts: dict[str, Any], points: NDArray[np.float64]) -> NDArray[np.float64]:
    targets = facts["destinations"][np.isfinite(facts["destinations"][:, 0])]
    if not len(targets):
        return np.full(len(points), np.nan)
    gaps = points[:, None] - targets[None]
    nearest: NDArray[np.float64] = np.hypot(gaps[..., 0], gaps[..., 1]).min(axis=1)
    return nearest


def _table(facts: dict[str, Any], shown: list[int]) -> Table:
    header = ["candidate", "distance (m)", "frontier neighbours", "obstacle neighbours",
              "to another team's target (m)"]  # fmt: skip
    if "score" in facts:
        header.append("score")
    rows = []
    for at, index in enumerate(shown):
        apart = facts["apart"][index]
        row = [
            f"**{at + 1}, chosen**" if index == facts["chosen"] else str(at + 1),
            f"{facts['distances'][index]:.1f}",
            str(facts["frontier"][index]),
            str(facts["obstacle"][index]),
            f"{apart:.1f}" if np.isfinite(apart) else "–",
        ]
        if "score" in facts:
            row.append(f"{facts['score'][index]:.2f}")
        rows.append(row)
    return Table(header, rows)


def _draw(figure: Figure, view: LeaderView, facts: dict[str, Any], shown: list[int]) -> None:
    axes = figure.add_subplot()
    labels = facts["labels"]
    show_image(axes, view.frame, map_image(labels))
    axes.plot(*view.members_m.T, "o", color=LIGHT.explore, markersize=5, markeredgecolor="white")
    axes.plot(
        *facts["positions"].T, "s", color=LIGHT.stranded, markersize=5, markeredgecolor="white"
    )
    axes.plot(*facts["destinations"].T, "o", color=LIGHT.stranded, markersize=9, fillstyle="none")
    facts["apart"] = _to_others(facts, view.frontiers_m)
    cell = view.frame.cell_m
    for at, index in enumerate(shown):
        x, y = view.frontiers_m[index]
        chosen = index == facts["chosen"]
        colour = LIGHT.destination if chosen else LIGHT.selected
        axes.add_patch(
            Rectangle((x - cell / 2, y - cell / 2), cell, cell, fill=False, linewidth=1.8,
                      edgecolor=colour, zorder=5)
        )  # fmt: skip
        axes.text(x, y, str(at + 1), ha="center", va="center", fontsize="medium", zorder=6)
    points = np.concatenate([view.members_m, view.frontiers_m[shown]])
    left, right, bottom, top = window_round(points, 2.5)
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xlabel="x (m)", ylabel="y (m)")
