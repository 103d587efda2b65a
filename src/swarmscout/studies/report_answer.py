"""The answer of a study: which combination is best, and what was compared with the baseline."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from swarmscout.studies.comparison import Label, Pairs
from swarmscout.studies.formatting import (
    code,
    number,
    p_text,
    setting_text,
    share_text,
    with_interval,
)
from swarmscout.studies.intervals import ALPHA, smallest_p
from swarmscout.studies.metrics import METRICS
from swarmscout.studies.ranking import Rank, Ranking
from swarmscout.studies.report_elements import Block, Heading, Picture, Table, Text, Warn
from swarmscout.studies.report_figures import MOST_PANELS, heat_map_figure

if TYPE_CHECKING:
    import polars as pl

    from swarmscout.studies.study import Study

__all__ = ["answer_blocks", "silent_models", "summary_lines", "verdict"]

_MOST_RANKS = 30
_MOST_CANDIDATES = 3
_MOST_LINES = 8


def answer_blocks(
    study: Study, frame: pl.DataFrame, pairs: Sequence[Pairs], ranking: Ranking | None
) -> Iterator[Block]:
    """The section *Answer*, with the ranking and the comparisons with the baseline."""
    yield Heading("Answer")
    if ranking is not None:
        yield from (Text(sentence) for sentence in _best(study, ranking, code))
    if silent := silent_models(frame):
        yield Warn(silent)
    if ranking is not None:
        yield from _ranking_blocks(study, ranking)
    yield Heading("Compared with the baseline")
    if not any(p.n for p in pairs):
        yield Text("There are no pairs yet.")
        return
    metric, baseline = METRICS[study.declared.metric], study.declared.compare.baseline
    name = metric.label if not metric.unit else f"{metric.label} in {metric.unit}"
    yield Text(
        f"Declared before the study ran: {name} (`{study.declared.metric}`), each value of "
        f"{code(study.compared.name)} against {code(baseline)}, in pairs with the same world and "
        "seed. Differences, ratios and shares have 95 % intervals; p is that of the paired test, "
        f"adjusted for {len(pairs)} comparison{'s' if len(pairs) > 1 else ''} (Holm)."
    )
    yield _pairs_table(study, pairs)


def summary_lines(
    study: Study, frame: pl.DataFrame, pairs: Sequence[Pairs], ranking: Ranking | None
) -> list[str]:
    """The answer in a few lines of plain text, for a terminal."""
    lines = [] if ranking is None else list(_best(study, ranking, str))
    names = study.setting_names
    better, baseline = METRICS[study.declared.metric].better, study.declared.compare.baseline
    unit = METRICS[study.declared.metric].unit
    for p in pairs[:_MOST_LINES]:
        where = f" ({setting_text(names, p.setting)})" if names else ""
        count = f"{p.n} pair{'s' if p.n != 1 else ''}"
        lines.append(
            f"{p.label} against {baseline}{where}: {with_interval(p.difference, sign=True)} "
            f"{unit}{' ' if unit else ''}in {count}: {verdict(p, better, len(pairs))}"
        )
    if len(pairs) > _MOST_LINES:
        lines.append(f"{len(pairs) - _MOST_LINES} more comparisons are in the report")
    if silent := silent_models(frame):
        lines.append(f"warning: {silent}")
    return lines


def silent_models(frame: pl.DataFrame) -> str:
    """A sentence when a language model was asked and never answered usefully; else nothing."""
    if not {"llm.asked", "llm.by_model"} <= set(frame.columns):
        return ""
    asked = frame.filter(frame["llm.asked"].fill_null(0) > 0)
    silent = asked.filter(asked["llm.by_model"].fill_null(0) == 0)
    if not silent.height:
        return ""
    return (
        f"In {silent.height} of {asked.height} missions that asked a language model, the model "
        "chose no destination: the fallback rule chose all of them. Those missions say nothing "
        "about the model."
    )


def verdict(p: Pairs, better: int, comparisons: int) -> str:
    """What the interval and the test, adjusted for all comparisons, say together."""
    if comparisons * smallest_p(p.difference.units) >= ALPHA and 0.0 not in p.difference:
        return f"too few {p.unit} to test"
    if not math.isfinite(p.difference.low) or 0.0 in p.difference or not p.p_holm < ALPHA:
        return "no evidence of a difference"
    up = p.difference.value > 0.0
    if better == 0:
        return "more" if up else "less"
    return "better" if up == (better > 0) else "worse"


def _best(study: Study, ranking: Ranking, label: Callable[[Label], str]) -> Iterator[str]:
    """Which combination is best and how sure that is; `label` writes a value."""
    metric = METRICS[study.declared.metric]
    best, others = ranking.ranks[0], len(ranking.ranks) - 1
    unit = f" {metric.unit}" if metric.unit else ""
    yield (
        f"Best: {_combination(ranking, best, label)}, with a mean {metric.label} of "
        f"{with_interval(best.mean)}{unit}."
    )
    if not ranking.is_tested:
        yield "There are too few pairs to say how sure that is."
        return
    candidates = ranking.candidates
    corrected = f"95 % confidence, corrected for {others} comparison{'s' if others > 1 else ''}"
    if len(candidates) == 1:
        behind = "the other combination" if others == 1 else f"all {others} other combinations"
        yield f"It is better than {behind} ({corrected})."
        return
    named = candidates[1 : 1 + _MOST_CANDIDATES]
    shown = "; ".join(_combination(ranking, rank, label) for rank in named)
    more = len(candidates) - 1 - _MOST_CANDIDATES
    yield (
        f"{len(candidates)} of {others + 1} combinations may be the best ({corrected}); besides "
        f"the one above: {shown}{f' and {more} more' if more > 0 else ''}."
    )


def _combination(ranking: Ranking, rank: Rank, label: Callable[[Label], str]) -> str:
    return setting_text(ranking.axes, [label(value) for value in rank.labels])


def _ranking_blocks(study: Study, ranking: Ranking) -> Iterator[Block]:
    metric = METRICS[study.declared.metric]
    unit = f" ({metric.unit})" if metric.unit else ""
    yield Heading("Ranking")
    yield Text(
        "Every combination beside the best, in pairs with the same world and seed. **Behind the "
        "best** has intervals that hold for all combinations together; p is that of being as good "
        "as the best, corrected for their number. Combinations with p below 0.05 are not the best."
    )
    rows = [
        [
            str(at + 1),
            *map(code, rank.labels),
            str(rank.missions),
            with_interval(rank.mean),
            "" if at == 0 else with_interval(rank.gap),
            "" if at == 0 else p_text(rank.p),
            "best" if at == 0 else "may be the best" if rank.may_be_best else "not the best",
        ]
        for at, rank in enumerate(ranking.ranks[:_MOST_RANKS])
    ]
    head = ["rank", *ranking.axes, "missions", metric.axis_label, f"behind the best{unit}", "p"]
    yield Table([*head, "verdict"], rows, numbers=1 + len(ranking.axes))
    if len(ranking.ranks) > _MOST_RANKS:
        yield Text(
            f"{len(ranking.ranks) - _MOST_RANKS} more combinations follow in `data/ranking`; the "
            f"last has a mean of {number(ranking.ranks[-1].mean.value)}."
        )
    if len(ranking.axes) > 1:
        yield _heat_map(study, ranking)


def _heat_map(study: Study, ranking: Ranking) -> Picture:
    metric = METRICS[study.declared.metric]
    others = ", ".join(map(code, ranking.axes[2:]))
    caption = (
        f"Mean {metric.label} over {code(ranking.axes[0])} and {code(ranking.axes[1])}"
        + (f", a panel for each value of {others} (at most {MOST_PANELS})" if others else "")
        + ". Solid frame: the best combination; dashed frames: combinations that may be the best."
    )
    figure = heat_map_figure(ranking, metric, study.compared.labels, study.settings[0].labels)
    return Picture("heat-map", figure, caption)


def _pairs_table(study: Study, pairs: Sequence[Pairs]) -> Table:
    metric = METRICS[study.declared.metric]
    settings = study.setting_names
    unit = f" ({metric.unit})" if metric.unit else ""
    header = [
        *settings, study.compared.name, "verdict", "pairs", f"difference{unit}",
        f"times {code(study.declared.compare.baseline)}", "better in", "p",
    ]  # fmt: skip
    rows = [
        [
            *map(code, p.setting),
            code(p.label),
            verdict(p, metric.better, len(pairs)),
            f"{p.n} in {p.difference.units} worlds" if p.unit == "worlds" else str(p.n),
            with_interval(p.difference, sign=True),
            with_interval(p.ratio),
            share_text(p.improvement),
            p_text(p.p_holm),
        ]
        for p in pairs
    ]
    return Table(header, rows, numbers=len(settings) + 2)
