"""A mission's summary in a dozen lines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from swarmscout.cli.llm_options import llm_line

if TYPE_CHECKING:
    from swarmscout.recording.run import Run

__all__ = ["summary_lines"]


def summary_lines(run: Run) -> list[str]:
    """The summary of a finished mission; figures that it lacks are left out.

    Args:
        run: a finished run.
    """
    figures = run.summary or {}
    lines = {
        "mission": _mission(figures),
        "task": _task(figures),
        "explored": _explored(figures),
        "over time": _series(figures.get("area_at_step"), "step {}", "{:.0f} m²"),
        "reached": _series(figures.get("time_to"), "{}", "step {:.0f}"),
        "teams": _teams(figures),
        "language model": llm_line(figures),
        "charging": _counts(figures, ("charges", "charges"), ("stranded", "stranded")),
        "driven": _driven(figures),
        "steps were": _shares(figures),
        "map": _shares_of(
            figures,
            ("map_accuracy", "right"),
            ("map_mixed_share", "part wall, part free (not counted)"),
            ("overlap_ratio", "seen twice"),
        ),
        "stranded": _stranded(figures, run.scenario.battery.return_rule),
    }
    width = max(len(name) for name, text in lines.items() if text)
    return [f"{name:<{width}}  {text}" for name, text in lines.items() if text]


def _mission(figures: Mapping[str, Any]) -> str:
    words = []
    if "world" in figures:
        words.append(f"{_robots(figures['robots'])} in {figures['world']}")
    if "selector" in figures:
        words.append(f"destinations by {figures['selector']}")
    if "seed" in figures:
        words.append(f"seed {figures['seed']}")
    steps = figures["steps"]
    words.append(f"{steps} step{'' if steps == 1 else 's'}, ended: {figures['end_reason']}")
    return ", ".join(words)


def _task(figures: Mapping[str, Any]) -> str:
    """The task and its score, but for exploration, whose score is the explored area."""
    task = figures.get("task", "exploration")
    return "" if task == "exploration" else f"{task}, score {figures['score']:g}"


def _robots(count: int) -> str:
    return "1 robot" if count == 1 else f"{count} robots"


def _stranded(figures: Mapping[str, Any], return_rule: str) -> str:
    """Robots with an empty battery, and what helps."""
    stranded, robots = figures.get("stranded") or 0, figures.get("robots") or 0
    if not stranded:
        return ""
    who = "the only robot" if robots == 1 else f"all {robots} robots"
    if stranded < robots:
        who = f"{stranded} of {robots} robots"
    text = f"{who} ran out of charge"
    if stranded == robots:
        text += ": none is left to explore"
    if return_rule == "threshold":
        return f"{text}; to return in time: --set battery.return_rule=distance"
    return f"{text}; a larger battery helps: --set battery.capacity_steps=…"


def _explored(figures: Mapping[str, Any]) -> str:
    text = f"{figures['explored_m2']:.1f} m²"
    if figures.get("explored_fraction") is not None:
        text += f", {figures['explored_fraction']:.1%} of what is reachable"
    if figures.get("reachable_m2") is not None:
        text += f" ({figures['reachable_m2']:.1f} m²)"
    return text


def _series(values: Any, key: str, value: str) -> str:
    """Pairs of a mapping, at most eight of them, evenly picked and with the last one."""
    pairs = [(k, v) for k, v in (values or {}).items() if v is not None]
    stride = -(-len(pairs) // 8)
    picked = pairs[::-1][:: max(1, stride)][::-1]
    return ", ".join(f"{key.format(k)}: {value.format(v)}" for k, v in picked)


def _teams(figures: Mapping[str, Any]) -> str:
    sizes = sorted(figures.get("teams") or [], reverse=True)
    parts = []
    if sizes:
        counted = {size: sizes.count(size) for size in sizes}
        groups = ", ".join(f"{n} × size {size}" for size, n in counted.items())
        parts.append(f"{len(sizes)} at the end ({groups})")
    moves = _counts(figures, ("joins", "joins"), ("leaves", "leaves"))
    return "; ".join([*parts, moves] if moves else parts)


def _counts(figures: Mapping[str, Any], *names: tuple[str, str]) -> str:
    return ", ".join(f"{figures[key]} {word}" for key, word in names if key in figures)


def _driven(figures: Mapping[str, Any]) -> str:
    distance = figures.get("distance_m")
    if distance is None:
        return ""
    total = sum(distance) if isinstance(distance, list) else distance
    return f"{total:.0f} m in all, {total / figures['robots']:.1f} m per robot"


def _shares(figures: Mapping[str, Any]) -> str:
    return _shares_of(
        figures, ("forward_share", "forward"), ("turn_share", "turns"), ("blocked_share", "blocked")
    )


def _shares_of(figures: Mapping[str, Any], *names: tuple[str, str]) -> str:
    return ", ".join(
        f"{figures[key]:.1%} {word}" for key, word in names if figures.get(key) is not None
    )
