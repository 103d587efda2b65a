"""Estimates, p-values and labels as text for tables and sentences."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

from swarmscout.studies.intervals import Estimate

__all__ = [
    "code",
    "number",
    "p_text",
    "setting_text",
    "share_text",
    "with_interval",
    "world_text",
]

_NOTHING = "–"


def number(value: float, digits: int = 3) -> str:
    """A number with a given count of significant digits, and at most four decimals."""
    if not math.isfinite(value):
        return _NOTHING
    if value == 0.0:
        return "0"
    places = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:,.{min(places, 4)}f}"


def with_interval(estimate: Estimate, digits: int = 3, sign: bool = False) -> str:
    """``1.27 [1.20, 1.35]``, all three with the same number of decimals."""
    if not math.isfinite(estimate.value):
        return _NOTHING
    largest = max(abs(v) for v in (estimate.value, estimate.low, estimate.high) if math.isfinite(v))
    places = 2
    if largest > 0.0:
        places = min(4, max(0, digits - 1 - math.floor(math.log10(largest))))
    mark = "+" if sign else ""
    text = f"{estimate.value:{mark},.{places}f}"
    if not math.isfinite(estimate.low):
        return text
    return f"{text} [{estimate.low:{mark},.{places}f}, {estimate.high:{mark},.{places}f}]"


def share_text(estimate: Estimate) -> str:
    """``85 % [72, 93]``."""
    if not math.isfinite(estimate.value):
        return _NOTHING
    text = f"{100 * estimate.value:.0f} %"
    if not math.isfinite(estimate.low):
        return text
    return f"{text} [{100 * estimate.low:.0f}, {100 * estimate.high:.0f}]"


def p_text(p: float) -> str:
    """A p-value with three decimals, or "< 0.001"."""
    if math.isnan(p):
        return _NOTHING
    return "< 0.001" if p < 0.001 else f"{p:.3f}"


def code(value: Any) -> str:
    """A label or an error as Markdown code, so that nothing in it is markup."""
    text = " ".join(str(value).split())
    ticks = max((len(run) for run in re.findall("`+", text)), default=0)
    if not ticks:
        return f"`{text}`" if text else ""
    fence = "`" * (ticks + 1)
    return f"{fence} {text} {fence}"


def setting_text(names: Sequence[str], labels: Sequence[Any]) -> str:
    """``robots = 15, teams.desired_size = 3``."""
    return ", ".join(f"{name} = {label}" for name, label in zip(names, labels, strict=True))


def world_text(world: Sequence[Any]) -> str:
    """A world's name and seed."""
    return " ".join(str(part) for part in world if part is not None)
