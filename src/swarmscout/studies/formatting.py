"""Numbers as words: estimates, p-values and labels as tables and sentences show them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from swarmscout.studies.intervals import Estimate

__all__ = ["number", "p_words", "share", "told_setting", "told_world", "with_interval"]


def number(value: float, digits: int = 3) -> str:
    """A number with so many digits that count, and no more than two behind the point if large."""
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    places = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:,.{min(places, 4)}f}"


def with_interval(estimate: Estimate, digits: int = 3, sign: bool = False) -> str:
    """``1.27 [1.20, 1.35]``; all three with the same places behind the point."""
    if not math.isfinite(estimate.value):
        return "–"
    largest = max(abs(v) for v in (estimate.value, estimate.low, estimate.high) if math.isfinite(v))
    places = 2
    if largest > 0.0:
        places = min(4, max(0, digits - 1 - math.floor(math.log10(largest))))
    mark = "+" if sign else ""
    told = f"{estimate.value:{mark},.{places}f}"
    if not math.isfinite(estimate.low):
        return told
    return f"{told} [{estimate.low:{mark},.{places}f}, {estimate.high:{mark},.{places}f}]"


def share(estimate: Estimate) -> str:
    """``85 % [72 %, 93 %]``."""
    if not math.isfinite(estimate.value):
        return "–"
    told = f"{100 * estimate.value:.0f} %"
    if not math.isfinite(estimate.low):
        return told
    return f"{told} [{100 * estimate.low:.0f}, {100 * estimate.high:.0f}]"


def p_words(p: float) -> str:
    """A p-value; "< 0.001" below that."""
    if math.isnan(p):
        return "–"
    return "< 0.001" if p < 0.001 else f"{p:.3f}"


def told_setting(setting: Sequence[Any]) -> str:
    """A setting's labels in a row."""
    return " · ".join(str(label) for label in setting)


def told_world(world: Sequence[Any]) -> str:
    """A world's name and seed."""
    return " ".join(str(part) for part in world if part is not None)
